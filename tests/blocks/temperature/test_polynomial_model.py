"""The polynomial by Horner's rule against exact rational arithmetic."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import PolynomialModel
from tests.by_hand.functions import drive

NAMES = [f"c{k}" for k in range(7)]


@given(st.lists(st.floats(-10.0, 10.0), min_size=7, max_size=7), st.floats(-2.0, 2.0))
def test_against_exact_arithmetic(coefficients: list[float], temperature: float) -> None:
    block = PolynomialModel(**dict(zip(NAMES, coefficients, strict=True)))  # type: ignore[arg-type]
    found = drive(block, [{"temperature": temperature}])[0]["value"]
    terms = [Fraction(c) * Fraction(temperature) ** k for k, c in enumerate(coefficients)]
    assert abs(Fraction(found) - sum(terms)) <= Fraction(2, 10**15) * sum(map(abs, terms)) + Fraction(1, 10**300)


@pytest.mark.parametrize("order", range(7))
def test_each_power(order: int) -> None:
    block = PolynomialModel(**({"c1": 0.0} | {f"c{order}": 3.0}))  # type: ignore[arg-type]
    assert drive(block, [{"temperature": 2.0}])[0]["value"] == 3.0 * 2.0**order


def test_units_follow_the_temperature() -> None:
    block = PolynomialModel(c2="5 uV/K^2", temperature_unit="K")
    assert block.c2 == 5e-6
