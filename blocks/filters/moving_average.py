"""Moving average: y[n] = (u[n] + u[n-1] + ... + u[n-length+1]) / length, zero before tick 0."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class MovingAverage(Block):
    """Mean of the last samples; it takes out a disturbance whose period is `length` ticks, and its harmonics."""

    length: int = param("1", "Samples that are averaged.", default=10, at_least=1, at_most=1_000_000)
    unit: str = param("", "Unit of input and output.", default="1")

    input = Input("{unit}", "Signal to average.")

    line = Buffer("The last samples.", float, ("length",))


class State(NamedTuple):
    oldest: int  # its place in the line
    total: float  # of the line
    fresh: float  # of what has come since place 0: it replaces the total: rounding never adds up


@MovingAverage.output("{unit}")
def mean(p: MovingAverage, x: State, line: list[float], input: float) -> float:
    """The mean of this sample and those before."""
    return (x.total + (input - line[x.oldest])) / float(p.length)


@MovingAverage.update
def update(p: MovingAverage, x: State, line: list[float], input: float) -> State:
    total, fresh = x.total + (input - line[x.oldest]), x.fresh + input
    line[x.oldest] = input
    if x.oldest + 1 < p.length:
        return State(x.oldest + 1, total, fresh)
    return State(0, fresh, 0.0)
