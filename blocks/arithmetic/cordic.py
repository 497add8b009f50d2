"""CORDIC: rotations by angles whose tangents are powers of two, so that each is a shift and a sum.

Hyperbolic rotations by atanh 2^-i, i = 1, 2, ..., converge when i = 4, 13, 40 are done twice, for
|angle| up to 1.118; circular ones by atan 2^-i, i = 0, 1, ..., for |angle| up to 1.743 (Walther
1971; Liu, Li, Shen, eq. 4). All rotations together lengthen a vector by the growth K = prod
sqrt(1 -+ 4^-i), whatever their directions. Registers are mantissas here: each rotation drops bits
as a shift does.
"""

import math
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import where
from proofmass.blocks.arithmetic.mantissa import Condition, WholeNumber, left_over

TWICE = (4, 13, 40)  # of the hyperbolic rotations: without these the angles that follow do not add up to the one before


def hyperbolic_shifts(iterations: int) -> tuple[int, ...]:
    """The shift of each hyperbolic rotation.

    >>> hyperbolic_shifts(5)
    (1, 2, 3, 4, 4, 5)
    """
    return tuple(i for i in range(1, iterations + 1) for _ in range(2 if i in TWICE else 1))


def hyperbolic_growth(iterations: int) -> float:
    """K of the hyperbolic rotations, 0.828 for many."""
    return math.prod(math.sqrt(1.0 - math.ldexp(1.0, -2 * i)) for i in hyperbolic_shifts(iterations))


def hyperbolic_angles(iterations: int, fraction: int) -> tuple[int, ...]:
    """The angle of each hyperbolic rotation, to the nearest step of 2^-fraction."""
    return tuple(_rounded(_series(2**i, 1, fraction)) for i in hyperbolic_shifts(iterations))


def circular_growth(iterations: int) -> float:
    """K of the circular rotations, 1.647 for many."""
    return math.prod(math.sqrt(1.0 + math.ldexp(1.0, -2 * i)) for i in range(iterations))


def circular_angles(iterations: int, fraction: int) -> tuple[int, ...]:
    """The angle of each circular rotation, to the nearest step of 2^-fraction."""
    eighth = _series(2, -1, fraction) + _series(3, -1, fraction)  # atan 1/2 + atan 1/3 = pi / 4
    return (_rounded(eighth), *(_rounded(_series(2**i, -1, fraction)) for i in range(1, iterations)))[:iterations]


def circular_turns(iterations: int, fraction: int) -> tuple[int, ...]:
    """The angle of each circular rotation in turns, to the nearest step of 2^-fraction."""
    turn = 8 * circular_angles(1, fraction + GUARD)[0]
    angles = circular_angles(iterations, fraction + GUARD)
    return tuple(((angle << (fraction + 1)) + turn) // (2 * turn) for angle in angles)


GUARD = 256  # bits beyond the step: what tells 2^-i from atan 2^-i, at half a step, and then some


def _series(inverse: int, sign: int, fraction: int) -> int:
    """atanh(1 / inverse), or atan for the sign -1, in steps of 2^-(fraction + GUARD), each term rounded down."""
    total, odd, power, side = 0, 1, (1 << (fraction + GUARD)) // inverse, 1
    while power:
        total += side * (power // odd)
        odd, power, side = odd + 2, power // (inverse * inverse), sign * side
    return total


def _rounded(value: int) -> int:
    return (value + (1 << (GUARD - 1))) >> GUARD


def grown(value: WholeNumber, rest: WholeNumber, shift: int, angle: int) -> tuple[Any, Any]:
    """One hyperbolic rotation of a vector with equal coordinates, of which one register is enough;
    bits are dropped.

    value exp(rest) stays what it is, but for rounding and the growth: the value takes up the
    exponential of the rest.
    """
    up, share = rest >= 0, value >> shift
    return where(up, value + share, value - share), where(up, rest - angle, rest + angle)


def turned(x: WholeNumber, y: WholeNumber, left: Condition, shift: int) -> tuple[Any, Any]:
    """One circular rotation, to the left or to the right; bits are dropped."""
    along, across = x >> shift, y >> shift
    return where(left, x - across, x + across), where(left, y + along, y - along)


def to_the_real_axis(
    x: WholeNumber, y: WholeNumber, angles: tuple[int, ...], half_turn: int, radian: int
) -> tuple[Any, Any]:
    """Turn a vector of any quadrant until y is gone: its grown real part, and the angle it had.

    One circular rotation for each of the `angles`; a vector to the left is turned by half a turn
    first. `radian` is one radian in the steps of the angles.
    """
    to_the_left, above = x < 0, y >= 0
    x, y = where(to_the_left, -x, x), where(to_the_left, -y, y)
    angle = where(to_the_left, where(above, half_turn, -half_turn), 0)
    for shift, step in enumerate(angles):
        below = y < 0
        x, y = turned(x, y, below, shift)
        angle = where(below, angle - step, angle + step)
    return x, angle + left_over(y, x, radian)
