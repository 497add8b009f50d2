"""Edges of a band, and whether a filter passes or stops it."""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.bands import LARGEST_BAND_ORDER
from proofmass.blocks.declaration.declare import Block, param


class BandEdges(Block):
    """Parameters of a digital band-pass or band-stop."""

    order: int = param(
        "1", "Order of the prototype: half the number of poles.", default=2, at_least=1, at_most=LARGEST_BAND_ORDER
    )
    low_frequency: float = param("Hz", "Frequency at which it is down by 3 dB below the band.", default=80.0, above=0.0)
    high_frequency: float = param(
        "Hz", "Frequency at which it is down by 3 dB above the band.", default=120.0, above=0.0
    )
    stop: bool = param("", "Whether it stops the band, and passes all else.", default=False)
    unit: str = param("", "Unit of input and output.", default="1")


@BandEdges.requires
def ordered(p: BandEdges) -> Iterator[tuple[str, str]]:
    if p.high_frequency <= p.low_frequency:
        yield "high_frequency", f"more than low_frequency, {p.low_frequency:g} Hz"
