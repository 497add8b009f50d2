"""The residual against NumPy, and when it comes."""

import numpy as np
import pytest

from proofmass.blocks import ResponseResidual
from tests.by_hand.functions import drive


def test_root_mean_square_of_each_period() -> None:
    measured, modelled = np.random.default_rng(8).normal(size=(2, 31))
    rows = drive(
        ResponseResidual(chips=10),
        [{"measured": y, "modelled": m} for y, m in zip(measured.tolist(), modelled.tolist(), strict=True)],
    )
    expected = [np.sqrt(np.mean((measured - modelled)[10 * n : 10 * n + 10] ** 2)) for n in range(3)]
    found = [row["residual"] for row in rows]
    assert found[:10] == [0.0] * 10
    assert [found[10], found[20], found[30]] == pytest.approx(expected, rel=1e-14)
    assert found[10:20] == [found[10]] * 10
