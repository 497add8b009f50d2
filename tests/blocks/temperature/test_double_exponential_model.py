"""The model of two exponentials against the library's exponential, in volts and in kelvins."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import DoubleExponentialModel
from proofmass.blocks.declaration.instance import unit_of
from tests.by_hand.functions import drive


@given(st.floats(-1.0, 1.0), st.floats(-8.0, 8.0), st.floats(-1.0, 1.0), st.floats(-8.0, 8.0), st.floats(-2.0, 2.0))
def test_against_the_formula(a1: float, b1: float, a2: float, b2: float, temperature: float) -> None:
    row = drive(DoubleExponentialModel(a1=a1, b1=b1, a2=a2, b2=b2), [{"temperature": temperature}])[0]
    parts = a1 * math.exp(b1 * temperature), a2 * math.exp(b2 * temperature)
    assert row["value"] == pytest.approx(sum(parts), abs=1e-15 * sum(map(abs, parts)) + 1e-300)


def test_units_follow_the_temperature() -> None:
    block = DoubleExponentialModel(b1="-57.5 1/kK", temperature_unit="K", a1="12 mg0", a2=0.0, unit="m/s^2")
    assert block.b1 == pytest.approx(-0.0575)
    assert block.a1 == pytest.approx(12e-3 * 9.80665)
    assert unit_of(block, type(block).parameters["b2"]) == "1/(K)"


def test_finite_however_large_the_temperature() -> None:
    rows = drive(DoubleExponentialModel(), [{"temperature": 1e12}, {"temperature": -1e12}])
    assert all(math.isfinite(row["value"]) for row in rows)
