"""Angles less their whole quarter turns, as pairs.

Up to 1.5e6 after Cody and Waite, Software Manual for the Elementary Functions (1980): pi / 2 in
three parts of 33 bits, times whole numbers of 20, and a fourth part. Beyond, after Payne and Hanek,
ACM SIGNUM Newsletter 18 (1983): the product with 2 / pi, of which whole periods are left out as
they arise. No number but zero is nearer than 2^-62 to a multiple of pi / 2 (Muller, Elementary
Functions, chapter 11); what is lost is below 2^-140.
"""

from proofmass.blocks.arithmetic.pairs import exact_product, exact_sum, ordered_sum, pair_product
from proofmass.blocks.arithmetic.rounding import nearest_integer

LARGE = 1.5e6
HALF_PI, HALF_PI_LOW = 1.5707963267948966, 6.123233995736766e-17
TWO_OVER_PI = (  # in pieces of 53 bits, times 2^200
    1.0230085319449646e60,
    1.1516113316819946e44,
    1.636130385815019e28,
    1358343193086.3179,
    5.6020620623732855e-05,
    9.38211059616787e-22,
    1.8472517870813732e-38,
    1.1824114347126146e-54,
    9.46577316363298e-71,
    1.353549115954541e-86,
    1.0800500326406148e-102,
    1.82098821691268e-118,
    1.7221265867980136e-134,
    1.1288922953263716e-150,
    1.0812567733113692e-166,
    9.452089397645265e-183,
    1.0341026634030077e-198,
    1.043214522341974e-214,
    1.3626375052199195e-230,
    1.1016143745607263e-246,
    8.173982018912786e-263,
    1.3905726429696076e-278,
)


def less_quarters(angle: float) -> tuple[float, float, float]:
    """Quarter turns from -2 to 2 with what is left of the angle beyond them, and the rest of that; NaN has a NaN."""
    if abs(angle) <= LARGE:
        quarters, left, rest = _of_small(angle)
    else:
        quarters, left, rest = _of_large(angle)
    return quarters - 4.0 * nearest_integer(0.25 * quarters), left, rest


def _of_small(angle: float) -> tuple[float, float, float]:
    quarters = nearest_integer(angle * 0.6366197723675814)
    first = angle - quarters * 1.5707963267341256
    left, lost = exact_sum(first, quarters * -6.077100506303966e-11)
    left, lost_then = exact_sum(left, quarters * -2.0222662487111665e-21)
    lost = (lost + lost_then) + quarters * -8.4784276603689e-32
    left, lost = ordered_sum(left, lost)
    return quarters, left, lost


def _of_large(angle: float) -> tuple[float, float, float]:
    scaled = angle * 6.223015277861142e-61  # 2^-200: what multiplies it is larger by as much
    high, low, lowest = 0.0, 0.0, 0.0
    for piece in TWO_OVER_PI:
        product, rest = exact_product(scaled, piece)
        high, lost = exact_sum(high, _within_a_turn(product))
        low, lost = exact_sum(low, lost)
        lowest = lowest + lost
        high, lost = exact_sum(high, _within_a_turn(rest))
        low, lost = exact_sum(low, lost)
        lowest = lowest + lost
    quarters = nearest_integer(high)
    high, low = exact_sum(high - quarters, low)
    low, lowest = exact_sum(low, lowest)
    high, low = ordered_sum(high, low)
    left, rest = pair_product(high, low + lowest, HALF_PI, HALF_PI_LOW)
    return quarters, left, rest


def _within_a_turn(quarters: float) -> float:
    """A number of quarter turns less whole turns."""
    less = quarters - 8.0 * nearest_integer(0.125 * quarters)
    return 0.0 if abs(quarters) >= 36028797018963968.0 else less  # 2^55: all are multiples of 8
