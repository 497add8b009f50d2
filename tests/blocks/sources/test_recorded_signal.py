"""A recording played back: held and interpolated, against NumPy."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import RecordedSignal
from tests.by_hand.functions import drive

TIMES = [0.5, 1.0, 1.125, 3.0]
VALUES = [4.0, -2.0, 8.0, 1.0]


def play(times: list[float], values: list[float], interpolated: bool, ticks: int, period: float) -> list[float]:
    block = RecordedSignal(file="recording.csv", interpolated=interpolated)
    rows = drive(block, [{}] * ticks, period, recorded={"times": times, "values": values})
    return [row["output"] for row in rows]


def test_held_between_the_recorded_times() -> None:
    assert play(TIMES, VALUES, False, 8, 0.5) == [4.0, 4.0, -2.0, 8.0, 8.0, 8.0, 1.0, 1.0]


def test_straight_lines_between_the_recorded_times() -> None:
    got = play(TIMES, VALUES, True, 33, 0.125)
    assert got == pytest.approx(np.interp(np.arange(33) * 0.125, TIMES, VALUES), rel=1e-15)
    assert (got[0], got[4], got[8], got[9], got[24], got[32]) == (4.0, 4.0, -2.0, 8.0, 1.0, 1.0)


points = st.dictionaries(st.integers(-50, 400), st.floats(-1e9, 1e9), min_size=1, max_size=30)


@given(points, st.integers(1, 40))
def test_any_recording_at_any_rate_against_numpy(recorded: dict[int, float], stride: int) -> None:
    ticks = np.arange(300 // stride) * stride
    times, values = zip(*sorted(recorded.items()), strict=True)
    seconds = [t * 0.01 for t in times]
    lines = play(seconds, list(values), True, len(ticks), stride * 0.01)
    np.testing.assert_allclose(lines, np.interp(ticks * 0.01, seconds, values), rtol=1e-9, atol=1e-4)
    steps = play(seconds, list(values), False, len(ticks), stride * 0.01)
    assert steps == [values[max(0, int(np.searchsorted(times, tick, "right")) - 1)] for tick in ticks]


def test_a_recording_at_the_rate_of_the_block_is_played_row_by_row() -> None:
    rate = 48000
    values = [float(n) for n in range(1000)]
    assert play([float(f"{n / rate:.9f}") for n in range(1000)], values, False, 1000, 1 / rate) == values
    assert play([n / rate for n in range(1000)], values, True, 1000, 1 / rate) == pytest.approx(values, abs=1e-9)
