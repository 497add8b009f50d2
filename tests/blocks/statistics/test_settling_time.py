"""The settling time of steps: against the last sample outside, and the closed form of a first-order lag."""

import math

import numpy as np
import pytest

from proofmass.blocks import SettlingTime
from tests.by_hand.functions import drive


@pytest.mark.parametrize("skip", [0, 3])
def test_against_the_last_sample_outside(skip: int) -> None:
    inputs = (2.0 + np.random.default_rng(4).normal(size=200)).tolist()
    block = SettlingTime(target=2.0, within=1.5, skip=skip)
    rows = drive(block, [{"input": u} for u in inputs], period=0.25)
    for tick, row in enumerate(rows):
        outside = [k for k, u in enumerate(inputs[skip:tick]) if abs(u - 2.0) > 1.5]
        assert row["time_to_settle"] == (0.25 * (1 + outside[-1]) if outside else 0.0)
        assert row["settled"] == (tick > skip and abs(inputs[tick - 1] - 2.0) <= 1.5)


def test_a_first_order_lag_settles_within_two_per_cent_after_four_time_constants() -> None:
    period = 1e-3
    inputs = [{"input": 1.0 - math.exp(-k * period)} for k in range(6000)]
    row = drive(SettlingTime(target=1.0, within=0.02), inputs, period)[-1]
    assert row["settled"]
    assert row["time_to_settle"] == pytest.approx(math.log(50.0), abs=period)
