"""The random walk: its step, and its variance over many runs of the generator."""

import math

import numpy as np
import pytest

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.noise_and_drift.random_walk import RandomWalk, State, constants, update
from tests.by_hand.functions import drive


def test_starts_at_the_nominal_value_and_adds_up() -> None:
    rows = drive(RandomWalk(coefficient=0.5, nominal=4.0), [{}] * 5, period=0.25, normal=2.0)
    assert [row["deviation"] for row in rows] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert [row["value"] for row in rows] == [4.0, 6.0, 8.0, 10.0, 12.0]


@pytest.mark.exhaustive("0.01")
@pytest.mark.parametrize("period", [0.01, 0.1])
def test_variance_grows_with_time_whatever_the_rate(period: float) -> None:
    c = constants(RandomWalk(coefficient="200 ppm/sqrt(s)"), period)
    ends, ticks = [], round(2.0 / period)
    for run in range(400):
        x = State(0.0)
        for tick in range(ticks):
            x = update(c, x, normal_deviate(11, run, 0, tick))
        ends.append(x.deviation)
    expected = 200e-6 * math.sqrt(2.0)
    assert np.std(ends) == pytest.approx(expected, rel=4.0 / math.sqrt(800.0))
    assert abs(np.mean(ends)) < 4.0 * expected / math.sqrt(400.0)
