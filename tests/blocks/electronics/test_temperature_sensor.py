"""The temperature sensor against its line, in kelvin and in degrees Celsius."""

import pytest

from proofmass.blocks import TemperatureSensor
from tests.by_hand.functions import drive


def test_nominal_at_the_reference() -> None:
    assert drive(TemperatureSensor(), [{"temperature": 298.15}]) == [{"voltage": 1.2}]


@pytest.mark.parametrize("reference", [22.5, 295.65])
def test_the_range_of_the_chamber(reference: float) -> None:
    block = TemperatureSensor(slope="9.6 mV/K", reference_temperature=reference)
    rows = drive(block, [{"temperature": reference - 62.5}, {"temperature": reference + 62.5}])
    assert [row["voltage"] for row in rows] == pytest.approx([0.6, 1.8], abs=1e-12)


def test_a_sensor_that_falls() -> None:
    rows = drive(TemperatureSensor(slope="-2 mV/K"), [{"temperature": 308.15}])
    assert rows[0]["voltage"] == pytest.approx(1.18, abs=1e-12)
