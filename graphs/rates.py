"""Rates as exact fractions of a hertz: read, combined to a base rate, and divided."""

import math
from collections.abc import Iterable
from fractions import Fraction

from proofmass.blocks.units import UnitError, convert_exactly, same_dimension

Rate = Fraction | int | float | str
LARGEST_RATIO = 10**6  # base ticks per tick of the slowest block


def read_rate(value: object) -> Fraction:
    """A rate in hertz, exactly: a number, a frequency such as "50 kHz" or "9600/3 Hz", or a period such as "20 us".

    >>> read_rate("20 us")
    Fraction(50000, 1)
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str | Fraction):
        raise UnitError("must be a rate", 'write it as "50 kHz" or as the period "20 us"')
    if isinstance(value, str):
        unit_text = value.strip().lstrip("+-0123456789._/eE ")
        if unit_text and same_dimension(unit_text, "s"):
            period = convert_exactly(value, "s")
            rate = 1 / period if period > 0 else Fraction(0)
        else:
            rate = convert_exactly(value, "Hz")
    else:
        if not math.isfinite(value):
            raise UnitError("must be finite")
        rate = Fraction(repr(value)) if isinstance(value, float) else Fraction(value)
    if rate <= 0:
        raise UnitError("must be above 0 Hz")
    if rate > 10**15 or rate < Fraction(1, 10**12):
        raise UnitError("must lie between 1e-12 Hz and 1e15 Hz")
    return rate


def base_rate(rates: Iterable[Fraction]) -> Fraction:
    """The least common multiple of the rates: the slowest rate that every one of them divides.

    >>> base_rate([Fraction(9600), Fraction(3200), Fraction(4800)])
    Fraction(9600, 1)
    """
    numerator, denominator = 1, 0
    for rate in rates:
        numerator = math.lcm(numerator, rate.numerator)
        denominator = math.gcd(denominator, rate.denominator)
    return Fraction(numerator, denominator or 1)


def write_rate(rate: Fraction) -> str:
    """A rate as text that reads back to the same fraction.

    >>> write_rate(Fraction(50000)), write_rate(Fraction(9600, 1023))
    ('50 kHz', '3200/341 Hz')
    """
    for factor, unit in ((10**9, "GHz"), (10**6, "MHz"), (10**3, "kHz")):
        scaled = rate / factor
        if scaled >= 1 and (scaled * 1000).denominator == 1:
            return f"{float(scaled):g} {unit}" if Fraction(f"{float(scaled):g}") == scaled else f"{rate} Hz"
    return f"{rate} Hz"
