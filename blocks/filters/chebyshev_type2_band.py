"""Inverse Chebyshev band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or one over that.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 7.1).
"""

from proofmass.blocks.arithmetic.bands import banded
from proofmass.blocks.arithmetic.prototypes import chebyshev_type2
from proofmass.blocks.arithmetic.sections import Sections, output, update
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.band_edges import BandEdges


class ChebyshevType2Band(BandEdges):
    """Digital band-pass or band-stop that is flat where it passes, and stops by some decibels."""

    low_frequency: float = param(
        "Hz", "Frequency at which the attenuation is reached below the band.", default=80.0, above=0.0
    )
    high_frequency: float = param(
        "Hz", "Frequency at which the attenuation is reached above the band.", default=120.0, above=0.0
    )
    attenuation: float = param(
        "1", "Decibels by which what is stopped is down, at least.", default=40.0, above=0.0, at_most=200.0
    )

    input = Input("{unit}", "Signal to filter.")


@ChebyshevType2Band.constants
def constants(p: ChebyshevType2Band, period: float) -> Sections:
    prototype = chebyshev_type2(p.order, p.attenuation)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


ChebyshevType2Band.output("{unit}")(output)
ChebyshevType2Band.update(update)
