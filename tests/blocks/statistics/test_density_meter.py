"""Density at a frequency against Welch's method in scipy, for even and odd segments."""

import math

import numpy as np
import pytest
import scipy.signal

from proofmass.blocks import DensityMeter
from tests.by_hand.functions import drive

PERIOD = 1e-2


@pytest.mark.parametrize(("segment", "line"), [(32, 0), (32, 1), (32, 5), (32, 16), (33, 4)])
@pytest.mark.parametrize("skip", [0, 11])
def test_against_welch(segment: int, line: int, skip: int) -> None:
    inputs = (5.0 + np.random.default_rng(2).normal(size=500)).tolist()
    frequency = line / (segment * PERIOD)
    row = drive(DensityMeter(frequency=frequency, segment=segment, skip=skip), [{"input": u} for u in inputs], PERIOD)
    _, density = scipy.signal.welch(
        np.array(inputs)[skip:-1], 1.0 / PERIOD, "hann", nperseg=segment, noverlap=segment // 2, detrend="constant"
    )
    assert row[-1]["density"] == pytest.approx(math.sqrt(density[line]), rel=1e-10, abs=1e-12)


def test_before_the_first_whole_segment_it_is_zero() -> None:
    rows = drive(DensityMeter(frequency=10.0, segment=16), [{"input": float(k % 3)} for k in range(18)], PERIOD)
    assert all(row["density"] == 0.0 for row in rows[:16])
    assert rows[16]["density"] > 0.0
