"""Mixer as phase detector: output = 2 first second / (first_amplitude second_amplitude).

Of A sin(f + d) and B cos(f) it is sin(d) + sin(2 f + d): the phase difference in rad where it is
small, and a ripple of twice the frequency (Gardner, Phaselock Techniques, 2005, chapter 10).
"""

from proofmass.blocks.declaration.declare import Block, Input, param


class PhaseMixer(Block):
    """Multiplier that measures how far two sines are from quadrature. Product has no scale."""

    first_amplitude: float = param("{first_unit}", "Amplitude of the first signal.", default=1.0, above=0.0)
    second_amplitude: float = param("{second_unit}", "Amplitude of the second signal.", default=1.0, above=0.0)
    first_unit: str = param("", "Unit of the first signal.", default="1")
    second_unit: str = param("", "Unit of the second signal.", default="1")

    first = Input("{first_unit}", "The signal.")
    second = Input("{second_unit}", "The oscillator, a quarter turn ahead.")


@PhaseMixer.output("rad")
def phase(p: PhaseMixer, first: float, second: float) -> float:
    """Phase by which the signal leads the quadrature of the oscillator, with the ripple."""
    return 2.0 * (first / p.first_amplitude) * (second / p.second_amplitude)
