"""Bounds of structured singular values: against SLICOT, closed forms, and each other."""

import numpy as np
import pytest

from proofmass.runner.analysis.several.structured import lower_bound, upper_bound

slycot = pytest.importorskip("slycot")


@pytest.mark.exhaustive
@pytest.mark.parametrize(("size", "count"), [(2, 4), (3, 2), (4, 1)])
def test_upper_bounds_are_those_of_slicot(size: int, count: int) -> None:
    rng = np.random.default_rng(size)
    for _ in range(count):
        units = np.exp(1.5 * rng.standard_normal((size, size)))
        matrix = (rng.standard_normal((size, size)) + 1j * rng.standard_normal((size, size))) * units
        known = slycot.ab13md(matrix, [1] * size, [2] * size)[0]
        found = upper_bound(matrix, [1] * size).bound
        assert found == pytest.approx(known, rel=1e-6)
        low, turn = lower_bound(matrix, [1] * size)
        assert low <= found * (1.0 + 1e-9)
        assert np.abs(turn) == pytest.approx(np.ones(size))
        assert low == pytest.approx(float(np.max(np.abs(np.linalg.eigvals(turn[:, None] * matrix)))), rel=1e-6)
        if size <= 3:
            assert low == pytest.approx(found, rel=1e-5), "up to three blocks both are the value itself"


def test_blocks_of_several_values() -> None:
    rng = np.random.default_rng(9)
    matrix = rng.standard_normal((5, 5)) + 1j * rng.standard_normal((5, 5))
    known = slycot.ab13md(matrix, [2, 3], [2, 2])[0]
    assert upper_bound(matrix, [2, 3]).bound == pytest.approx(known, rel=1e-6)


def test_closed_forms() -> None:
    triangular = np.array([[0.5, 100.0], [0.0, -0.7]], dtype=complex)
    assert upper_bound(triangular, [1, 1]).bound == pytest.approx(0.7, rel=1e-6), "one way does not close a loop"
    assert lower_bound(triangular, [1, 1])[0] == pytest.approx(0.7, rel=1e-9)
    turned = np.array([[0.0, 4.0], [9.0, 0.0]], dtype=complex)
    assert upper_bound(turned, [1, 1]).bound == pytest.approx(6.0, rel=1e-9)
    units = np.array([[0.0, 1e12], [1e-12, 0.0]], dtype=complex)
    assert upper_bound(units, [1, 1]).bound == pytest.approx(1.0, rel=1e-9), "whatever the units of the wires"
    assert upper_bound(np.zeros((2, 2), dtype=complex), [1, 1]).bound == 0.0


def test_a_matrix_of_rank_one() -> None:
    """The factors turn all products of its column and its row to one phase."""
    column, row = np.array([1.0, 2j, -0.5]), np.array([3.0, 1.0 - 1j, 2.0])
    found, _ = lower_bound(np.outer(column, row), [1, 1, 1])
    assert found == pytest.approx(np.abs(column) @ np.abs(row), rel=1e-9)
