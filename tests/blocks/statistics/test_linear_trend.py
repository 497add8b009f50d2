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
