"""Powers x^y = exp(y ln |x|), and the length of a hypotenuse.

The logarithm is a pair with a relative error of 2^-69, so that the product, of at most 745, is
known to a small part of the last place of the power.
"""

import math

from proofmass.blocks.arithmetic.exponentials import exponential_of_pair
from proofmass.blocks.arithmetic.logarithms import logarithm_as_pair
from proofmass.blocks.arithmetic.pairs import exact_product, exact_sum, pair_root
from proofmass.blocks.arithmetic.scaling import mantissa_and_exponent


def power(base: float, exponent: float) -> float:
    """The base to the power of the exponent, within 0.76 ulp; infinity where that is too large.

    NaN where there is none: of zero to a negative exponent, of a negative number to a fraction.

    >>> power(2.0, 0.5), power(-2.0, 3.0), power(0.0, -1.0), power(-8.0, 1.0 / 3.0)
    (1.4142135623730951, -8.0, nan, nan)
    """
    size, steps = abs(base), abs(exponent)
    result = _power_of_size(size, exponent)
    whole = steps >= 4503599627370496.0 or (steps + 4503599627370496.0) - 4503599627370496.0 == steps
    half = 0.5 * steps
    odd = whole and steps < 9007199254740992.0 and (half + 4503599627370496.0) - 4503599627370496.0 != half
    result = -result if odd and math.copysign(1.0, base) < 0.0 else result
    result = math.nan if base < 0.0 and size < math.inf and not whole else result
    return 1.0 if exponent == 0.0 or base == 1.0 else result


def _power_of_size(size: float, exponent: float) -> float:
    """The power of a number that is not negative."""
    usual = size > 0.0 and size < math.inf
    m, twos = mantissa_and_exponent(size if usual else 1.0)
    high, low = logarithm_as_pair(m, twos)
    held = 3.7e19 if exponent > 3.7e19 else -3.7e19 if exponent < -3.7e19 else exponent
    product, rest = exact_product(held, high)
    result = exponential_of_pair(product, rest + held * low)
    at_zero = 0.0 if exponent > 0.0 else math.inf if exponent == -math.inf else math.nan
    at_infinity = math.inf if exponent > 0.0 else 0.0 if exponent < 0.0 else math.nan
    result = at_zero if size == 0.0 else at_infinity if size == math.inf else result
    return result if size == size else math.nan


def hypotenuse(x: float, y: float) -> float:
    """sqrt(x^2 + y^2), within 0.76 ulp, without overflow on the way; infinite if either is.

    >>> hypotenuse(3.0, -4.0), hypotenuse(1e-320, 0.0), hypotenuse(math.inf, math.nan)
    (5.0, 1e-320, inf)
    """
    side, other = abs(x), abs(y)
    large, small = side if side > other else other, other if side > other else side
    big, tiny = large > 3.273390607896142e150, large < 3.054936363499605e-151  # 2^500, 2^-500
    there = 2.409919865102884e-181 if big else 4.149515568880993e180 if tiny else 1.0  # 2^-600, 2^600
    back = 4.149515568880993e180 if big else 2.409919865102884e-181 if tiny else 1.0
    square, lost = exact_product(large * there, large * there)
    added, lost_of_added = exact_product(small * there, small * there)
    square, lost_of_sum = exact_sum(square, added)
    root = math.sqrt(square)
    length = (root + pair_root(square, lost_of_sum + (lost + lost_of_added), root)) * back
    return math.inf if side == math.inf or other == math.inf else length
