"""Bessel band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or one over that.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 7.1).
"""

from proofmass.blocks.arithmetic.bands import banded
from proofmass.blocks.arithmetic.prototypes import bessel
from proofmass.blocks.arithmetic.sections import Sections, output, update
from proofmass.blocks.declaration.declare import Input
from proofmass.blocks.parameter_sets.band_edges import BandEdges


class BesselBand(BandEdges):
    """Digital band-pass or band-stop with a flat delay: bursts pass with little ringing."""

    input = Input("{unit}", "Signal to filter.")


@BesselBand.constants
def constants(p: BesselBand, period: float) -> Sections:
    prototype = bessel(p.order)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


BesselBand.output("{unit}")(output)
BesselBand.update(update)
