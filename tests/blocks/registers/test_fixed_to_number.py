"""The way back to numbers: exact for every word, and the inverse of the quantiser."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedQuantiser, FixedToNumber
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import value_of, words
from tests.by_hand.functions import drive


@pytest.mark.parametrize("format", [Fixed(16, 12), Fixed(53, 60), Fixed(20, -7), Fixed(12, 4, signed=False)], ids=str)
def test_exact_and_back(format: Fixed) -> None:
    inputs = words(format, 300)
    found = [row["output"] for row in drive(FixedToNumber(input_format=format), [{"input": m} for m in inputs])]
    assert [Fraction(number) for number in found] == [value_of(m, format) for m in inputs]
    back = drive(FixedQuantiser(output_format=format), [{"input": number} for number in found])
    assert [row["output"] for row in back] == inputs


def test_a_format_that_a_number_does_not_hold_is_refused() -> None:
    with pytest.raises(ModelError, match="at most 53 bits, which is what a number holds exactly"):
        FixedToNumber(input_format="(54, 0)")
