"""Repeated sequence: output = values[n mod N] in the block's n-th tick."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, param


class RepeatingSequence(Block):
    """A list of values played over and over, one a tick: a stimulus, a test pattern, a cycle."""

    values: tuple[float, ...] = param("{unit}", "The values of one repetition.", default=(0.0,))
    unit: str = param("", "Unit of the output.", default="1")

    levels = Buffer("The values.", float, ("values",))


class Constants(NamedTuple):
    length: int


@RepeatingSequence.constants
def constants(p: RepeatingSequence, period: float) -> Constants:
    return Constants(len(p.values))


@RepeatingSequence.start
def start(p: RepeatingSequence, levels: list[float]) -> None:
    for i in range(len(p.values)):
        levels[i] = p.values[i]


@RepeatingSequence.output("{unit}")
def output(c: Constants, levels: list[float], tick: int) -> float:
    """The value of the tick."""
    return levels[tick % c.length]
