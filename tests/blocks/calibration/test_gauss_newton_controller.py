"""Gauss-Newton steps against NumPy's least squares and on responses made of them."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks import GaussNewtonController
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive

DICE = np.random.default_rng(5)
JACOBIAN = DICE.normal(size=(16, 2))
MODELLED = DICE.normal(size=16)
START = np.array([50.0, 3e-3])


def stepped(measured: Any, jacobian: Any = JACOBIAN, **values: Any) -> Any:
    block = GaussNewtonController(initial_stiffness=50.0, initial_damping=3e-3, **values)
    names = ("measured", "modelled", "by_stiffness", "by_damping")
    vectors = (measured, MODELLED, *jacobian.T)
    rows = drive(block, [dict(zip(names, (v.tolist() for v in vectors), strict=True))] * 2)
    return np.array([[row["stiffness"], row["damping"]] for row in rows])


@pytest.mark.parametrize(("first", "last"), [(1, 15), (0, 15), (3, 9)])
def test_the_step_is_that_of_least_squares_in_the_lags_of_the_fit(first: int, last: int) -> None:
    measured = MODELLED + 0.05 * DICE.normal(size=16)
    fit = slice(first, last + 1)
    expected, *_ = np.linalg.lstsq(JACOBIAN[fit], (measured - MODELLED)[fit])
    found = stepped(measured, first=first, last=last, largest_step=0.9)
    assert found[0] == pytest.approx(START * (1.0 + expected), rel=1e-13)
    assert found[1] == pytest.approx(found[0] * (1.0 + expected), rel=1e-13)


@pytest.mark.parametrize(
    ("step", "taken"),
    [((4.0, -2.0), (1.2, 0.9)), ((2.0, -4.0), (1.1, 0.8)), ((0.01, 0.5), (1.004, 1.2)), ((0.1, 0.15), (1.1, 1.15))],
)
def test_a_large_step_keeps_its_direction(step: tuple[float, float], taken: tuple[float, float]) -> None:
    """The larger of the two changes is 0.2, whichever it is; a step that is smaller is taken whole."""
    found = stepped(MODELLED + JACOBIAN @ step)
    assert found[0] == pytest.approx(START * taken, rel=1e-12)


def test_responses_that_are_nearly_alike_still_tell_two_parameters() -> None:
    """What is left of one beside the other is a thousandth."""
    alike = np.column_stack([JACOBIAN[:, 0], JACOBIAN[:, 0] + 1e-3 * JACOBIAN[:, 1]])
    found = stepped(MODELLED + alike @ (0.1, 0.15), alike)
    assert found[0] == pytest.approx(START * (1.1, 1.15), rel=1e-8)


@pytest.mark.parametrize("jacobian", [np.zeros((16, 2)), JACOBIAN[:, [0, 0]]], ids=["no response", "equal columns"])
def test_what_tells_nothing_moves_nothing(jacobian: Any) -> None:
    assert stepped(MODELLED + 1.0, jacobian)[0].tolist() == START.tolist()


@pytest.mark.parametrize(
    ("values", "expected"), [({"last": 16}, "less than cells = 16"), ({"first": 15}, "two parameters need two lags")]
)
def test_lags_that_do_not_fit_are_refused(values: dict[str, int], expected: str) -> None:
    with pytest.raises(ModelError, match=expected):
        GaussNewtonController(**values)
