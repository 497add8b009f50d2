"""Rates are exact fractions: read, combined and written without losing a bit."""

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.declaration.problem import Refusal
from proofmass.graphs.model.rates import (
    HIGHEST_RATE,
    LARGEST_RATIO,
    LOWEST_RATE,
    base_rate,
    common_base_rate,
    read_duration,
    read_rate,
    write_rate,
)

rates = st.fractions(min_value=LOWEST_RATE, max_value=HIGHEST_RATE, max_denominator=10**12)
small_rates = st.fractions(min_value=Fraction(1, 50), max_value=1000, max_denominator=50)


@pytest.mark.parametrize(
    ("given", "hertz"),
    [
        ("50 kHz", 50_000),
        (50_000, 50_000),
        (50e3, 50_000),
        (0.1, Fraction(1, 10)),
        ("0.1", Fraction(1, 10)),
        ("20 us", 50_000),
        ("20 µs", 50_000),
        ("9600/1023 Hz", Fraction(9600, 1023)),
        ("1/3 s", 3),
        ("5 1/s", 5),
        ("2 min", Fraction(1, 120)),
        ("1e-12 Hz", LOWEST_RATE),
        ("1e15 Hz", HIGHEST_RATE),
        (Fraction(1, 3), Fraction(1, 3)),
    ],
)
def test_rates_are_read_exactly(given: object, hertz: Fraction) -> None:
    assert read_rate(given) == hertz


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (0, "must be above 0 Hz"),
        (-1, "must be above 0 Hz"),
        ("-1 Hz", "must be above 0 Hz"),
        ("0 s", "must be above 0 Hz"),
        ("-3 us", "must be above 0 Hz"),
        (math.nan, "must be finite"),
        (-math.inf, "must be finite"),
        (True, "must be a rate"),
        (None, "must be a rate"),
        ([50], "must be a rate"),
        ("fast", "not a number followed by a unit"),
        ("50 khz", "unknown unit 'khz'"),
        ("50 V", "V is m^2*kg/s^3/A, not 1/s"),
        (10**400, "must lie between 1e-12 Hz and 1e15 Hz"),
        ("1e16 Hz", "must lie between 1e-12 Hz and 1e15 Hz"),
        ("1e-13 Hz", "must lie between 1e-12 Hz and 1e15 Hz"),
        ("1." + "3" * 90, "has more than 80 digits"),
        ("1" * 1000, "a text of over 400 characters"),
    ],
)
def test_what_is_no_rate_is_refused(given: object, message: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_rate(given)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("given", "seconds"), [("20 s", 20), ("1.5 min", 90), (0.1, Fraction(1, 10)), (0, 0), ("1/3 s", Fraction(1, 3))]
)
def test_durations_are_read_exactly(given: object, seconds: Fraction) -> None:
    assert read_duration(given) == seconds


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (-1, "must not be negative"),
        ("-1 ms", "must not be negative"),
        (math.nan, "must be finite"),
        (-math.inf, "must be finite"),
        (10**400, "must be at most 1e15 s"),
        (1e-300, "has more than 80 digits"),
        (False, "must be a duration"),
        ("5 m", "m is m, not s"),
    ],
)
def test_what_is_no_duration_is_refused(given: object, message: str) -> None:
    with pytest.raises(Refusal) as caught:
        read_duration(given)
    assert str(caught.value) == message


@given(rates)
def test_a_written_rate_reads_back_exactly(rate: Fraction) -> None:
    assert read_rate(write_rate(rate)) == rate


@given(st.integers(min_value=1, max_value=10**15))
def test_a_written_whole_rate_reads_back_exactly(rate: int) -> None:
    assert read_rate(write_rate(Fraction(rate))) == rate


@given(rates)
def test_a_period_is_the_inverse_of_its_rate(rate: Fraction) -> None:
    assert read_rate(f"{1 / rate} s") == rate


@given(st.lists(small_rates, min_size=1, max_size=5))
def test_the_base_rate_is_the_least_that_every_rate_divides(chosen: list[Fraction]) -> None:
    base = base_rate(chosen)
    ratios = [base / rate for rate in chosen]
    assert all(ratio.denominator == 1 for ratio in ratios)
    assert math.gcd(*(ratio.numerator for ratio in ratios)) == 1


@given(st.lists(small_rates, min_size=1, max_size=5))
def test_the_common_base_rate_is_the_base_rate_or_out_of_reach(chosen: list[Fraction]) -> None:
    reachable = base_rate(chosen) <= LARGEST_RATIO * min(chosen)
    assert common_base_rate(chosen) == (base_rate(chosen) if reachable else None)


def test_a_million_base_ticks_in_a_slow_one_are_within_reach_and_one_more_is_not() -> None:
    assert common_base_rate([Fraction(1), Fraction(10**6)]) == LARGEST_RATIO
    assert common_base_rate([Fraction(1), Fraction(10**6 + 1)]) is None


def test_ten_thousand_incommensurable_rates_end_at_once() -> None:
    assert common_base_rate(Fraction(10**15 - n, 10**9 + n) for n in range(10_000)) is None


def test_9600_beside_3200_hertz() -> None:
    assert base_rate([Fraction(9600), Fraction(3200), Fraction(4800)]) == 9600
    assert base_rate([Fraction(2), Fraction(3)]) == 6
    assert base_rate([Fraction(1, 2), Fraction(1, 3)]) == 1
