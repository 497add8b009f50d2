"""State space of several inputs and outputs: x' = A x + B u, y = C x; continuous, of order 1 to 8.

Inputs and outputs beyond the sizes count nothing. States beyond the order stay zero: each decays by
itself, at about the largest rate of the others. A direct path D u is a Gain beside it.
"""

from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.arithmetic.eight_states import Eight, Four, State, along, moved, padded
from proofmass.blocks.declaration.declare import Block, Input, param


class MatrixStateSpace(Block):
    """Linear analog system of several inputs and outputs by its matrices: coupled resonators, a platform, a network."""

    input_size: int = param("1", "Number of inputs, m.", default=2, at_least=1, at_most=4)
    output_size: int = param("1", "Number of outputs, r.", default=2, at_least=1, at_most=4)
    transition: tuple[float, ...] = param("1/s", "A, n by n, row after row.", default=(-1.0, 1.0, -1.0, -1.0))
    entry: tuple[float, ...] = param("1/s/({input_unit})", "B, n by m, row after row.", default=(1.0, 0.0, 0.0, 1.0))
    readout: tuple[float, ...] = param("{output_unit}", "C, r by n, row after row.", default=(1.0, 0.0, 0.0, 1.0))
    input_unit: str = param("", "Unit of the inputs.", default="1")
    output_unit: str = param("", "Unit of the outputs.", default="1")

    first = Input("{input_unit}", "First input.")
    second = Input("{input_unit}", "Second input.", default=0.0)
    third = Input("{input_unit}", "Third input.", default=0.0)
    fourth = Input("{input_unit}", "Fourth input.", default=0.0)


class Constants(NamedTuple):
    a: tuple[Eight, Eight, Eight, Eight, Eight, Eight, Eight, Eight]
    b: tuple[Four, Four, Four, Four, Four, Four, Four, Four]
    c: tuple[Eight, Eight, Eight, Eight]


@MatrixStateSpace.requires
def requires(p: MatrixStateSpace) -> Iterator[tuple[str, str]]:
    n, m, r = len(p.entry) // p.input_size, p.input_size, p.output_size
    if len(p.entry) != n * m or not 1 <= n <= 8:
        yield "entry", f"n by {m} numbers, n at most 8"
    for name, size, shape in (("transition", n * n, f"{n} by {n}"), ("readout", r * n, f"{r} by {n}")):
        if len(getattr(p, name)) != size:
            yield name, f"{size} numbers, {shape}"


@MatrixStateSpace.constants
def constants(p: MatrixStateSpace, period: float) -> Constants:
    n, m = len(p.entry) // p.input_size, p.input_size
    decay = -max(abs(v) for v in p.transition)
    a = [padded(p.transition[i * n : (i + 1) * n] if i < n else [0.0] * i + [decay]) for i in range(8)]
    b = [(padded(p.entry[i * m : (i + 1) * m] if i < n else []))[:4] for i in range(8)]
    c = [padded(p.readout[i * n : (i + 1) * n] if i < p.output_size else []) for i in range(4)]
    return Constants(tuple(a), tuple(b), tuple(c))  # type: ignore[arg-type]


@MatrixStateSpace.output("{output_unit}")
def one(c: Constants, x: State) -> float:
    """First output."""
    return along(c.c[0], x)


@MatrixStateSpace.output("{output_unit}")
def two(c: Constants, x: State) -> float:
    """Second output; zero where there are fewer."""
    return along(c.c[1], x)


@MatrixStateSpace.output("{output_unit}")
def three(c: Constants, x: State) -> float:
    """Third output; zero where there are fewer."""
    return along(c.c[2], x)


@MatrixStateSpace.output("{output_unit}")
def four(c: Constants, x: State) -> float:
    """Fourth output; zero where there are fewer."""
    return along(c.c[3], x)


@MatrixStateSpace.derivative(linear=True)
def derivative(c: Constants, x: State, first: float, second: float, third: float, fourth: float) -> State:
    return State(
        moved(c.a[0], c.b[0], x, first, second, third, fourth),
        moved(c.a[1], c.b[1], x, first, second, third, fourth),
        moved(c.a[2], c.b[2], x, first, second, third, fourth),
        moved(c.a[3], c.b[3], x, first, second, third, fourth),
        moved(c.a[4], c.b[4], x, first, second, third, fourth),
        moved(c.a[5], c.b[5], x, first, second, third, fourth),
        moved(c.a[6], c.b[6], x, first, second, third, fourth),
        moved(c.a[7], c.b[7], x, first, second, third, fourth),
    )
