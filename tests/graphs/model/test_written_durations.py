"""Durations as text, in the prefix that needs the fewest digits."""

from fractions import Fraction

import pytest

from proofmass.graphs.model.rates import write_seconds


@pytest.mark.parametrize(
    ("duration", "text"),
    [
        (Fraction(2), "2 s"),
        (Fraction(25, 10**4), "2.5 ms"),
        (Fraction(3, 10**6), "3 us"),
        (Fraction(7, 10**9), "7 ns"),
        (Fraction(15, 10**13), "1.5 ps"),
        (Fraction(1, 10**13), "1/10000000000000 s"),
        (Fraction(1, 3), "1/3 s"),
    ],
)
def test_durations(duration: Fraction, text: str) -> None:
    assert write_seconds(duration) == text
