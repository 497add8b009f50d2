"""Ohm's law."""

import pytest

from proofmass.blocks import VoltageToCurrent
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_voltage_over_resistance() -> None:
    rows = drive(VoltageToCurrent(resistance="342 ohm"), [{"voltage": v} for v in (0.0, 342.0, -1.71)])
    assert [row["current"] for row in rows] == pytest.approx([0.0, 1.0, -5e-3], rel=1e-15)


def test_the_resistor_may_drift_but_not_vanish() -> None:
    assert VoltageToCurrent.drivable("resistance")
    with pytest.raises(ModelError, match="must be > 0"):
        VoltageToCurrent(resistance=0.0)
