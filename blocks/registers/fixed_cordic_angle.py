"""CORDIC angle in turns: atan2(imaginary, real) / (2 pi), by circular rotations (Walther 1971).

The vector is turned by +-atan 2^-i, i = 0 to n - 1, until its imaginary part is gone; a vector to
the left is turned by half a turn first. Angles in the register are turns, so half a turn is its
highest bit, exactly, and a whole one its overflow. No multiplier: what FixedCordicVectoring has in
radians and with a magnitude. The angle of (0, 0) is 0.

With v the length in steps the angle is off by at most 1/2 + (2^(b - n + 1) + 2 n 2^(b - g) / v) /
(2 pi) steps of 2^-b, b being `turn_bits` and g `guard_bits`. The vector has registers of width +
g + 2 bits, the angle b + g + 1.
"""

import math
from typing import NamedTuple

from proofmass.blocks.arithmetic.cordic import circular_turns, to_the_real_axis
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, where
from proofmass.blocks.declaration.declare import Block, Input, param


class FixedCordicAngle(Block):
    """Angle of a vector within one tick, from -1/2 to 1/2 of a turn: of an encoder or resolver."""

    input_format: Fixed = param("1", "Format of both parts.", default=Fixed(12, 0))
    turn_bits: int = param("bit", "Bits of the angle, in turns.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations.", default=18, at_least=1, at_most=36)
    guard_bits: int = param("bit", "Further bits of the registers.", default=12, at_least=0, at_most=30)
    unit: str = param("", "Unit of both parts.", default="1")

    real = Input("{unit}", "Real part, the cosine.", dtype=FixedValue)
    imaginary = Input("{unit}", "Imaginary part, the sine.", dtype=FixedValue)


class Constants(NamedTuple):
    turns: tuple[int, ...]
    half_turn: int
    radian: int


@FixedCordicAngle.formats
def formats(p: FixedCordicAngle) -> dict[str, Fixed]:
    return {"real": p.input_format, "imaginary": p.input_format, "angle": Fixed(p.turn_bits, p.turn_bits)}


@FixedCordicAngle.constants
def constants(p: FixedCordicAngle, period: float) -> Constants:
    inner = p.turn_bits + p.guard_bits
    return Constants(circular_turns(p.iterations, inner), 1 << (inner - 1), round(math.ldexp(0.5 / math.pi, inner)))


@FixedCordicAngle.output("1")
def angle(c: Constants, p: FixedCordicAngle, real: FixedValue, imaginary: FixedValue) -> FixedValue:
    """Angle of the vector from the real axis in turns, modulo one turn; 0 for (0, 0)."""
    parts = real.mantissa << p.guard_bits, imaginary.mantissa << p.guard_bits
    _, turns = to_the_real_axis(*parts, c.turns, c.half_turn, c.radian)
    exact = FixedValue(turns, p.turn_bits + p.guard_bits)
    rounded = exact.to(Fixed(p.turn_bits, p.turn_bits), "half_even", "wrap")
    nothing = (real == 0) & (imaginary == 0)
    return FixedValue(where(nothing, 0, rounded.mantissa), p.turn_bits)
