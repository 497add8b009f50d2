"""Running statistics against those of the whole record."""

import statistics

import numpy as np
import pytest

from proofmass.blocks import RunningStatistics
from tests.by_hand.functions import drive


@pytest.mark.parametrize("skip", [0, 1, 17])
def test_of_all_samples_before_the_tick(skip: int) -> None:
    inputs = (5.0 + np.random.default_rng(2).normal(size=60)).tolist()
    rows = drive(RunningStatistics(skip=skip), [{"input": u} for u in inputs])
    for tick, row in enumerate(rows):
        samples = inputs[skip:tick]
        assert row["count"] == len(samples)
        if len(samples) > 1:
            assert row["mean"] == pytest.approx(statistics.fmean(samples), rel=1e-14)
            assert row["standard_deviation"] == pytest.approx(statistics.stdev(samples), rel=1e-13)
            square = statistics.fmean(u * u for u in samples)
            assert row["root_mean_square"] == pytest.approx(square**0.5, rel=1e-14)


def test_none_and_one_sample() -> None:
    rows = drive(RunningStatistics(), [{"input": -3.0}, {"input": 9.0}])
    assert rows[0] == {"count": 0, "mean": 0.0, "standard_deviation": 0.0, "root_mean_square": 0.0}
    assert rows[1] == {"count": 1, "mean": -3.0, "standard_deviation": 0.0, "root_mean_square": 3.0}


def test_a_small_scatter_on_a_large_mean() -> None:
    """Where the difference of sums of squares loses every digit (Welford 1962)."""
    inputs = [1e9 + offset for offset in (4.0, 7.0, 13.0, 16.0)] * 250
    rows = drive(RunningStatistics(), [{"input": u} for u in [*inputs, 0.0]])
    assert rows[-1]["mean"] == pytest.approx(1e9 + 10.0, rel=1e-14)
    assert rows[-1]["standard_deviation"] == pytest.approx((22.5 * 1000 / 999) ** 0.5, rel=1e-9)


@pytest.mark.defect(
    "S1024", before="the std of a drift of 1e-12 a second of 9.8 m/s^2 was 78 % too large", after="all digits"
)
def test_small_steps_of_a_large_mean_count() -> None:
    """A rounding of 1 in two ticks: a mean of its digits alone stays at 1."""
    rounding, steps = 2.0**-52, [tick // 2 for tick in range(2003)]
    row = drive(RunningStatistics(), [{"input": 1.0 + step * rounding} for step in steps])[-1]
    assert row["mean"] == 1.0 + round(statistics.fmean(steps[:-1])) * rounding
    assert row["standard_deviation"] / rounding == pytest.approx(statistics.stdev(steps[:-1]), rel=1e-9)
