"""MASH 2-1 in registers: a modulator of second order, whose quantising error a second one of first order converts.

    a' = a + u - v1,  b' = b + a - 2 v1,  v1 = the level nearest to b;   c' = c + e - v2,  e = b - v1,  v2 nearest to c
    output[n] = v1[n-1] + (v2[n] - 2 v2[n-1] + v2[n-2])

The twin of a MashModulator, exact but for the range of its registers: levels s (k - (2^B - 1) / 2),
s = 2^(2-B), of either quantiser (Schreier and Temes, Understanding Delta-Sigma Data Converters,
section 4.5).
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, Overflow, clip
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedMashModulator(Block):
    """Cascade of modulators of second and first order in fixed point: third-order noise without its instability."""

    bits: int = param("bit", "B, of either quantiser.", default=3, at_least=1, at_most=8)
    input_format: Fixed = param("1", "Format of the input.", default=Fixed(16, 14))
    state_bits: int = param(
        "bit", "Bits of the integrators before the point, the sign included.", default=6, at_least=3
    )
    overflow: Overflow = param("", "Handling of values beyond the range of the integrators.", default="saturate")

    input = Input("1", "Value to convert.", dtype=FixedValue)


class State(NamedTuple):
    a: FixedValue
    b: FixedValue
    c: FixedValue
    first: FixedValue  # v1 in the tick before
    second: FixedValue  # v2 in the tick before
    third: FixedValue  # v2 two ticks before


def word(p: FixedMashModulator) -> Fixed:
    """Format of the integrators: as fine as the input and as the levels."""
    fraction = max(p.input_format.fraction, p.bits - 1)
    return Fixed(p.state_bits + fraction, fraction)


@FixedMashModulator.formats
def formats(p: FixedMashModulator) -> dict[str, Fixed]:
    level = Fixed(p.bits + 1, p.bits - 1)
    levels = {"x.first": level, "x.second": level, "x.third": level, "output": Fixed(p.bits + 4, p.bits - 1)}
    return levels | {"input": p.input_format, "x.a": word(p), "x.b": word(p), "x.c": word(p)}


def nearest(p: FixedMashModulator, value: FixedValue) -> FixedValue:
    """The level nearest to a value; a tie goes up."""
    half = 1 << (p.bits - 1)
    below = (value << (p.bits - 2)).to(Fixed(word(p).width + p.bits, 0), "floor", "wrap")
    return FixedValue(2 * clip(below, -half, half - 1).mantissa + 1, p.bits - 1)


@FixedMashModulator.output("1")
def output(p: FixedMashModulator, x: State) -> FixedValue:
    """Output of both stages, joined by their digital filters."""
    return x.first + (nearest(p, x.c) - 2 * x.second + x.third)


@FixedMashModulator.update
def update(p: FixedMashModulator, x: State, input: FixedValue) -> State:
    v1, v2 = nearest(p, x.b), nearest(p, x.c)
    a = (x.a + input - v1).to(word(p), "floor", p.overflow)
    b = (x.b + x.a - 2 * v1).to(word(p), "floor", p.overflow)
    return State(a, b, (x.c + (x.b - v1) - v2).to(word(p), "floor", p.overflow), v1, v2, x.second)
