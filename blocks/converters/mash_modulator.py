"""MASH 2-1: a sigma-delta modulator of second order, whose quantising error a second one of first order converts.

    a' = a + u - v1,  b' = b + a - 2 v1,  v1 = the level nearest to b;   c' = c + e - v2,  e = b - v1,  v2 nearest to c
    output[n] = v1[n-1] + (v2[n] - 2 v2[n-1] + v2[n-2])

so that the input comes through with 3 ticks of delay and the noise is that of a third order, (1 -
z^-1)^3, without its instability (Schreier and Temes, Understanding Delta-Sigma Data Converters,
section 4.5). `leakage` is what the integrators lose in a tick, by which the error of the first
stage leaks through.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.rounding import nearest_level
from proofmass.blocks.declaration.declare import Block, Input, param


class MashModulator(Block):
    """Cascade of modulators of second and first order: third-order noise, of as many levels as its stages make."""

    levels: int = param("1", "Levels of either quantiser.", default=9, at_least=2, at_most=65536)
    reference: float = param("{unit}", "The highest level.", default=1.0, above=0.0)
    leakage: float = param("1", "Part that an integrator loses in a tick.", default=0.0, at_least=0.0, at_most=1.0)
    unit: str = param("", "Unit of the input.", default="V")

    input = Input("{unit}", "Value to convert.")


class State(NamedTuple):
    a: float
    b: float
    c: float
    first: float  # v1 in the tick before
    second: float  # v2 in the tick before
    third: float  # v2 two ticks before


class Constants(NamedTuple):
    reference: float
    last: float
    kept: float


@MashModulator.constants
def constants(p: MashModulator, period: float) -> Constants:
    return Constants(p.reference, float(p.levels - 1), 1.0 - p.leakage)


def nearest(c: Constants, value: float) -> float:
    """The level nearest to a value; a tie goes up."""
    number = nearest_level((0.5 * value / c.reference + 0.5) * c.last, c.last)
    return c.reference * (2.0 * number / c.last - 1.0)


@MashModulator.output("{unit}")
def output(c: Constants, x: State) -> float:
    """Output of both stages, joined by their digital filters."""
    return x.first + (nearest(c, x.c) - 2.0 * x.second + x.third)


@MashModulator.update
def update(c: Constants, x: State, input: float) -> State:
    v1, v2 = nearest(c, x.b), nearest(c, x.c)
    a = c.kept * x.a + input - v1
    b = c.kept * x.b + x.a - 2.0 * v1
    return State(a, b, c.kept * x.c + (x.b - v1) - v2, v1, v2, x.second)
