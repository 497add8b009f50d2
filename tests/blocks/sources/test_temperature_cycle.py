"""The temperature cycle against interpolation between its corners."""

import numpy as np
import pytest

from proofmass.blocks import TemperatureCycle
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.sources.temperature_cycle import Constants, bends
from tests.by_hand.functions import drive


def test_one_cycle_by_hand() -> None:
    rows = drive(TemperatureCycle(low=250.0, high=350.0, pace=50.0, soak_time=2.0), [{}] * 17)
    cycle = [250, 300, 350, 350, 350, 300, 250, 250]
    assert [row["temperature"] for row in rows] == [*cycle, *cycle, 250]


@pytest.mark.parametrize("soak", ["0 s", "10 min", "3 h"])
def test_many_cycles_against_interpolation(soak: str) -> None:
    block = TemperatureCycle(pace="2.5 K/min", soak_time=soak)
    up, stay = 125.0 / 2.5 * 60.0, block.soak_time
    corners = [0.0, up, up + stay, 2.0 * up + stay, 2.0 * (up + stay)]
    times = 333.0 * np.arange(2000)
    expected = np.interp(times, corners, [233.15, 358.15, 358.15, 233.15, 233.15], period=corners[-1])
    found = [row["temperature"] for row in drive(block, [{}] * 2000, period=333.0)]
    assert found == pytest.approx(expected, abs=1e-8)
    assert min(found) >= 233.15
    assert max(found) <= np.nextafter(358.15, 400.0)


def test_nothing_to_cycle_between_is_refused() -> None:
    with pytest.raises(ModelError, match="above low"):
        TemperatureCycle(low=300.0, high=300.0)


def test_marks_differ_between_stretches_and_stay_within_them() -> None:
    """Two seconds up, two at the top, two down, two at the bottom, and so on: a mark for each."""
    c = Constants(250.0, 100.0, 50.0, 4.0)
    marks = [{bends(c, 2.0 * stretch + part) for part in (0.1, 1.0, 1.9)} for stretch in range(9)]
    assert [len(mark) for mark in marks] == [1] * 9
    assert len(set.union(*marks)) == 9
