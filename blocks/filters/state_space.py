"""State space of order 1 to 4: x' = A x + B u, y = C x + D u; continuous.

States beyond the order stay zero: each decays by itself, at about the largest rate of the others.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param


class StateSpace(Block):
    """Linear analog system by its matrices. Wire a loop through `strictly_proper_part`."""

    transition: tuple[float, ...] = param("1/s", "A, row after row.", default=(0.0, 1.0, -1.0, -1.0))
    entry: tuple[float, ...] = param("1/s/({input_unit})", "B, one per state.", default=(0.0, 1.0))
    readout: tuple[float, ...] = param("{output_unit}", "C, one per state.", default=(1.0, 0.0))
    direct: float = param("({output_unit})/({input_unit})", "D.", default=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Input u of the system.")


class State(NamedTuple):
    x1: float
    x2: float
    x3: float
    x4: float


class Constants(NamedTuple):
    row1: tuple[float, float, float, float]
    row2: tuple[float, float, float, float]
    row3: tuple[float, float, float, float]
    row4: tuple[float, float, float, float]
    entry: tuple[float, float, float, float]
    readout: tuple[float, float, float, float]
    direct: float


@StateSpace.requires
def requires(p: StateSpace) -> Iterator[tuple[str, str]]:
    order = len(p.entry)
    if order > 4:
        yield "entry", "at most 4 numbers: higher orders are blocks in series"
    if len(p.transition) != order * order:
        yield "transition", f"{order * order} numbers, as entry has {order}"
    if len(p.readout) != order:
        yield "readout", f"{order} numbers, as entry has"


@StateSpace.constants
def constants(p: StateSpace, period: float) -> Constants:
    order = len(p.entry)
    decay = -max(abs(v) for v in p.transition)

    def entry(i: int, j: int) -> float:
        return p.transition[i * order + j] if max(i, j) < order else decay if i == j else 0.0

    a = [(entry(i, 0), entry(i, 1), entry(i, 2), entry(i, 3)) for i in range(4)]
    b1, b2, b3, b4 = (p.entry[i] if i < order else 0.0 for i in range(4))
    c1, c2, c3, c4 = (p.readout[i] if i < order else 0.0 for i in range(4))
    return Constants(a[0], a[1], a[2], a[3], (b1, b2, b3, b4), (c1, c2, c3, c4), p.direct)


@StateSpace.output("{output_unit}")
def output(c: Constants, x: State, input: float) -> float:
    """C x + D u."""
    return strictly_proper_part(c, x) + c.direct * input


@StateSpace.output("{output_unit}")
def strictly_proper_part(c: Constants, x: State) -> float:
    """C x."""
    return _along(c.readout, x)


def _along(row: tuple[float, float, float, float], x: State) -> float:
    return (row[0] * x.x1 + row[1] * x.x2) + (row[2] * x.x3 + row[3] * x.x4)


@StateSpace.derivative(linear=True)
def derivative(c: Constants, x: State, input: float) -> State:
    return State(
        _along(c.row1, x) + c.entry[0] * input,
        _along(c.row2, x) + c.entry[1] * input,
        _along(c.row3, x) + c.entry[2] * input,
        _along(c.row4, x) + c.entry[3] * input,
    )
