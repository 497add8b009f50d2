"""Quantiser: output = lowest + k step, k = rint((input - lowest) / step) held between 0 and levels - 1.

step = (highest - lowest) / (levels - 1); a tie goes to the even k. Two levels make a mid-rise
quantiser, as every even number of levels about zero does; an odd number has a level at zero
(mid-tread).
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import nearest_even_level
from proofmass.blocks.declaration.declare import Block, Input, param


class Quantiser(Block):
    """Uniform quantiser of any number of levels: of a multi-bit modulator, a coarse readout."""

    levels: int = param("1", "Number of levels.", default=3, at_least=2, at_most=1_000_000_000)
    lowest: float = param("{unit}", "The lowest level.", default=-1.0)
    highest: float = param("{unit}", "The highest level.", default=1.0)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to quantise.")


class Constants(NamedTuple):
    lowest: float
    step: float
    last: float


@Quantiser.requires
def requires(p: Quantiser) -> Iterator[tuple[str, str]]:
    if p.lowest >= p.highest:
        yield "lowest", f"less than highest = {p.highest:g}"


@Quantiser.constants
def constants(p: Quantiser, period: float) -> Constants:
    last = float(p.levels - 1)
    return Constants(p.lowest, (p.highest - p.lowest) / last, last)


@Quantiser.output("{unit}")
def output(c: Constants, input: float) -> float:
    """The nearest level."""
    return c.lowest + c.step * nearest_even_level((input - c.lowest) / c.step, c.last)


@Quantiser.output("1")
def code(c: Constants, input: float) -> int:
    """Number of the level, from 0."""
    return int(nearest_even_level((input - c.lowest) / c.step, c.last))
