"""The law of two exponentials against the library's exponential."""

import math

import pytest

from proofmass.blocks import TemperatureDoubleExponential
from tests.by_hand.functions import drive


@pytest.mark.parametrize("voltage", [0.0, 0.6, 1.1, 1.8, -2.0])
def test_against_the_formula(voltage: float) -> None:
    block = TemperatureDoubleExponential(a1=-0.3, b1=-3.0, a2=0.02, b2=2.0, nominal=1.65, unit="V")
    row = drive(block, [{"sensor_voltage": voltage}])[0]
    expected = -0.3 * math.exp(-3.0 * voltage) + 0.02 * math.exp(2.0 * voltage)
    assert row["deviation"] == pytest.approx(expected, abs=1e-15, rel=1e-14)
    assert row["value"] == pytest.approx(1.65 * (1.0 + expected), rel=1e-14)


def test_finite_however_high_the_voltage() -> None:
    rows = drive(TemperatureDoubleExponential(), [{"sensor_voltage": 1e9}, {"sensor_voltage": -1e9}])
    assert all(math.isfinite(row["value"]) for row in rows)
