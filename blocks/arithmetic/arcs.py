"""Arctangents, arcsine and arccosine: all are the angle of a point in the first quarter, from a
quotient of pairs.

The smaller coordinate by the larger is q <= 1; atan q = atan c + atan((q - c) / (1 + c q)) for the
c of 0, 1/2 and 1 that leaves at most t = 0.236, and atan t = t + t^3 A(t^2), A the minimax
polynomial of degree 8 (relative error 2^-65, benchmarks/elementary_fits.py).
"""

import math

from proofmass.blocks.arithmetic.angles import HALF_PI, HALF_PI_LOW
from proofmass.blocks.arithmetic.pairs import exact_product, exact_sum, ordered_sum, pair_quotient, pair_root

SMALL = 1.0e-9  # up to it arctangent and arcsine are their argument
FAR = 1.0e60  # beyond it the arctangent is a quarter turn


def arctangent(value: float) -> float:
    """The angle from -pi / 2 to pi / 2 whose tangent is the value, within 0.65 ulp.

    >>> arctangent(1.0), arctangent(-math.inf)
    (0.7853981633974483, -1.5707963267948966)
    """
    size = abs(value)
    high, low = _angle(FAR if size > FAR else size, 0.0, 1.0, 0.0)
    return value if size < SMALL else math.copysign(high + low, value)


def arctangent2(y: float, x: float) -> float:
    """The angle of the point (x, y), from -pi to pi, within 0.76 ulp; of zeros and infinities as
    `math.atan2` has it.

    >>> arctangent2(1.0, -1.0), arctangent2(-0.0, -1.0), arctangent2(0.0, 0.0)
    (2.356194490192345, -3.141592653589793, 0.0)
    """
    up, across = abs(y), abs(x)
    endless = up == math.inf or across == math.inf
    above = (1.0 if up == math.inf else 0.0) if endless else up
    along = (1.0 if across == math.inf else 0.0) if endless else 1.0 if up == 0.0 and across == 0.0 else across
    high, low = _angle(above, 0.0, along, 0.0)
    high, low = _mirrored(high, low, math.copysign(1.0, x))
    return math.copysign(high + low, y) if x == x and y == y else math.nan


def arcsine(value: float) -> float:
    """The angle from -pi / 2 to pi / 2 whose sine is the value, within 0.65 ulp; NaN beyond 1.

    >>> arcsine(1.0), arcsine(-0.5), arcsine(1.1)
    (1.5707963267948966, -0.5235987755982989, nan)
    """
    size = abs(value) if abs(value) <= 1.0 else 1.0
    side, side_low = _other_side(size)
    high, low = _angle(size, 0.0, side, side_low)
    result = value if size < SMALL else math.copysign(high + low, value)
    return result if abs(value) <= 1.0 else math.nan


def arccosine(value: float) -> float:
    """The angle from 0 to pi whose cosine is the value, within 0.65 ulp; NaN beyond -1 and 1.

    >>> arccosine(1.0), arccosine(-1.0), arccosine(1.1)
    (0.0, 3.141592653589793, nan)
    """
    size = abs(value) if abs(value) <= 1.0 else 1.0
    side, side_low = _other_side(size)
    high, low = _angle(side, side_low, size, 0.0)
    high, low = _mirrored(high, low, value)
    return high + low if abs(value) <= 1.0 else math.nan


def _other_side(side: float) -> tuple[float, float]:
    """sqrt(1 - side^2), for a side from 0 to 1."""
    square, lost = exact_product(side, side)
    square, lost_of_sum = exact_sum(1.0, -square)
    square, lost = ordered_sum(square, lost_of_sum - lost)
    root = math.sqrt(square)
    return root, pair_root(square, lost, root)


def _mirrored(angle: float, low: float, sign: float) -> tuple[float, float]:
    """The angle, or pi less it if the sign is negative."""
    back, lost = exact_sum(2.0 * HALF_PI, -angle)
    left = sign < 0.0
    return back if left else angle, lost + (2.0 * HALF_PI_LOW - low) if left else low


def _angle(y: float, y_low: float, x: float, x_low: float) -> tuple[float, float]:
    """The angle, from 0 to pi / 2, of a point in the first quarter that is not the origin."""
    steep = y > x
    above, above_low = x if steep else y, x_low if steep else y_low
    below, below_low = y if steep else x, y_low if steep else x_low
    scale = (
        4.149515568880993e180
        if below < 3.8725919148493183e-121
        else 7.888609052210118e-31
        if below > 8.452712498170644e270
        else 1.0
    )
    above, above_low, below, below_low = above * scale, above_low * scale, below * scale, below_low * scale
    far, middle = above > 0.7208 * below, above > 0.2360 * below
    step = 1.0 if far else 0.5 if middle else 0.0
    base, base_low = (
        (0.5 * HALF_PI if far else 0.4636476090008061 if middle else 0.0),
        (0.5 * HALF_PI_LOW if far else 2.2698777452961687e-17 if middle else 0.0),
    )
    over, lost = exact_sum(above, -step * below)
    under, lost_below = ordered_sum(below, step * above)
    t, rest = pair_quotient(
        over, lost + (above_low - step * below_low), under, lost_below + (below_low + step * above_low)
    )
    high, lost = exact_sum(base, t)
    low = lost + (base_low + ((rest if above > 1.1830521861667747e-271 else 0.0) + t * _bent(t * t)))
    back, lost = exact_sum(HALF_PI, -high)
    return back if steep else high, lost + (HALF_PI_LOW - low) if steep else low


def _bent(z: float) -> float:
    """atan(t) / t - 1, of z = t^2 <= 0.056."""
    fourth = z * z
    series = (-0.06657401048445352 + z * 0.057426736043535806) + fourth * -0.04069877575115947
    series = (-0.0909089974120971 + z * 0.07691933608235832) + fourth * series
    series = (-0.14285714284500836 + z * 0.1111111096960127) + fourth * series
    return z * ((-0.33333333333333326 + z * 0.19999999999994894) + fourth * series)
