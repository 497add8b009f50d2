"""Discrete state space of several inputs and outputs: x[n+1] = A x[n] + B u[n], y[n] = C x[n] + D u[n]."""

from collections.abc import Iterator

from proofmass.blocks.arithmetic.matrices import combined, product_with_part, stepped, wrong_sizes
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param


class DiscreteMatrixStateSpace(Block):
    """Linear digital system by its matrices, from a vector to a vector: an observer, a controller of several loops.

    Wire a loop through `strictly_proper_part`.
    """

    order: int = param("1", "Number of states, n.", default=2, at_least=1, at_most=64)
    input_size: int = param("1", "Number of inputs, m.", default=2, at_least=1, at_most=64)
    output_size: int = param("1", "Number of outputs, r.", default=1, at_least=1, at_most=64)
    transition: tuple[float, ...] = param("1", "A, n by n, row after row.", default=(0.9, 0.2, -0.2, 0.9))
    entry: tuple[float, ...] = param("1", "B, n by m, row after row.", default=(0.05, 0.0, 0.0, 0.1))
    readout: tuple[float, ...] = param("1", "C, r by n, row after row.", default=(1.0, 0.5))
    direct: tuple[float, ...] = param("1", "D, r by m, row after row.", default=(0.0, 0.0))

    input = Input("1", "Input u of the system.", shape=("input_size",))

    matrix = Buffer("A.", float, ("transition",))
    into = Buffer("B.", float, ("entry",))
    out_of = Buffer("C.", float, ("readout",))
    through = Buffer("D.", float, ("direct",))
    states = Buffer("x, zero in tick 0.", float, ("order",))
    following = Buffer("x of the next tick, while it is computed.", float, ("order",))


@DiscreteMatrixStateSpace.requires
def requires(p: DiscreteMatrixStateSpace) -> Iterator[tuple[str, str]]:
    yield from wrong_sizes(p.transition, p.entry, p.readout, p.direct, p.order, p.input_size, p.output_size)


@DiscreteMatrixStateSpace.start
def start(
    p: DiscreteMatrixStateSpace, matrix: list[float], into: list[float], out_of: list[float], through: list[float]
) -> None:
    matrix[:], into[:], out_of[:], through[:] = p.transition, p.entry, p.readout, p.direct


@DiscreteMatrixStateSpace.output("1", shape=("output_size",), dtype=float)
def output(
    p: DiscreteMatrixStateSpace,
    out_of: list[float],
    through: list[float],
    states: list[float],
    input: list[float],
    out: list[float],
) -> None:
    """C x + D u."""
    combined(out_of, states, through, input, out)


@DiscreteMatrixStateSpace.output("1", shape=("output_size",), dtype=float)
def strictly_proper_part(
    p: DiscreteMatrixStateSpace, out_of: list[float], states: list[float], out: list[float]
) -> None:
    """C x, through which loops go."""
    product_with_part(out_of, states, 0, len(states), out)


@DiscreteMatrixStateSpace.update
def update(
    p: DiscreteMatrixStateSpace,
    matrix: list[float],
    into: list[float],
    states: list[float],
    following: list[float],
    input: list[float],
) -> None:
    stepped(matrix, states, into, input, following)
