"""The Riccati equation against scipy, and the solution of linear equations against numpy."""

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks.arithmetic.riccati import solved, steady_covariance


@pytest.mark.parametrize("order", [1, 2, 4, 8])
@pytest.mark.parametrize("radius", [0.5, 0.999, 1.5])
def test_against_scipy(order: int, radius: float) -> None:
    dice = np.random.default_rng(order)
    a = dice.normal(size=(order, order))
    a *= radius / max(abs(np.linalg.eigvals(a)))
    c, root = dice.normal(size=order), dice.normal(size=(order, order))
    q = root @ root.T
    expected = linalg.solve_discrete_are(a.T, c[:, None], q, np.array([[0.3]]))
    found = steady_covariance(a.tolist(), c.tolist(), q.tolist(), 0.3)
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_linear_equations_against_numpy() -> None:
    dice = np.random.default_rng(0)
    matrix, right = dice.normal(size=(7, 7)), dice.normal(size=(7, 3))
    assert np.abs(np.array(solved(matrix.tolist(), right.tolist())) - np.linalg.solve(matrix, right)).max() < 1e-12
