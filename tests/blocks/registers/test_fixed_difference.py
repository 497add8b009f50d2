"""The difference against integers."""

import pytest

from proofmass.blocks import FixedDifference
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

WORD, NARROW = Fixed(12, 8), Fixed(10, 6)


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_integers(rounding: str, overflow: str) -> None:
    block = FixedDifference(input_format=WORD, output_format=NARROW, rounding=rounding, overflow=overflow)
    pairs = list(zip(words(WORD, 400, 1), words(WORD, 400, 2), strict=True))
    rows = drive_fixed(block, [{"first": a, "second": b} for a, b in pairs])
    expected = [cast(value_of(a - b, WORD), NARROW, rounding, overflow) for a, b in pairs]
    assert [row["output"] for row in rows] == expected
