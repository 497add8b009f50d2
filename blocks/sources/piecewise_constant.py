"""Schedule: output = values[i] for times[i] <= t < times[i + 1]; the first value before, the last one after."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Buffer, param


class PiecewiseConstant(Block):
    """Value that changes at given times: switches, phases of a test, a set of operating points."""

    times: tuple[float, ...] = param("s", "Times at which the values begin, ascending.", default=(0.0,))
    values: tuple[float, ...] = param("{unit}", "The values, one for each time.", default=(0.0,))
    unit: str = param("", "Unit of the output.", default="1")

    knots = Buffer("The times.", float, ("times",))
    levels = Buffer("The values.", float, ("values",))


class State(NamedTuple):
    entry: int


class Constants(NamedTuple):
    slack: float


@PiecewiseConstant.requires
def requires(p: PiecewiseConstant) -> Iterator[tuple[str, str]]:
    if len(p.values) != len(p.times):
        yield "values", f"{len(p.times)} of them, as many as times"
    if any(after <= before for before, after in pairwise(p.times)):
        yield "times", "each after the one before"


@PiecewiseConstant.constants
def constants(p: PiecewiseConstant, period: float) -> Constants:
    return Constants(1.0e-6 * period)  # a tick that rounding puts just before an edge is on it


@PiecewiseConstant.start
def start(p: PiecewiseConstant, knots: list[float], levels: list[float]) -> State:
    for i in range(len(p.times)):
        knots[i] = p.times[i]
        levels[i] = p.values[i]
    return State(0)


def index_at(time: float, index: int, times: Sequence[float]) -> int:
    """Index of the last of ascending times that is not after `time`, searched from `index` on."""
    while index + 1 < len(times) and times[index + 1] <= time:
        index += 1
    return index


@PiecewiseConstant.output("{unit}")
def output(c: Constants, x: State, knots: list[float], levels: list[float], time: float) -> float:
    """The value of the time."""
    return levels[index_at(time + c.slack, x.entry, knots)]


@PiecewiseConstant.update
def update(c: Constants, x: State, knots: list[float], time: float) -> State:
    return State(index_at(time + c.slack, x.entry, knots))
