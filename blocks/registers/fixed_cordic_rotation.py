"""CORDIC sine and cosine: cosine + i sine = exp(i angle), -4 <= angle < 4, by circular rotations (Walther 1971).

The vector begins at (1/K, 0) and is turned by +-atan 2^-i, i = 0 to n - 1, until nothing is left of
the angle; beyond a right angle by half a turn first, which is a change of sign. The registers have
M fraction bits and g guard bits.

Sine and cosine are off by at most 1/2 + 2^(M - n + 1) + 2 n 2^-g steps: half a step is rounding,
then come what is left of the angle and the bits that the rotations drop. With n = M + 4 or more and
8 guard bits, as by default, it is at most one step.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.cordic import circular_angles, circular_growth, turned
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, where
from proofmass.blocks.arithmetic.mantissa import left_over
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCordicRotation(Block):
    """Sine and cosine of an angle of any quadrant, within one tick."""

    fraction_bits: int = param("1", "M, of angle, sine and cosine.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations.", default=20, at_least=1, at_most=40)
    guard_bits: int = param("1", "g, further fraction bits of the registers.", default=8, at_least=0, at_most=16)

    angle = Input("1", "Angle.", dtype=FixedValue)


class Constants(NamedTuple):
    start: int
    half_turn: int
    angles: tuple[int, ...]
    output: Fixed


@FixedCordicRotation.formats
def formats(p: FixedCordicRotation) -> dict[str, Fixed]:
    output = Fixed(p.fraction_bits + 2, p.fraction_bits)
    return {"angle": Fixed(p.fraction_bits + 3, p.fraction_bits), "sine": output, "cosine": output}


@FixedCordicRotation.constants
def constants(p: FixedCordicRotation, period: float) -> Constants:
    inner = p.fraction_bits + p.guard_bits
    start, half_turn = (round(math.ldexp(value, inner)) for value in (1.0 / circular_growth(p.iterations), math.pi))
    return Constants(start, half_turn, circular_angles(p.iterations, inner), formats(p)["sine"])


@FixedCordicRotation.output("1")
def sine(c: Constants, p: FixedCordicRotation, angle: FixedValue) -> FixedValue:
    """Sine of the angle, by default at most one step off."""
    return _rotated(c, p, angle)[1].to(c.output)


@FixedCordicRotation.output("1")
def cosine(c: Constants, p: FixedCordicRotation, angle: FixedValue) -> FixedValue:
    """Cosine of the angle, by default at most one step off."""
    return _rotated(c, p, angle)[0].to(c.output)


def _rotated(c: Constants, p: FixedCordicRotation, angle: FixedValue) -> tuple[FixedValue, FixedValue]:
    rest = angle.mantissa << p.guard_bits
    above, below = 2 * rest > c.half_turn, 2 * rest < -c.half_turn
    rest = where(above, rest - c.half_turn, where(below, rest + c.half_turn, rest))
    x, y = where(above | below, -c.start, c.start), 0
    for shift, step in enumerate(c.angles):
        left = rest >= 0
        x, y = turned(x, y, left, shift)
        rest = where(left, rest - step, rest + step)
    inner = p.fraction_bits + p.guard_bits
    along, across = left_over(rest, 1 << inner, x), left_over(rest, 1 << inner, y)
    return FixedValue(x - across, inner), FixedValue(y + along, inner)
