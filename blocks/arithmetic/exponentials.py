"""Exponentials: e^x = 2^n (1 + p), with n = round(x / ln 2) and p of the rest, at most ln(2) / 2.

Reduction after Cody and Waite, Software Manual for the Elementary Functions (1980), in two parts of
42 bits, times whole numbers of 11; p = r + r^2 / 2 + r^3 P(r), with P the minimax polynomial of
degree 9 (relative error 2^-60, benchmarks/elementary_fits.py). What sums and products lose is added
again.
"""

from proofmass.blocks.arithmetic.pairs import exact_product, exact_sum, ordered_sum
from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.blocks.arithmetic.scaling import power_of_two, scaled

LN2, LN2_LOW = 0.6931471805598903, 5.49792301870721e-14
LOG2_E = 1.4426950408889634


def exponential(value: float) -> float:
    """e to the power of the value, within 0.76 ulp; infinity where that is too large, 0 where it is too small.

    >>> exponential(0.0), exponential(-1.0), exponential(1000.0), exponential(-1000.0)
    (1.0, 0.36787944117144233, inf, 0.0)
    """
    return exponential_of_pair(value, 0.0)


def bounded_exponential(value: float) -> float:
    """The exponential, within 0.76 ulp, but of -354 and 354 beyond them: sums and products with it stay finite.

    >>> bounded_exponential(1e9) == exponential(354.0), bounded_exponential(-1e9) == exponential(-354.0)
    (True, True)
    """
    return exponential(354.0 if value > 354.0 else -354.0 if value < -354.0 else value)


def exponential_of_pair(value: float, low: float) -> float:
    """e to the power of the sum of two numbers, the second at most a rounding of the first where that is in range."""
    held = 710.0 if value > 710.0 else -746.0 if value < -746.0 else value
    exponent, p, rest = exponential_parts(held, low if held == value else 0.0)
    whole, lost = ordered_sum(1.0, p)
    return scaled(whole + (lost + rest), exponent)


def exponential_parts(value: float, low: float) -> tuple[float, float, float]:
    """n, p and the rest of p of the exponential of a pair, |value| <= 1420."""
    exponent = nearest_integer(value * LOG2_E)
    r, lost = exact_sum(value - exponent * LN2, low - exponent * LN2_LOW)
    square, lost_of_square = exact_product(r, r)
    series = 2.7557244333751807e-06 + r * 2.75572458680301e-07
    series = series + square * (2.5108996839913207e-08 + r * 2.092367497101461e-09)
    series = 0.0001984126988598858 + r * 2.480158735575812e-05 + square * series
    series = 0.008333333333321695 + r * 0.0013888888888870326 + square * series
    series = 0.16666666666666677 + r * 0.04166666666666669 + square * series
    p, lost_of_p = ordered_sum(r, 0.5 * square)
    return exponent, p, lost_of_p + ((lost + r * lost) + (0.5 * lost_of_square + r * square * series))


def exponential_less_one(value: float) -> float:
    """e to the power of the value, less 1, within 0.65 ulp, for small values too; infinity where
    that is too large.

    >>> exponential_less_one(1e-20), exponential_less_one(-1000.0), exponential_less_one(1000.0)
    (1e-20, -1.0, inf)
    """
    held = 710.0 if value > 710.0 else -40.0 if value < -40.0 else value
    exponent, p, rest = exponential_parts(held, 0.0)
    part = power_of_two(-exponent if exponent < 200.0 else -200.0)
    whole, lost = exact_sum(1.0, -part)
    whole, lost_of_p = exact_sum(whole, p)
    large = scaled(whole + (lost_of_p + (lost + rest)), exponent)
    return value if abs(value) < 1.0e-17 else large
