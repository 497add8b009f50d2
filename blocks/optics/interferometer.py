"""Two-wave interferometer: power = peak (1 + visibility cos(phase)) / 2 (Lefevre, The Fiber-Optic Gyroscope, 2014).

The mean over a fringe is half the peak, whatever the visibility: the power of both waves by
themselves.
"""

from proofmass.blocks.arithmetic.elementary import cosine
from proofmass.blocks.declaration.declare import Block, Input, param


class Interferometer(Block):
    """Power of two waves by their phase difference: of a Sagnac coil, a displacement sensor."""

    peak: float = param("W", "Power where the waves are in phase and the visibility is 1.", default=20e-6, at_least=0.0)
    visibility: float = param("1", "Contrast of the fringes.", default=1.0, at_least=0.0, at_most=1.0)

    phase = Input("rad", "Phase difference.")


@Interferometer.output("W")
def power(p: Interferometer, phase: float) -> float:
    """Power on the detector."""
    return 0.5 * p.peak * (1.0 + p.visibility * cosine(phase))
