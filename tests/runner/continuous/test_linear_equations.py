"""Gaussian elimination against numpy.linalg."""

import numpy as np
import pytest

from proofmass.runner.continuous.linear_equations import factorise, substitute


@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_random_equations_in_rows_of_different_units(n: int) -> None:
    draw = np.random.default_rng(n)
    for _ in range(20):
        rows = draw.normal(size=(n, n)) * 10.0 ** draw.integers(-12, 12, size=(n, 1))
        right = rows @ draw.normal(size=n)
        flat, order, solution = rows.ravel().tolist(), [0.0] * n, right.tolist()
        assert factorise(flat, n, order)
        substitute(flat, n, order, solution)
        scaled = np.abs(rows).max(axis=1)
        expected = np.linalg.solve(rows / scaled[:, None], right / scaled)
        np.testing.assert_allclose(solution, expected, rtol=1e-12 * np.linalg.cond(rows / scaled[:, None]))


def test_equations_that_want_an_exchange_of_rows() -> None:
    flat, order, right = [0.0, 2.0, 3.0, 0.0], [0.0, 0.0], [4.0, 9.0]
    assert factorise(flat, 2, order)
    substitute(flat, 2, order, right)
    assert right == [3.0, 2.0]


@pytest.mark.parametrize("flat", [[0.0, 0.0, 0.0, 1.0], [1.0, 2.0, 2.0, 4.0], [float("nan")] * 4])
def test_what_has_no_single_solution_is_said_to_have_none(flat: list[float]) -> None:
    assert not factorise(flat, 2, [0.0, 0.0])
