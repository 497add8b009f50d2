"""The gated average against fsum over each run of true ticks."""

import math

import numpy as np
import pytest

from proofmass.blocks import GatedAverage
from tests.by_hand.functions import drive


def test_each_window_by_itself_and_kept_until_the_next() -> None:
    values = np.random.default_rng(5).normal(size=60).tolist()
    gates = [10 <= n < 25 or 40 <= n < 41 or n >= 50 for n in range(60)]
    means = [
        row["mean"]
        for row in drive(GatedAverage(), [{"input": u, "measure": m} for u, m in zip(values, gates, strict=True)])
    ]
    assert means[:11] == [0.0] * 11
    assert means[17] == pytest.approx(math.fsum(values[10:17]) / 7, rel=1e-14)
    assert means[25:41] == pytest.approx([math.fsum(values[10:25]) / 15] * 16, rel=1e-14)
    assert means[41:51] == [values[40]] * 10
    assert means[59] == pytest.approx(math.fsum(values[50:59]) / 9, rel=1e-14)


def test_an_average_of_codes_is_exact() -> None:
    codes = [float(n % 3 - 86567) for n in range(30_000)]
    rows = drive(GatedAverage(), [{"input": u, "measure": True} for u in [*codes, 0.0]])
    assert rows[-1]["mean"] == -86566.0
