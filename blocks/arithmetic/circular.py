"""Sine, cosine and tangent: minimax polynomials on an eighth of a turn, of degree 5 in the square.

sin r = r + r^3 S(r^2) and cos r = 1 - r^2 / 2 + r^4 C(r^2), relative errors 2^-58 and 2^-64
(benchmarks/elementary_fits.py), each with what rounding takes off the first two terms.
"""

from proofmass.blocks.arithmetic.angles import less_quarters
from proofmass.blocks.arithmetic.pairs import exact_product, ordered_sum, pair_quotient

SMALL = 1.0e-9  # up to it sine and tangent are their argument


def sine(angle: float) -> float:
    """The sine of an angle in radians, of any size, within 0.8 ulp; NaN of an infinite one.

    >>> sine(0.0), sine(1.5707963267948966), sine(1e22)
    (0.0, 1.0, -0.8522008497671888)
    """
    quarters, r, rest = less_quarters(angle)
    (high, low), (other, other_low) = _sine_part(r, rest), _cosine_part(r, rest)
    odd = abs(quarters) == 1.0
    value = other + other_low if odd else high + low
    negative = quarters == -1.0 or abs(quarters) == 2.0
    return angle if abs(angle) < SMALL else -value if negative else value


def cosine(angle: float) -> float:
    """The cosine of an angle in radians, of any size, within 0.8 ulp; NaN of an infinite one.

    >>> cosine(0.0), cosine(1e22)
    (1.0, 0.523214785395139)
    """
    quarters, r, rest = less_quarters(angle)
    (other, other_low), (high, low) = _sine_part(r, rest), _cosine_part(r, rest)
    odd = abs(quarters) == 1.0
    value = other + other_low if odd else high + low
    negative = quarters == 1.0 or abs(quarters) == 2.0
    return -value if negative else value


def tangent(angle: float) -> float:
    """The tangent of an angle in radians, of any size, within 0.95 ulp; NaN of an infinite one.

    >>> tangent(0.0), tangent(1e22)
    (0.0, -1.6287782256068988)
    """
    quarters, r, rest = less_quarters(angle)
    (s, s_low), (c, c_low) = _sine_part(r, rest), _cosine_part(r, rest)
    odd = abs(quarters) == 1.0
    above, above_low = -c if odd else s, -c_low if odd else s_low
    below, below_low = s if odd else c, s_low if odd else c_low
    high, low = pair_quotient(above, above_low, below, below_low)
    return angle if abs(angle) < SMALL else high + low


def _sine_part(r: float, rest: float) -> tuple[float, float]:
    z = r * r
    fourth = z * z
    series = 2.7557313705052092e-06 + z * (-2.5050759886056258e-08 + z * 1.5896886215259137e-10)
    series = 0.008333333333322486 + z * -0.00019841269829853355 + fourth * series
    return ordered_sum(r, rest * (1.0 - 0.5 * z) + r * z * (-0.16666666666666632 + z * series))


def _cosine_part(r: float, rest: float) -> tuple[float, float]:
    z, lost = exact_product(r, r)
    half = 0.5 * z
    fourth = z * z
    series = -2.755731439926595e-07 + z * (2.087572899400557e-09 + z * -1.1359917295960915e-11)
    series = 0.0416666666666666 + z * (-0.001388888888887447 + z * 2.480158728966691e-05) + fourth * z * series
    whole = 1.0 - half
    return ordered_sum(whole, ((1.0 - whole) - half) + (fourth * series - (r * rest + 0.5 * lost)))
