"""Least squares over records against NumPy's, and on responses made of the derivatives."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks import LeastSquaresController
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

DICE = np.random.default_rng(5)
JACOBIAN = DICE.normal(size=(64, 2))
MODELLED = DICE.normal(size=64)
START = np.array([50.0, 3e-3])
NAMES = ("measured", "modelled", "by_stiffness", "by_damping")


def fitted(measured: Any, jacobian: Any = JACOBIAN, **values: Any) -> Any:
    """Parameters in each of 64 samples, and in one more."""
    block = LeastSquaresController(initial_stiffness=50.0, initial_damping=3e-3, **values)
    columns = (np.append(v, 0.0).tolist() for v in (measured, MODELLED, *jacobian.T))
    rows = drive(block, [dict(zip(NAMES, row, strict=True)) for row in zip(*columns, strict=True)])
    return np.array([[row["stiffness"], row["damping"]] for row in rows])


@pytest.mark.parametrize("settling", [0, 5, 30])
def test_a_record_is_fitted_by_least_squares_from_where_it_has_settled(settling: int) -> None:
    measured = MODELLED + 0.05 * DICE.normal(size=64)
    found = fitted(measured, samples=32, settling=settling)
    now = START
    for record in range(2):
        fit = slice(32 * record + settling, 32 * record + 32)
        step, *_ = np.linalg.lstsq(JACOBIAN[fit], (measured - MODELLED)[fit])
        larger = max(abs(step))
        now = now * (1.0 + step * min(1.0, 0.2 / larger))
        assert found[32 * record + 32] == pytest.approx(now, rel=1e-12)
    assert (found[:32] == START).all()


def test_what_tells_nothing_moves_nothing() -> None:
    assert fitted(MODELLED + 1.0, JACOBIAN[:, [0, 0]], samples=64, settling=0)[-1].tolist() == START.tolist()


def test_a_large_step_keeps_its_direction() -> None:
    found = fitted(MODELLED + JACOBIAN @ [4.0, -2.0], samples=64, settling=0)
    assert found[-1] == pytest.approx(START * [1.2, 0.9], rel=1e-12)


def test_a_record_without_samples_is_refused() -> None:
    with pytest.raises(ModelError, match="two parameters need two samples"):
        LeastSquaresController(samples=100, settling=99)
