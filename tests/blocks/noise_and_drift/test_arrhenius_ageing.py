"""Ageing by Arrhenius' law: the acceleration, and its integral over a changing temperature."""

import math

import pytest
from scipy.constants import electron_volt, k

from proofmass.blocks.noise_and_drift.arrhenius_ageing import BOLTZMANN, ArrheniusAgeing
from tests.by_hand.functions import drive

BLOCK = ArrheniusAgeing(
    pace="2 ppm/d",
    activation_energy=0.7 * electron_volt,
    reference_temperature=328.15,
    start_deviation=1e-6,
    nominal=4.0,
)


def test_boltzmann() -> None:
    assert k == BOLTZMANN


def test_known_acceleration_of_a_burn_in() -> None:
    row = drive(BLOCK, [{"temperature": 398.15}])[0]
    assert row["acceleration"] == pytest.approx(77.6, abs=0.1)  # 0.7 eV, 55 to 125 degrees Celsius: the usual 78
    assert drive(BLOCK, [{"temperature": 328.15}])[0]["acceleration"] == pytest.approx(1.0, rel=1e-14)


def test_a_deviation_that_is_the_integral_of_the_pace() -> None:
    temperatures = [300.0 + 2.0 * n for n in range(50)]
    rows = drive(BLOCK, [{"temperature": t} for t in temperatures], period=3600.0)
    expected = 1e-6
    for row, temperature in zip(rows, temperatures, strict=True):
        assert row["deviation"] == pytest.approx(expected, rel=1e-13)
        assert row["value"] == 4.0 * (1.0 + row["deviation"])
        exponent = 0.7 * electron_volt / k * (1.0 / 328.15 - 1.0 / temperature)
        expected += 2e-6 / 24.0 * math.exp(exponent)


def test_the_law_holds_down_to_one_kelvin() -> None:
    cold = ArrheniusAgeing(activation_energy=1e-4 * electron_volt, reference_temperature=100.0)
    found = [drive(cold, [{"temperature": t}])[0]["acceleration"] for t in (0.99, 1.0, 1.5)]
    assert found[0] == 0.0
    assert found[1:] == pytest.approx([math.exp(1e-4 * electron_volt / k * (0.01 - 1.0 / t)) for t in (1.0, 1.5)])


@pytest.mark.parametrize("temperature", [0.0, -300.0, 0.5, 2.0, 1e300])
def test_no_temperature_is_too_much(temperature: float) -> None:
    row = drive(BLOCK, [{"temperature": temperature}])[0]
    assert 0.0 <= row["acceleration"] < 1e12
