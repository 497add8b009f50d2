"""Bessel band-pass or band-stop: its prototype with s = (s^2 + w0^2) / (b s), or one over that.

w0^2 = t1 t2, b = t2 - t1, t = tan(pi f T) at both edges; 2n poles (Oppenheim and Schafer, Discrete-Time Signal
Processing, section 7.1).
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.bands import LARGEST_BAND_ORDER, banded
from proofmass.blocks.arithmetic.prototypes import bessel
from proofmass.blocks.arithmetic.sections import Delays, Sections, filtered, moved
from proofmass.blocks.declaration.declare import Block, Input, param


class BesselBand(Block):
    """Digital band-pass or band-stop with a flat delay: bursts of a carrier pass with little ringing."""

    order: int = param(
        "1", "Order of the prototype: half the number of poles.", default=2, at_least=1, at_most=LARGEST_BAND_ORDER
    )
    low_frequency: float = param("Hz", "Frequency at which it is down by 3 dB below the band.", default=80.0, above=0.0)
    high_frequency: float = param(
        "Hz", "Frequency at which it is down by 3 dB above the band.", default=120.0, above=0.0
    )
    stop: bool = param("", "Whether it stops the band, and passes all else.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to filter.")


@BesselBand.requires
def requires(p: BesselBand) -> Iterator[tuple[str, str]]:
    if p.high_frequency <= p.low_frequency:
        yield "high_frequency", f"more than low_frequency, {p.low_frequency:g} Hz"


@BesselBand.constants
def constants(p: BesselBand, period: float) -> Sections:
    prototype = bessel(p.order)
    return banded(prototype, p.order, p.stop, p.low_frequency, p.high_frequency, period)


@BesselBand.output("{unit}")
def output(c: Sections, x: Delays, input: float) -> float:
    """The filtered signal."""
    return filtered(c, x, input)


@BesselBand.update
def update(c: Sections, x: Delays, input: float) -> Delays:
    return moved(c, x, input)
