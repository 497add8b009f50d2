"""Discrete state space: x[n+1] = A x[n] + B u[n], y[n] = C x[n] + D u[n]."""

from collections.abc import Iterator

from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DiscreteStateSpace(Block):
    """Linear digital system by its matrices, of order 1 to 64. Wire a loop through `strictly_proper_part`."""

    transition: tuple[float, ...] = param("1", "A, row after row.", default=(0.9, 0.2, -0.2, 0.9))
    entry: tuple[float, ...] = param("1/({input_unit})", "B, one per state.", default=(0.05, 0.1))
    readout: tuple[float, ...] = param("{output_unit}", "C, one per state.", default=(1.0, 0.5))
    direct: float = param("({output_unit})/({input_unit})", "D.", default=0.0)
    input_unit: str = param("", "Unit of the input.", default="1")
    output_unit: str = param("", "Unit of the output.", default="1")

    input = Input("{input_unit}", "Input u of the system.")

    matrix = Buffer("A.", float, ("transition",))
    column = Buffer("B.", float, ("entry",))
    row = Buffer("C.", float, ("readout",))
    states = Buffer("x, zero in tick 0.", float, ("entry",))
    following = Buffer("x of the next tick, while it is computed.", float, ("entry",))


@DiscreteStateSpace.requires
def requires(p: DiscreteStateSpace) -> Iterator[tuple[str, str]]:
    order = len(p.entry)
    if order > 64:
        yield "entry", "at most 64 numbers"
    if len(p.transition) != order * order:
        yield "transition", f"{order * order} numbers, as entry has {order}"
    if len(p.readout) != order:
        yield "readout", f"{order} numbers, as entry has"


@DiscreteStateSpace.start
def start(p: DiscreteStateSpace, matrix: list[float], column: list[float], row: list[float]) -> None:
    for i in range(len(p.transition)):
        matrix[i] = p.transition[i]
    for i in range(len(p.entry)):
        column[i], row[i] = p.entry[i], p.readout[i]


@DiscreteStateSpace.output("{output_unit}")
def output(p: DiscreteStateSpace, row: list[float], states: list[float], input: float) -> float:
    """C x + D u."""
    return strictly_proper_part(p, row, states) + p.direct * input


@DiscreteStateSpace.output("{output_unit}")
def strictly_proper_part(p: DiscreteStateSpace, row: list[float], states: list[float]) -> float:
    """C x."""
    total = 0.0
    for i in range(len(states)):
        total += row[i] * states[i]
    return total


@DiscreteStateSpace.update
def update(
    p: DiscreteStateSpace,
    matrix: list[float],
    column: list[float],
    states: list[float],
    following: list[float],
    input: float,
) -> None:
    order = len(states)
    for i in range(order):
        following[i] = column[i] * input
        for j in range(order):
            following[i] += matrix[i * order + j] * states[j]
    for i in range(order):
        states[i] = following[i]
