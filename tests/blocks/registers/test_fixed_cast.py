"""The cast against fractions, for every rounding and overflow, wider and narrower formats."""

import pytest

from proofmass.blocks import FixedCast
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

FORMATS = [(Fixed(24, 18), Fixed(16, 12)), (Fixed(12, 2), Fixed(20, 9)), (Fixed(16, 12), Fixed(9, 6, signed=False))]


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize(("source", "target"), FORMATS, ids=str)
def test_against_fractions(source: Fixed, target: Fixed, rounding: str, overflow: str) -> None:
    block = FixedCast(input_format=source, output_format=target, rounding=rounding, overflow=overflow)
    inputs = words(source, 500)
    rows = drive_fixed(block, [{"input": m} for m in inputs])
    expected = [cast(value_of(m, source), target, rounding, overflow) for m in inputs]
    assert [row["output"] for row in rows] == expected
    assert len(set(expected)) > 50


def test_formats_are_texts_or_values() -> None:
    assert FixedCast(input_format="(20, 3) unsigned").input_format == Fixed(20, 3, signed=False)
    assert FixedCast(input_format=" ( 20 ,-3 )").input_format == Fixed(20, -3)
    for text in ("(0, 3)", "20.3", "(20, 3", "(20, 3) signed", "(9999, 0)"):
        with pytest.raises(ModelError, match=r'expected: a format such as "\(16, 12\)": bits in all'):
            FixedCast(input_format=text)
