"""Hyperbolic sine, cosine and tangent, from e^x = 2^n (1 + p) as a pair.

With t = 4^-n and a = p (2 + p): sinh x = 2^(n-1) (1 - t + a) / (1 + p), and cosh x has 1 + t. With n and p of 2 x and
t = 2^-n: tanh x = (1 - t + p) / (1 + t + p). Nothing cancels but 1 - t, which is exact.
"""

import math

from proofmass.blocks.arithmetic.exponentials import exponential_parts
from proofmass.blocks.arithmetic.pairs import exact_sum, ordered_sum, pair_product, pair_quotient
from proofmass.blocks.arithmetic.scaling import power_of_two, scaled

LARGEST = 711.0  # beyond it both are infinite
SMALL = 1.0e-9  # up to it sine and tangent are their argument


def hyperbolic_sine(value: float) -> float:
    """sinh, within 0.6 ulp; infinite where that is too large.

    >>> hyperbolic_sine(1e-20), hyperbolic_sine(-1000.0)
    (1e-20, -inf)
    """
    result = math.copysign(_half_sum(abs(value), -1.0), value)
    return value if abs(value) < SMALL else result


def hyperbolic_cosine(value: float) -> float:
    """cosh, within 0.55 ulp; infinite where that is too large.

    >>> hyperbolic_cosine(0.0), hyperbolic_cosine(-1000.0)
    (1.0, inf)
    """
    return _half_sum(abs(value), 1.0)


def hyperbolic_tangent(value: float) -> float:
    """tanh, within 0.6 ulp.

    >>> hyperbolic_tangent(1e-20), hyperbolic_tangent(-1000.0)
    (1e-20, -1.0)
    """
    size = abs(value)
    exponent, p, rest = exponential_parts(2.0 * (22.0 if size > 22.0 else size), 0.0)
    p, rest = ordered_sum(p, rest)
    t = power_of_two(-exponent)
    above, above_low = _added(1.0, -t, p, rest)
    below, below_low = _added(1.0, t, p, rest)
    high, low = pair_quotient(above, above_low, below, below_low)
    return value if size < SMALL else math.copysign(high + low, value)


def _half_sum(size: float, sign: float) -> float:
    """Half of exp(size) + sign exp(-size)."""
    exponent, p, rest = exponential_parts(LARGEST if size > LARGEST else size, 0.0)
    p, rest = ordered_sum(p, rest)
    whole, whole_low = ordered_sum(1.0, p)
    above, above_low = exact_sum(2.0, p)
    a, a_low = pair_product(p, rest, above, above_low + rest)
    t = power_of_two(-2.0 * exponent if exponent < 200.0 else -400.0)
    above, above_low = _added(1.0, sign * t, a, a_low)
    high, low = pair_quotient(above, above_low, whole, whole_low + rest)
    return scaled(high + low, exponent - 1.0)


def _added(one: float, t: float, p: float, rest: float) -> tuple[float, float]:
    """one + t + (p + rest), as a pair."""
    total, lost = exact_sum(one, t)
    total, lost_of_p = exact_sum(total, p)
    return ordered_sum(total, lost_of_p + (lost + rest))
