"""The running range against that of the whole record."""

import numpy as np
import pytest

from proofmass.blocks import RunningRange
from tests.by_hand.functions import drive


@pytest.mark.parametrize("skip", [0, 1, 17])
@pytest.mark.parametrize("offset", [-5.0, 0.0, 5.0])
def test_of_all_samples_before_the_tick(skip: int, offset: float) -> None:
    inputs = (offset + np.random.default_rng(2).normal(size=60)).tolist()
    rows = drive(RunningRange(skip=skip), [{"input": u} for u in inputs])
    assert rows[0] == {"minimum": 0.0, "maximum": 0.0, "peak_to_peak": 0.0}
    for tick, row in enumerate(rows):
        samples = inputs[skip:tick]
        if samples:
            assert (row["minimum"], row["maximum"]) == (min(samples), max(samples))
            assert row["peak_to_peak"] == max(samples) - min(samples)
