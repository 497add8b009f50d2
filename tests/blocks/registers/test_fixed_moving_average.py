"""The average against exact fractions of the last inputs."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedMovingAverage
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words


@pytest.mark.exhaustive(but=6)
@pytest.mark.parametrize("word", [Fixed(16, 12), Fixed(10, 4, signed=False)], ids=str)
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("order", [1, 4])
def test_against_fractions(order: int, rounding: str, word: Fixed) -> None:
    out = Fixed(18, 9)
    block = FixedMovingAverage(order=order, input_format=word, output_format=out, rounding=rounding)
    inputs = words(word, 200)
    expected = []
    for n in range(len(inputs)):
        last = inputs[max(n - (1 << order) + 1, 0) : n + 1]
        mean = sum((value_of(m, word) for m in last), Fraction(0)) / (1 << order)
        expected.append(cast(mean, out, rounding, "saturate"))
    assert [row["mean"] for row in drive_fixed(block, [{"input": m} for m in inputs])] == expected
