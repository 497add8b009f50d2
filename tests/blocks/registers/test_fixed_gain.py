"""The gain against exact products, and against Gain."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedGain, Gain
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

WORD = Fixed(16, 12)


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_exact_products(rounding: str, overflow: str) -> None:
    block = FixedGain(gain=-1.7, output_format=Fixed(14, 11), rounding=rounding, overflow=overflow)
    gain = Fraction(round(-1.7 * 2**14), 2**14)
    inputs = words(WORD, 500)
    rows = drive_fixed(block, [{"input": m} for m in inputs])
    expected = [cast(gain * value_of(m, WORD), Fixed(14, 11), rounding, overflow) for m in inputs]
    assert [row["output"] for row in rows] == expected


def test_within_half_a_step_of_the_gain_in_floating_point() -> None:
    block, sibling = FixedGain(gain=0.37), Gain(gain=0.37)
    inputs = words(WORD, 300, seed=2)
    found = [row["output"] / 4096 for row in drive_fixed(block, [{"input": m} for m in inputs])]
    expected = [row["output"] for row in drive(sibling, [{"input": m / 4096} for m in inputs])]
    assert found == pytest.approx(expected, abs=0.5 / 4096 + 8 * 2.0**-15)
