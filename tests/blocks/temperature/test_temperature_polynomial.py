"""Temperature coefficients against the polynomial, in kelvin and in degrees Celsius."""

import pytest

from proofmass.blocks import TemperaturePolynomial
from tests.by_hand.functions import drive


def test_nominal_at_the_reference() -> None:
    rows = drive(TemperaturePolynomial(nominal=2.5, tc2=1e-7), [{"temperature": 298.15}])
    assert rows == [{"value": 2.5, "deviation": 0.0}]


@pytest.mark.parametrize("above", [-65.0, -3.0, 1.0, 60.0])
@pytest.mark.parametrize("reference", [25.0, 298.15])
def test_against_the_polynomial(above: float, reference: float) -> None:
    block = TemperaturePolynomial(tc1="9 ppm/K", tc2="-0.04 ppm/K^2", reference_temperature=reference, nominal=3.0)
    row = drive(block, [{"temperature": reference + above}])[0]
    expected = 9e-6 * above - 0.04e-6 * above**2
    assert row["deviation"] == pytest.approx(expected, rel=1e-12)
    assert row["value"] == pytest.approx(3.0 * (1.0 + expected), rel=1e-15)
