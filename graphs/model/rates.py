"""Rates as exact fractions of a hertz: read, combined to a base rate, and divided."""

import math
from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.units import convert_exactly
from proofmass.graphs.model.limits import TEXT_LENGTH

Rate = Fraction | int | float | str
LARGEST_RATIO = 10**6  # base ticks per tick of the slowest block
LOWEST_RATE, HIGHEST_RATE = Fraction(1, 10**12), Fraction(10**15)
LONGEST_DURATION = Fraction(10**15)  # seconds
_ROUNDINGS = Fraction(1, 2**50)  # relative error of a float after four roundings
_SHORTER = 1000  # a nearby fraction is taken if its denominator is this many times smaller
_LONGEST_INTEGER = 10**80  # largest numerator or denominator


def read_rate(value: object) -> Fraction:
    """A rate in hertz, exactly: a number, a frequency such as "50 kHz" or "9600/3 Hz", or a period
    such as "20 us".

    >>> read_rate("20 us")
    Fraction(50000, 1)
    """
    example = 'write it as "50 kHz" or as the period "20 us"'
    rate = _frequency(value) if isinstance(value, str) else _number(value, "must be a rate", example)
    if rate <= 0:
        raise Refusal("must be above 0 Hz", example)
    if not LOWEST_RATE <= rate <= HIGHEST_RATE:
        raise Refusal("must lie between 1e-12 Hz and 1e15 Hz", example)
    return _short(rate)


def read_duration(value: object) -> Fraction:
    """A duration in seconds, exactly.

    >>> read_duration("1.5 min")
    Fraction(90, 1)
    """
    example = 'write it as "20 s"'
    seconds = _quantity(value, "s") if isinstance(value, str) else _number(value, "must be a duration", example)
    if seconds < 0:
        raise Refusal("must not be negative", example)
    if seconds > LONGEST_DURATION:
        raise Refusal("must be at most 1e15 s", example)
    return _short(seconds)


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


def common_base_rate(rates: Iterable[Fraction]) -> Fraction | None:
    """The base rate, or None if the slowest tick has more than `LARGEST_RATIO` base ticks."""
    base = slowest = None
    for rate in set(rates):
        base = rate if base is None else base_rate((base, rate))
        slowest = rate if slowest is None else min(slowest, rate)
        if base > LARGEST_RATIO * slowest:
            return None
    return base


class Clock(NamedTuple):
    """The times of a signal's values: `offset`, in seconds, and every 1 / `rate` from then on."""

    rate: Fraction
    offset: Fraction = Fraction(0)

    def time(self, tick: int) -> Fraction:
        """Return when a tick is, in seconds."""
        return self.offset + tick / self.rate

    def first(self, time: Fraction) -> int:
        """Return the first tick at a time or after it."""
        return max(0, math.ceil((time - self.offset) * self.rate))


def with_offsets(base: Fraction, offsets: Iterable[Fraction]) -> Fraction:
    """The slowest multiple of a base rate whose ticks meet offsets in seconds.

    >>> with_offsets(Fraction(10_000), [Fraction(25, 10**6)])
    Fraction(40000, 1)
    """
    for offset in offsets:
        base *= (base * offset).denominator
    return base


def write_rate(rate: Fraction) -> str:
    """A rate as text that reads back to the same fraction.

    >>> write_rate(Fraction(50000)), write_rate(Fraction(9600, 1023))
    ('50 kHz', '3200/341 Hz')
    """
    for factor, unit in ((10**9, "GHz"), (10**6, "MHz"), (10**3, "kHz")):
        text = f"{float(rate / factor):g}"
        if rate >= factor and Fraction(text) * factor == rate:
            return f"{text} {unit}"
    return f"{_decimal(rate)} Hz"


def write_seconds(duration: Fraction) -> str:
    """A duration as text, in the prefix that makes it a number of few digits.

    >>> write_seconds(Fraction(25, 10**6)), write_seconds(Fraction(1, 3))
    ('25 us', '1/3 s')
    """
    for factor, unit in ((1, "s"), (10**3, "ms"), (10**6, "us"), (10**9, "ns"), (10**12, "ps")):
        text = f"{float(duration * factor):g}"
        if duration * factor >= 1 and Fraction(text) == duration * factor:
            return f"{text} {unit}"
    return f"{duration} s"


def _decimal(value: Fraction) -> str:
    """A number as a decimal of at most twelve digits where that is the same number, otherwise as a fraction."""
    text = f"{float(value):.12g}"
    return text if "e" not in text and Fraction(text) == value else str(value)


def simplest(value: float) -> Fraction:
    """The fraction of the smallest numbers within four roundings of a number above zero: a
    formula's rate, exactly.

    A decimal that is about as short is taken as it stands.

    >>> simplest(1.0 / 5e-6), simplest(1e6 / 3.0)
    (Fraction(200000, 1), Fraction(1000000, 3))
    """
    exact, decimal = Fraction(value), Fraction(repr(value))
    fraction = _between(exact * (1 - _ROUNDINGS), exact * (1 + _ROUNDINGS))
    return fraction if fraction.denominator * _SHORTER < decimal.denominator else decimal


def _between(low: Fraction, high: Fraction) -> Fraction:
    """The fraction of the smallest numbers between two, by continued fractions (Graham, Knuth and Patashnik, 4.5)."""
    whole = math.ceil(low)
    if whole <= high:
        return Fraction(whole)
    whole -= 1
    return whole + 1 / _between(1 / (high - whole), 1 / (low - whole))


def _frequency(text: str) -> Fraction:
    try:
        return _quantity(text, "Hz")
    except Refusal as error:
        try:
            period = _quantity(text, "s")
        except Refusal:
            raise error from None
        return 1 / period if period > 0 else Fraction(0)


def _quantity(text: str, unit: str) -> Fraction:
    if len(text) > TEXT_LENGTH:
        raise Refusal(f"a text of over {TEXT_LENGTH} characters")
    return convert_exactly(text, unit)


def _number(value: object, message: str, example: str) -> Fraction:
    value = plain(value)
    if isinstance(value, bool) or not isinstance(value, int | float | Fraction):
        raise Refusal(message, example)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise Refusal("must be finite", example)
        return Fraction(repr(value))
    return Fraction(value)


def _short(value: Fraction) -> Fraction:
    """Refuse numbers too long to be written in a file and counted in ticks."""
    if max(value.numerator, value.denominator) > _LONGEST_INTEGER:
        raise Refusal("has more than 80 digits")
    return value
