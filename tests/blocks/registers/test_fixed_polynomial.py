"""Horner's rule against fractions, rounded in every step, orders 1 to 6, and against the model in floating point."""

import pytest

from proofmass.blocks import FixedPolynomial, PolynomialModel
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

COEFFICIENTS = (0.0458, -0.132, 0.1453, -0.0701, 0.01287, -0.003, 0.7)
VOLTS, SUM = Fixed(18, 16), Fixed(24, 22)


@pytest.mark.exhaustive(but=16)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("order", range(1, 7))
def test_against_fractions(order: int, rounding: str, overflow: str) -> None:
    known = {f"c{k}": c for k, c in enumerate(COEFFICIENTS[: order + 1])}
    block = FixedPolynomial(order=order, **({"c1": 0.0} | known), sum_format=SUM, rounding=rounding, overflow=overflow)
    inputs = words(VOLTS, 100, seed=order)
    expected = []
    for m in inputs:
        rounded = [round(c * 2**22) for c in known.values()]
        total = rounded.pop()
        while rounded:
            exact = value_of(total, SUM) * value_of(m, VOLTS) + value_of(rounded.pop(), SUM)
            total = cast(exact, SUM, rounding, overflow)
        expected.append(total)
    assert [row["value"] for row in drive_fixed(block, [{"temperature": m} for m in inputs])] == expected


def test_against_the_model_in_floating_point() -> None:
    known = {f"c{k}": c for k, c in enumerate(COEFFICIENTS[:5])}
    inputs = range(round(0.6 * 65536), round(1.8 * 65536), 997)
    rows = drive_fixed(FixedPolynomial(order=4, **known), [{"temperature": m} for m in inputs])
    expected = drive(PolynomialModel(**known), [{"temperature": m / 65536} for m in inputs])
    assert [row["value"] / 2**24 for row in rows] == pytest.approx(
        [row["value"] for row in expected], abs=24 * 2.0**-25
    )


def test_a_coefficient_above_the_order_is_refused() -> None:
    with pytest.raises(ModelError, match="0, as the order is 3"):
        FixedPolynomial(order=3, c4=0.1)
