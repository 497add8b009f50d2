"""Logarithms of any positive number m 2^n: 2 atanh(s), s = (m - 1) / (m + 1), plus n ln 2.

`_near_one` sums that up as fdlibm does (Sun Microsystems 1993): the largest term is exact, and the
rest is small. The logarithm as a pair has 2 s + 2 s^3 / 3 + 2 s^5 / 5 as pairs, and the minimax
polynomial of degree 6 behind them (relative error 2^-72, benchmarks/elementary_fits.py): for powers
and other bases.
"""

import math

from proofmass.blocks.arithmetic.exponentials import LN2, LN2_LOW
from proofmass.blocks.arithmetic.pairs import exact_product, exact_sum, ordered_sum, pair_product, pair_quotient
from proofmass.blocks.arithmetic.scaling import mantissa_and_exponent


def logarithm(value: float) -> float:
    """Natural logarithm, within 0.86 ulp; NaN of zero and below.

    >>> logarithm(0.5), logarithm(1.0), logarithm(0.0)
    (-0.6931471805599453, 0.0, nan)
    """
    m, exponent = mantissa_and_exponent(_positive(value))
    return _defined(value, _near_one(m, exponent, 0.0))


def logarithm_of_one_plus(value: float) -> float:
    """Natural logarithm of 1 + value, within 0.86 ulp, small values too; NaN of -1 and below.

    >>> logarithm_of_one_plus(1e-30), logarithm_of_one_plus(1.0)
    (1e-30, 0.6931471805599453)
    """
    held = value if value > -1.0 and value < math.inf else 0.0
    whole, lost = exact_sum(1.0, held)
    m, exponent = mantissa_and_exponent(whole)
    result = _near_one(m, exponent, lost / whole)
    result = value if abs(value) < 1.0e-17 or value == math.inf else result
    return result if value > -1.0 else math.nan


def binary_logarithm(value: float) -> float:
    """Logarithm to the base of 2, within 0.51 ulp, exact for its powers; NaN of zero and below.

    >>> binary_logarithm(8.0), binary_logarithm(5e-324)
    (3.0, -1074.0)
    """
    m, exponent = mantissa_and_exponent(_positive(value))
    high, low = logarithm_as_pair(m, 0.0)
    high, low = pair_product(high, low, 1.4426950408889634, 2.0355273740931033e-17)
    high, lost = exact_sum(exponent, high)
    return _defined(value, high + (lost + low))


def decimal_logarithm(value: float) -> float:
    """Logarithm to the base of 10, within 0.51 ulp, exact for its powers; NaN of zero and below.

    >>> decimal_logarithm(1000.0), decimal_logarithm(1e-5)
    (3.0, -5.0)
    """
    m, exponent = mantissa_and_exponent(_positive(value))
    high, low = logarithm_as_pair(m, exponent)
    high, low = pair_product(high, low, 0.4342944819032518, 1.098319650216765e-17)
    return _defined(value, high + low)


def logarithm_as_pair(m: float, exponent: float) -> tuple[float, float]:
    """ln(m 2^exponent), m between the roots of 1/2 and 2, with a relative error of 2^-69."""
    f = m - 1.0
    below, below_low = ordered_sum(2.0, f)
    s, s_low = pair_quotient(f, 0.0, below, below_low)
    z, z_low = exact_product(s, s)
    z_low = z_low + 2.0 * s * s_low
    fourth = z * z
    series = 0.11685040199496091 + z * 0.11910990991938003
    series = (0.15384572898155238 + z * 0.1333576317213006) + fourth * series
    series = (0.22222222220012464 + z * 0.18181818605444003) + fourth * series
    part, part_low = ordered_sum(0.4, z * (0.2857142857143316 + z * series))
    part, part_low = pair_product(part, part_low - 2.2204460492503132e-17, z, z_low)
    factor, factor_low = ordered_sum(0.6666666666666666, part)
    factor_low = factor_low + (part_low + 3.700743415417188e-17)
    cube, cube_low = pair_product(s, s_low, z, z_low)
    rest, rest_low = pair_product(cube, cube_low, factor, factor_low)
    high, low = ordered_sum(2.0 * s, rest)
    low = low + (rest_low + 2.0 * s_low)
    high, lost = exact_sum(exponent * LN2, high)
    return ordered_sum(high, lost + (low + exponent * LN2_LOW))


def logarithm_of_fraction(value: float) -> float:
    """Natural logarithm for 2^-64 <= value <= 1, within 0.9 ulp: the logarithm, but faster.

    >>> logarithm_of_fraction(0.5), logarithm_of_fraction(1.0)
    (-0.6931471805599453, 0.0)
    """
    m, exponent = value, 0.0
    small = m < 2.3283064365386963e-10
    m, exponent = m * 4294967296.0 if small else m, exponent - 32.0 if small else exponent
    small = m < 1.52587890625e-05
    m, exponent = m * 65536.0 if small else m, exponent - 16.0 if small else exponent
    small = m < 0.00390625
    m, exponent = m * 256.0 if small else m, exponent - 8.0 if small else exponent
    small = m < 0.0625
    m, exponent = m * 16.0 if small else m, exponent - 4.0 if small else exponent
    small = m < 0.25
    m, exponent = m * 4.0 if small else m, exponent - 2.0 if small else exponent
    small = m < 0.5
    m, exponent = m * 2.0 if small else m, exponent - 1.0 if small else exponent
    small = m < 0.7071067811865476
    m, exponent = m * 2.0 if small else m, exponent - 1.0 if small else exponent
    return _near_one(m, exponent, 0.0)


def _positive(value: float) -> float:
    """The number where it has a finite logarithm, 1 elsewhere."""
    return value if value > 0.0 and value < math.inf else 1.0


def _defined(value: float, result: float) -> float:
    """The result where there is one."""
    result = math.inf if value == math.inf else result
    return result if value > 0.0 else math.nan


def _near_one(m: float, exponent: float, rest: float) -> float:
    """ln(m 2^exponent) + rest, m between the roots of 1/2 and 2."""
    f = m - 1.0
    s = f / (2.0 + f)
    z = s * s
    series = 0.22222198563735626 + z * (0.18183564858891618 + z * (0.15314035909787893 + z * 0.14796105847937446))
    series = z * (0.6666666666666734 + z * (0.39999999999414343 + z * (0.2857142874247136 + z * series)))
    half_square = 0.5 * f * f
    rest = s * (half_square + series) + (exponent * 1.9082149292705877e-10 + rest)
    return exponent * 0.6931471803691238 - ((half_square - rest) - f)
