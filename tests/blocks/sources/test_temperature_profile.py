"""The temperature profile against interpolation between its corners."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import TemperatureProfile
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive


def test_soaks_and_ramps_by_hand() -> None:
    block = TemperatureProfile(temperatures=[300.0, 310.0, 290.0], soak_time=2.0, pace=5.0)
    found = [row["temperature"] for row in drive(block, [{}] * 14)]
    assert found == [300, 300, 300, 305, 310, 310, 310, 305, 300, 295, 290, 290, 290, 290]


@given(
    st.lists(st.floats(200.0, 400.0), min_size=1, max_size=6),
    st.floats(0.0, 5.0),
    st.floats(1.0, 500.0),
    st.sampled_from([0.1, 1.0, 30.0]),
)
def test_against_interpolation(temperatures: list[float], soak: float, pace: float, period: float) -> None:
    times, corners = [0.0], [temperatures[0]]
    for before, after in pairwise(temperatures):
        times += [times[-1] + soak, times[-1] + soak + abs(after - before) / pace]
        corners += [before, after]
    block = TemperatureProfile(temperatures=temperatures, soak_time=soak, pace=pace)
    found = [row["temperature"] for row in drive(block, [{}] * 100, period)]
    assert found == pytest.approx(np.interp(period * np.arange(100), times, corners), abs=1e-9)
    assert min(temperatures) - 1e-9 <= min(found)
    assert max(found) <= max(temperatures) + 1e-9


def test_absolute_temperatures_only() -> None:
    with pytest.raises(ModelError, match="must be > 0"):
        TemperatureProfile(temperatures=[25.0, -40.0])
