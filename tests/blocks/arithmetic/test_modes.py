"""Eigenvalues, eigenvectors and exponentials of the blocks' own linear algebra against mpmath."""

import mpmath
import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks.arithmetic.modes import balanced_exponential, eigen, exponential_of


@pytest.mark.parametrize("decades", [0, 6])
@pytest.mark.parametrize("size", [1, 2, 3, 5])
def test_eigenvalues_of_graded_matrices_have_all_their_digits(size: int, decades: int) -> None:
    """D A D, A of condition 4: rotations keep small ones (Demmel and Veselic, SIAM J. Matrix Anal. Appl. 13, 1992)."""
    dice = np.random.default_rng(size)
    turn = linalg.qr(dice.normal(size=(size, size)))[0]
    even = turn @ np.diag(np.linspace(1.0, 4.0, size)) @ turn.T
    scales = 10.0 ** -np.linspace(0.0, decades, size)
    matrix = (0.5 * (even + even.T)) * np.outer(scales, scales)
    values, vectors = eigen(matrix.tolist())
    with mpmath.workdps(60):
        expected, shapes = mpmath.eigsy(mpmath.matrix(matrix.tolist()))
        order = sorted(range(size), key=lambda i: expected[i])
        exact = np.array([[float(shapes[i, j]) for j in order] for i in range(size)])
        assert values == pytest.approx([float(expected[i]) for i in order], rel=4e-15)
    assert np.abs(np.array(vectors).T @ exact) == pytest.approx(np.eye(size), abs=1e-14)


def test_eigenvectors_of_equal_and_of_negative_eigenvalues() -> None:
    """1 1^T + 2: 2 twice, and 5; the mirror, 1 and -1."""
    values, vectors = eigen([[3.0, 1.0, 1.0], [1.0, 3.0, 1.0], [1.0, 1.0, 3.0]])
    assert values == pytest.approx([2.0, 2.0, 5.0], rel=1e-15)
    assert np.array(vectors).T @ np.array(vectors) == pytest.approx(np.eye(3), abs=1e-15)
    assert [abs(row[2]) for row in vectors] == pytest.approx([3.0**-0.5] * 3, rel=1e-15)
    assert eigen([[0.0, 1.0], [1.0, 0.0]])[0] == pytest.approx([-1.0, 1.0], rel=1e-15)


@pytest.mark.parametrize("size", [0.01, 0.5, 3.0, 10.0])
def test_exponentials_of_small_and_of_large_matrices(size: float) -> None:
    matrix = (np.random.default_rng(3).normal(size=(4, 4)) - 2.0 * np.eye(4)) * size
    with mpmath.workdps(60):
        whole = mpmath.expm(mpmath.matrix(matrix.tolist()))
        expected = np.array([[float(whole[i, j]) for j in range(4)] for i in range(4)])
    level = float(np.max(np.abs(expected)))
    assert np.array(exponential_of(matrix.tolist())) == pytest.approx(expected, rel=0.0, abs=1e-12 * level)
    units = 10.0 ** np.array([0.0, 9.0, -9.0, 30.0])
    apart = np.outer(units, 1.0 / units)
    found = np.array(balanced_exponential((matrix * apart).tolist())) / apart
    assert found == pytest.approx(expected, rel=0.0, abs=1e-12 * level)
