"""The quotient, and its guard near zero."""

from proofmass.blocks import Quotient
from tests.by_hand.responses import noise, responses


def test_far_from_zero_it_is_the_quotient() -> None:
    numerator, denominator = noise(300, 1), [u + 5.0 if u > 0 else u - 5.0 for u in noise(300, 2)]
    expected = [a / b for a, b in zip(numerator, denominator, strict=True)]
    assert responses(Quotient(), numerator=numerator, denominator=denominator) == expected


def test_near_zero_the_divisor_stays_as_large_as_the_guard() -> None:
    denominator = [0.5, 0.25, 0.125, 0.0, -0.0, -0.125, -0.25, -0.5]
    answer = responses(Quotient(smallest=0.25), numerator=[1.0] * 8, denominator=denominator)
    assert answer == [2.0, 4.0, 4.0, 4.0, 4.0, -4.0, -4.0, -2.0]
