"""Butterworth band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or its inverse.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer,
Discrete-Time Signal Processing, section 7.1).
"""

from proofmass.blocks.arithmetic.bands import banded
from proofmass.blocks.arithmetic.prototypes import butterworth
from proofmass.blocks.arithmetic.sections import Sections, output, update
from proofmass.blocks.declaration.declare import Input
from proofmass.blocks.parameter_sets.band_edges import BandEdges


class ButterworthBand(BandEdges):
    """Digital band-pass or band-stop of the flattest response: a carrier, a range of vibration."""

    input = Input("{unit}", "Signal to filter.")


@ButterworthBand.constants
def constants(p: ButterworthBand, period: float) -> Sections:
    prototype = butterworth(p.order)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


ButterworthBand.output("{unit}")(output)
ButterworthBand.update(update)
