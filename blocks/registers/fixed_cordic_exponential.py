"""CORDIC exponential: exponential = exp(angle), 0 <= angle < 1, by hyperbolic rotations (Liu, Li, Shen, eqs. 4 and 5).

X = 1/K, Z = angle; for i = 1 to n, 4, 13 and 40 twice: X += d (X >> i), Z -= d atanh 2^-i, d = 1
for Z >= 0, else -1. X and Y of the rotation are equal from the start, so that one register holds
both. Registers have M fraction bits and the guard bits, which are dropped at the end: by default
0.0138 % off at most, up to ln 2. Monotonic with at least 2 guard bits and n >= M + guard bits;
without, neighbours may fall by a few steps.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.cordic import grown, hyperbolic_angles, hyperbolic_growth, hyperbolic_shifts
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.mantissa import left_over
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCordicExponential(Block):
    """Exponential of an angle below 1, within one tick."""

    fraction_bits: int = param("1", "M, of angle and exponential.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations without the repeated ones.", default=16, at_least=1, at_most=40)
    guard_bits: int = param("1", "Further fraction bits of the registers.", default=0, at_least=0, at_most=16)

    angle = Input("1", "Exponent, as a FixedRangeReducer leaves it.", dtype=FixedValue)


class Constants(NamedTuple):
    start: int
    angles: tuple[int, ...]
    output: Fixed


@FixedCordicExponential.formats
def formats(p: FixedCordicExponential) -> dict[str, Fixed]:
    return exponential_formats(p.fraction_bits)


@FixedCordicExponential.constants
def constants(p: FixedCordicExponential, period: float) -> Constants:
    return exponential_constants(p.fraction_bits, p.iterations, p.guard_bits)


@FixedCordicExponential.output("1")
def exponential(c: Constants, p: FixedCordicExponential, angle: FixedValue) -> FixedValue:
    """The exponential, in M fraction bits, below 4."""
    value, rest = c.start, angle.mantissa << p.guard_bits
    for shift, step in zip(hyperbolic_shifts(p.iterations), c.angles, strict=True):
        value, rest = grown(value, rest, shift, step)
    inner = p.fraction_bits + p.guard_bits
    return FixedValue(value + left_over(rest, 1 << inner, value), inner).to(c.output, "floor", "refuse")


def exponential_formats(fraction_bits: int) -> dict[str, Fixed]:
    """Formats of the ports."""
    angle = Fixed(fraction_bits, fraction_bits, signed=False)
    return {"angle": angle, "exponential": Fixed(fraction_bits + 2, fraction_bits, signed=False)}


def exponential_constants(fraction_bits: int, iterations: int, guard_bits: int) -> Constants:
    """Start value and angles of the registers, and the format of the output."""
    inner = fraction_bits + guard_bits
    start = round(math.ldexp(1.0 / hyperbolic_growth(iterations), inner))
    return Constants(start, hyperbolic_angles(iterations, inner), exponential_formats(fraction_bits)["exponential"])
