"""The mean absolute value against that of the whole record."""

import math
import statistics

import numpy as np
import pytest

from proofmass.blocks import MeanAbsolute
from tests.by_hand.functions import drive


@pytest.mark.parametrize("skip", [0, 1, 17])
@pytest.mark.parametrize("offset", [-5.0, 0.0, 5.0])
def test_of_all_samples_before_the_tick(skip: int, offset: float) -> None:
    inputs = (offset + np.random.default_rng(2).normal(size=60)).tolist()
    rows = drive(MeanAbsolute(skip=skip), [{"input": u} for u in inputs])
    for tick, row in enumerate(rows):
        samples = inputs[skip:tick]
        expected = statistics.fmean(map(abs, samples)) if samples else 0.0
        assert row["mean_absolute"] == pytest.approx(expected, rel=1e-14)


def test_a_sine_has_two_over_pi_of_its_amplitude() -> None:
    turn = [math.sin(2.0 * math.pi * (k + 0.5) / 10_000) for k in range(10_000)]
    rows = drive(MeanAbsolute(), [{"input": 3.0 * u} for u in [*turn, 0.0]])
    assert rows[-1]["mean_absolute"] == pytest.approx(6.0 / math.pi, rel=1e-7)


@pytest.mark.defect(
    "S1025", before="the mean size of a slow drift lagged by up to half a rounding a tick", after="all digits"
)
def test_small_steps_of_a_large_mean_count() -> None:
    """A rounding of 1 in two ticks: a mean of its digits alone stays at 1."""
    rounding, steps = 2.0**-52, [tick // 2 for tick in range(2003)]
    row = drive(MeanAbsolute(), [{"input": -1.0 - step * rounding} for step in steps])[-1]
    assert row["mean_absolute"] == 1.0 + round(statistics.fmean(steps[:-1])) * rounding
