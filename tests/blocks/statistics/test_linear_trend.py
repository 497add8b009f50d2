"""The slope against least squares of NumPy over all samples before the tick."""

import numpy as np
import pytest

from proofmass.blocks import LinearTrend
from tests.by_hand.functions import drive


@pytest.mark.parametrize("skip", [0, 1, 17])
def test_against_least_squares(skip: int) -> None:
    inputs = (1e3 + 0.5 * np.arange(80) + np.random.default_rng(2).normal(size=80)).tolist()
    rows = drive(LinearTrend(skip=skip), [{"input": u} for u in inputs], period=0.25)
    for tick, row in enumerate(rows):
        samples = inputs[skip:tick]
        assert row["count"] == len(samples)
        if len(samples) > 1:
            slope = np.polyfit(0.25 * (np.arange(len(samples)) - len(samples) / 2), samples, 1)[0]
            assert row["slope"] == pytest.approx(slope, rel=1e-9)
        else:
            assert row["slope"] == 0.0


@pytest.mark.defect(
    "S1023", before="a drift of 1e-12 a second of 9.8 m/s^2 had a slope of 1.8e-12: the mean lost it", after="1e-12"
)
def test_small_steps_of_a_large_mean_count() -> None:
    """A rounding of 1 in two ticks: a mean of its digits alone stays at 1, and the slope is twice as large."""
    rounding = 2.0**-52
    steps = [tick // 2 for tick in range(2001)]
    rows = drive(LinearTrend(), [{"input": 1.0 + step * rounding} for step in steps], period=1.0)
    assert rows[-1]["slope"] / rounding == pytest.approx(np.polyfit(range(2000), steps[:-1], 1)[0], rel=1e-9)
