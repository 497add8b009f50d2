"""The periodic drift against the sine."""

import math

import pytest

from proofmass.blocks import PeriodicDrift
from tests.by_hand.functions import drive


def test_day_and_night() -> None:
    rows = drive(PeriodicDrift(amplitude="50 ppm", cycle_time="1 d", nominal=10.0), [{}] * 9, period=21600.0)
    assert [row["deviation"] for row in rows] == [0.0, 50e-6, 0.0, -50e-6] * 2 + [0.0]
    assert [row["value"] for row in rows[:4]] == [10.0, 10.0 * 1.00005, 10.0, 10.0 * (1.0 - 50e-6)]


def test_against_the_sine() -> None:
    block = PeriodicDrift(amplitude=0.3, cycle_time=0.7, phase=1.1)
    for tick, row in enumerate(drive(block, [{}] * 200, period=0.01)):
        expected = 0.3 * math.sin(2.0 * math.pi * 0.01 * tick / 0.7 + 1.1)
        assert row["deviation"] == pytest.approx(expected, abs=1e-14)
        assert row["value"] == 1.0 + row["deviation"]
