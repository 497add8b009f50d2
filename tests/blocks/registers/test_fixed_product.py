"""The product against exact fractions."""

import pytest

from proofmass.blocks import FixedProduct
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.instance import unit_of
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

FIRST, SECOND = Fixed(16, 12), Fixed(18, 14)


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("output", [Fixed(16, 12), Fixed(34, 26)])
def test_against_exact_products(rounding: str, overflow: str, output: Fixed) -> None:
    block = FixedProduct(output_format=output, rounding=rounding, overflow=overflow)
    pairs = list(zip(words(FIRST, 400), words(SECOND, 400, seed=2), strict=True))
    rows = drive_fixed(block, [{"first": a, "second": b} for a, b in pairs])
    expected = [cast(value_of(a, FIRST) * value_of(b, SECOND), output, rounding, overflow) for a, b in pairs]
    assert [row["output"] for row in rows] == expected


def test_the_unit_is_the_product_of_units() -> None:
    block = FixedProduct(first_unit="1/V", second_unit="V")
    assert unit_of(block, type(block).outputs["output"]) == "(1/V)*(V)"
