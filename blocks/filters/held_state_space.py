"""Continuous state space of any order and size: x' = A x + B u, y = C x + D u, for inputs that are held over a tick.

The step is exact: x[n+1] = e^(A T) x[n] + the integral of e^(A t) B u[n] over a tick, by the exponential of the
balanced matrix [[A, B], [0, 0]] T (Van Loan, IEEE Trans. Automatic Control 23, 1978).
"""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.modes import balanced_exponential
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class HeldStateSpace(Block):
    """Linear analog system from a vector to a vector, sampled: a plant of many states, a model of an identification."""

    order: int = param("1", "Number of states, n.", default=2, at_least=1, at_most=64)
    input_size: int = param("1", "Number of inputs, m.", default=1, at_least=1, at_most=32)
    output_size: int = param("1", "Number of outputs, r.", default=1, at_least=1, at_most=32)
    transition: tuple[float, ...] = param("1/s", "A, n by n, row after row.", default=(0.0, 1e3, -1e3, -1e3))
    entry: tuple[float, ...] = param("1/s", "B, n by m, row after row.", default=(0.0, 1e3))
    readout: tuple[float, ...] = param("1", "C, r by n, row after row.", default=(1.0, 0.0))
    direct: tuple[float, ...] = param("1", "D, r by m, row after row.", default=(0.0,))

    input = Input("1", "What drives it, held over a tick.", shape=("input_size",))

    whole = Buffer("Rows from states and inputs to states.", float, (lambda p: p.order * (p.order + p.input_size),))
    out_of = Buffer("C.", float, ("readout",))
    through = Buffer("D.", float, ("direct",))
    states = Buffer("x, zero in tick 0.", float, ("order",))
    following = Buffer("x of the next tick, while it is computed.", float, ("order",))


@HeldStateSpace.requires
def requires(p: HeldStateSpace) -> Iterator[tuple[str, str]]:
    for name, rows, columns in (
        ("transition", p.order, p.order),
        ("entry", p.order, p.input_size),
        ("readout", p.output_size, p.order),
        ("direct", p.output_size, p.input_size),
    ):
        if len(getattr(p, name)) != rows * columns:
            yield name, f"{rows * columns} numbers, {rows} by {columns}"


@HeldStateSpace.start
def start(p: HeldStateSpace, whole: list[float], out_of: list[float], through: list[float], period: float) -> None:
    n, m = p.order, p.input_size
    a = [[v * period for v in p.transition[i * n : (i + 1) * n]] for i in range(n)]
    b = [[v * period for v in p.entry[i * m : (i + 1) * m]] for i in range(n)]
    matrix = [left + right for left, right in zip(a, b, strict=True)] + [[0.0] * (n + m) for _ in range(m)]
    whole[:] = [v for row in balanced_exponential(matrix)[:n] for v in row]
    out_of[:], through[:] = p.readout, p.direct


@HeldStateSpace.output("1", shape=("output_size",), dtype=float)
def output(
    p: HeldStateSpace, out_of: list[float], through: list[float], states: list[float], input: list[float],
    out: list[float],
) -> None:  # fmt: skip
    """C x + D u."""
    n, m = len(states), len(input)
    for i in range(len(out)):
        total = 0.0
        for j in range(n):
            total += out_of[i * n + j] * states[j]
        for j in range(m):
            total += through[i * m + j] * input[j]
        out[i] = total


@HeldStateSpace.output("1", shape=("output_size",), dtype=float)
def strictly_proper_part(p: HeldStateSpace, out_of: list[float], states: list[float], out: list[float]) -> None:
    """C x, through which loops go."""
    n = len(states)
    for i in range(len(out)):
        total = 0.0
        for j in range(n):
            total += out_of[i * n + j] * states[j]
        out[i] = total


@HeldStateSpace.update
def update(
    p: HeldStateSpace, whole: list[float], states: list[float], following: list[float], input: list[float]
) -> None:
    n, m = len(states), len(input)
    for i in range(n):
        total = 0.0
        for j in range(n):
            total += whole[i * (n + m) + j] * states[j]
        for j in range(m):
            total += whole[i * (n + m) + n + j] * input[j]
        following[i] = total
    for i in range(n):
        states[i] = following[i]
