"""The sum against integers."""

import pytest

from proofmass.blocks import FixedSum
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

WORD, NARROW = Fixed(12, 8), Fixed(11, 5)
NAMES = ("first", "second", "third", "fourth")


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_integers(rounding: str, overflow: str) -> None:
    block = FixedSum(input_format=WORD, output_format=NARROW, rounding=rounding, overflow=overflow)
    columns = [words(WORD, 400, seed) for seed in range(4)]
    samples = [dict(zip(NAMES, row, strict=True)) for row in zip(*columns, strict=True)]
    found = [row["output"] for row in drive_fixed(block, samples)]
    assert found == [cast(value_of(sum(s.values()), WORD), NARROW, rounding, overflow) for s in samples]


def test_it_holds_every_sum_of_wide_enough_words() -> None:
    block = FixedSum(input_format=WORD, output_format=Fixed(14, 8))
    ends = [dict.fromkeys(NAMES, end) for end in (WORD.lowest, WORD.highest)]
    assert [row["output"] for row in drive_fixed(block, ends)] == [-8192, 8188]
