"""Rounding and clipping in plain arithmetic: one instruction each when compiled, the same bits in plain Python."""

import math

ROUNDS = 6755399441055744.0  # 1.5 * 2**52: adding it leaves no fraction bits


def round_half_even(value: float) -> float:
    """The nearest integer, ties to even, of a value of at most 2**51 in size.

    >>> round_half_even(2.5), round_half_even(3.5), round_half_even(-0.4)
    (2.0, 4.0, 0.0)
    """
    return (value + ROUNDS) - ROUNDS


def nearest_integer(value: float) -> float:
    """Round half to even a count of whole turns that is subtracted again: a step, not a quantised signal.

    The two differ where a graph is linearised: the slope of a quantiser is one, that of a count is
    zero.

    >>> nearest_integer(2.75)
    3.0
    """
    return (value + ROUNDS) - ROUNDS


def round_down(value: float) -> int:
    """The largest integer that is not above the value: a quantiser, where `math.floor` counts.

    >>> round_down(-2.5)
    -3
    """
    return math.floor(value)


def clip(value: float, low: float, high: float) -> float:
    """The value held between the bounds; a NaN comes out as `low`.

    >>> clip(3.0, -1.0, 2.0)
    2.0
    """
    above = value if value > low else low
    return above if above < high else high


def likely(condition: bool) -> bool:
    """The condition, which is true as a rule.

    Machine code of one run branches on it and goes on with what it expects, where it would else
    wait for the numbers that are compared and choose between both sides.

    >>> likely(1.0 < 2.0)
    True
    """
    return condition


def saturated(value: float, low: float, high: float) -> float:
    """Clip to bounds that are seldom reached, such as the codes of a converter.

    The two differ in speed alone: what follows does not wait for the bounds in machine code.

    >>> saturated(3.0, -1.0, 2.0)
    2.0
    """
    above = value if likely(value > low) else low
    return above if likely(above < high) else high


def wrapped(mantissa: int, low_bits: int, sign: int) -> int:
    """The low bits of an integer, as two's complement where `sign` is the highest of them, 0 for none.

    >>> wrapped(9, 15, 8), wrapped(9, 15, 0), wrapped(-9, 15, 8)
    (-7, 9, 7)
    """
    return ((mantissa & low_bits) ^ sign) - sign


def nearest_level(value: float, last: float) -> int:
    """The nearest of the levels 0 to `last`; a tie goes up.

    Here a quantiser knows that it has but two levels: its gain is then not one where a graph is
    linearised.

    >>> nearest_level(2.5, 7.0), nearest_level(-3.0, 7.0), nearest_level(0.7, 1.0)
    (3, 0, 1)
    """
    return round_down(saturated(value + 0.5, 0.0, last))


def nearest_even_level(value: float, last: float) -> float:
    """The nearest of the levels 0 to `last`; a tie goes to the even one.

    >>> nearest_even_level(2.5, 7.0), nearest_even_level(9.0, 7.0)
    (2.0, 7.0)
    """
    return round_half_even(clip(value, 0.0, last))


def two_level(on: bool, value: float) -> float:
    """1 where a comparison of a value is true, else -1: a one-bit quantiser of that value.

    >>> two_level(True, 0.3), two_level(False, -0.1)
    (1.0, -1.0)
    """
    return 1.0 if on else -1.0
