"""Chebyshev band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or one over that.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 7.1).
"""

from proofmass.blocks.arithmetic.bands import banded
from proofmass.blocks.arithmetic.prototypes import chebyshev_type1
from proofmass.blocks.arithmetic.sections import Sections, output, update
from proofmass.blocks.declaration.declare import Input, param
from proofmass.blocks.parameter_sets.band_edges import BandEdges


class ChebyshevType1Band(BandEdges):
    """Digital band-pass or band-stop of steeper edges than Butterworth's, for ripples."""

    low_frequency: float = param("Hz", "Frequency at which the ripple ends below the band.", default=80.0, above=0.0)
    high_frequency: float = param("Hz", "Frequency at which the ripple ends above the band.", default=120.0, above=0.0)
    ripple: float = param("1", "Ripple of the passband in decibels.", default=0.5, above=0.0, at_most=20.0)

    input = Input("{unit}", "Signal to filter.")


@ChebyshevType1Band.constants
def constants(p: ChebyshevType1Band, period: float) -> Sections:
    prototype = chebyshev_type1(p.order, p.ripple)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


ChebyshevType1Band.output("{unit}")(output)
ChebyshevType1Band.update(update)
