"""Repeated sequence: output[n] = values[n mod N] in the block's n-th tick."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, param


class RepeatingSequence(Block):
    """A list of values played over and over, one each tick: a stimulus, a test pattern, a measured cycle."""

    values: tuple[float, ...] = param("{unit}", "The values of one repetition.", default=(0.0,))
    unit: str = param("", "Unit of the output.", default="1")

    levels = Buffer("The values.", float, ("values",))


class State(NamedTuple):
    place: int


class Constants(NamedTuple):
    length: int


@RepeatingSequence.constants
def constants(p: RepeatingSequence, period: float) -> Constants:
    return Constants(len(p.values))


@RepeatingSequence.start
def start(p: RepeatingSequence, levels: list[float]) -> State:
    for i in range(len(p.values)):
        levels[i] = p.values[i]
    return State(0)


@RepeatingSequence.output("{unit}")
def output(c: Constants, x: State, levels: list[float]) -> float:
    """The value of the tick."""
    return levels[x.place]


@RepeatingSequence.update
def update(c: Constants, x: State) -> State:
    return State(x.place + 1 if x.place + 1 < c.length else 0)
