"""CORDIC sine and cosine: cosine + i sine = exp(i angle), -4 <= angle < 4, by circular rotations (Walther 1971).

The vector begins at (1/K, 0) and is turned by +-atan 2^-i, i = 0 to n - 1, until nothing is left of the angle; beyond
a right angle by half a turn first, which is a change of sign. The registers have M fraction bits and the guard bits.
"""

import math
from typing import NamedTuple

from proofmass.blocks.cordic import circular_angles, circular_growth, turned
from proofmass.blocks.declare import Block, Input, param
from proofmass.blocks.fixed_point import Fixed, FixedValue, fixed, where


class FixedCordicRotation(Block):
    """Sine and cosine of an angle of any quadrant, within one tick."""

    fraction_bits: int = param("1", "M, of angle, sine and cosine.", default=16, at_least=4, at_most=32)
    iterations: int = param("1", "n, rotations.", default=18, at_least=1, at_most=40)
    guard_bits: int = param("1", "Further fraction bits of the registers.", default=4, at_least=0, at_most=16)

    angle = Input("1", "Angle.", dtype=FixedValue)


class Constants(NamedTuple):
    start: FixedValue
    half_turn: FixedValue
    angles: tuple[FixedValue, ...]
    word: Fixed
    output: Fixed


@FixedCordicRotation.formats
def formats(p: FixedCordicRotation) -> dict[str, Fixed]:
    output = Fixed(p.fraction_bits + 2, p.fraction_bits)
    return {"angle": Fixed(p.fraction_bits + 3, p.fraction_bits), "sine": output, "cosine": output}


@FixedCordicRotation.constants
def constants(p: FixedCordicRotation, period: float) -> Constants:
    inner = p.fraction_bits + p.guard_bits
    word = Fixed(inner + 4, inner)
    start = fixed(1.0 / circular_growth(p.iterations), word, "half_even")
    half_turn = fixed(math.pi, word, "half_even")
    return Constants(start, half_turn, circular_angles(p.iterations, word), word, formats(p)["sine"])


@FixedCordicRotation.output("1")
def sine(c: Constants, p: FixedCordicRotation, angle: FixedValue) -> FixedValue:
    """Sine of the angle, rounded to the nearest step."""
    return _rotated(c, angle)[1].to(c.output)


@FixedCordicRotation.output("1")
def cosine(c: Constants, p: FixedCordicRotation, angle: FixedValue) -> FixedValue:
    """Cosine of the angle, rounded to the nearest step."""
    return _rotated(c, angle)[0].to(c.output)


def _rotated(c: Constants, angle: FixedValue) -> tuple[FixedValue, FixedValue]:
    above, below = (angle << 1) > c.half_turn, (angle << 1) < -c.half_turn
    rest = where(above, angle - c.half_turn, where(below, angle + c.half_turn, angle))
    start = where(above | below, -c.start, c.start)
    x, y = start, start * 0
    for shift, step in enumerate(c.angles):
        left = rest >= 0
        x, y = turned(x, y, left, shift, c.word)
        rest = where(left, rest - step, rest + step)
    return x, y
