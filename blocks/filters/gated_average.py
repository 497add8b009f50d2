"""Gated average: mean = (u[1] + ... + u[n]) / n over the last run of ticks in which `measure` was true."""

from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class GatedAverage(Block):
    """Average of a static test, begun and ended on command."""

    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to average.")
    measure = Input("1", "Whether the tick counts; a new average begins when it becomes true.", dtype=bool)


class State(NamedTuple):
    samples: int  # of the average under way
    total: float
    finished: float


@GatedAverage.output("{unit}")
def mean(p: GatedAverage, x: State) -> float:
    """The average of the ticks before, kept when it is finished; zero before the first."""
    return x.total / float(x.samples) if x.samples > 0 else x.finished


@GatedAverage.update
def update(p: GatedAverage, x: State, input: float, measure: bool) -> State:
    if measure:
        return State(x.samples + 1, x.total + input, x.finished)
    return State(0, 0.0, x.total / float(x.samples) if x.samples > 0 else x.finished)
