"""Radau IIA against its definition by collocation, and one step on linear rates against its stability function."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from proofmass.runner.continuous import radau
from proofmass.runner.continuous.radau import radau_step, scratch

NODES = np.array([(4.0 - math.sqrt(6.0)) / 10.0, (4.0 + math.sqrt(6.0)) / 10.0, 1.0])  # zeros of Radau's polynomial
WEIGHTS = np.array([[radau._weight(i, j) for j in range(3)] for i in range(3)])
ESTIMATE = np.array([radau.E1, radau.E2, radau.E3])


def step(rates: Callable[[float, Any], Any], time: float, h: float, x: list[float]) -> tuple[Any, Any]:
    """States after a step, and their error."""

    def written(_: None, at: float, state: list[float], out: list[float]) -> None:
        for i, rate in enumerate(rates(at, np.array(state[: len(x)])).tolist()):
            out[i] = rate

    moved, error = [0.0] * len(x), [0.0] * len(x)
    work = tuple([0.0] * length for length in scratch(len(x)))
    radau_step(written, None, time, h, x, moved, error, [max(1.0, abs(v)) for v in x], work)
    return np.array(moved), np.array(error)


def test_nodes_are_zeros_and_weights_integrate_parabolas() -> None:
    """10 c^2 - 8 c + 1 = 0 and c = 1; sum of a_ij c_j^(k-1) = c_i^k / k; the last row integrates c^4 too."""
    assert np.polyval([10.0, -8.0, 1.0], NODES[:2]) == pytest.approx([0.0, 0.0], abs=1e-14)
    assert [radau._node(stage) for stage in range(3)] == pytest.approx(NODES, rel=1e-15)
    for k in range(1, 4):
        assert WEIGHTS @ NODES ** (k - 1) == pytest.approx(NODES**k / k, rel=1e-14)
    assert [WEIGHTS[2] @ NODES**k for k in range(5)] == pytest.approx([1.0, 1 / 2, 1 / 3, 1 / 4, 1 / 5], rel=1e-14)


def test_the_estimate_is_exact_for_cubes_and_filtered_by_the_real_eigenvalue() -> None:
    assert [ESTIMATE @ NODES**k for k in (1, 2, 3)] == pytest.approx([-1.0, 0.0, 0.0], abs=1e-13)
    eigenvalues = np.linalg.eigvals(np.linalg.inv(WEIGHTS))
    assert eigenvalues[np.abs(eigenvalues.imag) < 1e-9].real == pytest.approx([radau.G], rel=1e-12)


@pytest.mark.parametrize("z", [-1e-3, -0.7, -5.0, -1e3, -1e6, 0.5])
def test_a_step_on_one_linear_rate(z: float) -> None:
    """R(z) = (1 + 2 z / 5 + z^2 / 20) / (1 - 3 z / 5 + 3 z^2 / 20 - z^3 / 60)."""
    (moved,), (error,) = step(lambda _, x: z / 0.25 * x, 0.0, 0.25, [2.0])
    ratio = (1.0 + 0.4 * z + z * z / 20.0) / (1.0 - 0.6 * z + 0.15 * z * z - z**3 / 60.0)
    assert moved == pytest.approx(2.0 * ratio, rel=1e-9, abs=2e-11)
    stages = np.linalg.solve(np.eye(3) - z * WEIGHTS, z * WEIGHTS @ np.full(3, 2.0))
    expected = (z / 0.25 * 2.0 + ESTIMATE @ stages / 0.25) / (radau.G / 0.25 - z / 0.25)
    assert error == pytest.approx(expected, rel=1e-5, abs=1e-9)


def test_a_step_on_states_that_act_on_each_other_and_on_the_time() -> None:
    """x' = M x + u t^2, whose stages are one system of six equations."""
    matrix, drive, time, h, x = np.array([[-3.0, 40.0], [-2.0, -500.0]]), np.array([5.0, -7.0]), 0.3, 0.125, [1.5, -0.5]
    moved, error = step(lambda at, state: matrix @ state + drive * at * at, time, h, x)
    at = time + NODES * h
    known = np.concatenate([matrix @ np.array(x) + drive * t * t for t in at])
    whole = h * np.kron(WEIGHTS, np.eye(2))
    stages = np.linalg.solve(np.eye(6) - whole @ np.kron(np.eye(3), matrix), whole @ known).reshape(3, 2)
    assert moved == pytest.approx(np.array(x) + stages[2], rel=1e-10)
    slope = matrix @ np.array(x) + drive * time * time
    expected = np.linalg.solve(radau.G / h * np.eye(2) - matrix, slope + ESTIMATE @ stages / h)
    assert error == pytest.approx(expected, rel=1e-4)


def test_a_state_that_never_moves_has_no_derivative_and_stays() -> None:
    moved, error = step(lambda _, x: np.array([0.0, -x[1]]), 0.0, 0.1, [0.0, 1.0])
    assert (moved[0], error[0]) == (0.0, 0.0)
    assert moved[1] == pytest.approx(math.exp(-0.1), rel=1e-7)


@pytest.mark.parametrize("rate", [lambda _, x: x * math.nan, lambda _, x: 1e3 * np.sign(np.sin(1e6 * x))])
def test_a_step_that_does_not_settle_has_no_bound(rate: Callable[[float, Any], Any]) -> None:
    _, (error,) = step(rate, 0.0, 1.0, [0.1])
    assert not error < 1e9


def test_the_real_eigenvalue_of_the_inverse() -> None:
    """Of the matrix of stages, by NumPy: its inverse has one real eigenvalue and a pair."""
    values = np.linalg.eigvals(np.linalg.inv(WEIGHTS))
    (real,) = values[np.abs(values.imag) < 1e-9].real
    assert pytest.approx(real, rel=1e-12) == radau.G
