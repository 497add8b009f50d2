"""The filter against the recursion of the textbook after its covariance has settled."""

import numpy as np
import pytest

from proofmass.blocks import KalmanFilter
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.functions import drive
from tests.by_hand.responses import noise

A = np.array([[1.0, 0.1, 0.0], [-0.2, 0.9, 0.1], [0.0, 0.0, 0.99]])
B, C = np.array([0.0, 0.1, 0.0]), np.array([1.0, 0.5, 0.0])
Q, R = np.diag([1e-4, 4e-3, 1e-3]), 0.25
BLOCK = KalmanFilter(
    transition=A.ravel().tolist(),
    entry=B.tolist(),
    readout=C.tolist(),
    process_noise=Q.ravel().tolist(),
    measurement_noise=R,
)


def textbook(z: list[float], u: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Estimates of the states and innovations, with the gain of a covariance that has run for long."""
    p = np.eye(3)
    for _ in range(5000):
        k = p @ C / (C @ p @ C + R)
        p = A @ (p - np.outer(k, C @ p)) @ A.T + Q
    m, states, new = np.zeros(3), [], []
    for measurement, control in zip(z, u, strict=True):
        new.append(measurement - C @ m)
        states.append(m + k * new[-1])
        m = A @ states[-1] + B * control
    return np.array(states), np.array(new)


def test_against_the_recursion_of_the_textbook() -> None:
    z, u = noise(300, 1), noise(300, 2)
    states, new = textbook(z, u)
    rows = drive(BLOCK, [{"measurement": a, "control": b} for a, b in zip(z, u, strict=True)])
    assert np.array([row["states"] for row in rows]) == pytest.approx(states, abs=1e-9)
    assert np.array([row["innovation"] for row in rows]) == pytest.approx(new, abs=1e-9)
    assert np.array([row["estimate"] for row in rows]) == pytest.approx(states @ C, abs=1e-9)


def test_of_a_random_walk_it_is_a_low_pass_of_known_gain() -> None:
    """P = (Q + sqrt(Q^2 + 4 Q R)) / 2, K = P / (P + R); with Q = R the golden ratio."""
    walk = {"transition": (1.0,), "entry": (0.0,), "readout": (1.0,), "process_noise": (1.0,)}
    rows = drive(KalmanFilter(**walk), [{"measurement": 1.0, "control": 0.0}])
    assert rows[0]["estimate"] == pytest.approx((np.sqrt(5.0) - 1.0) / 2.0, rel=1e-15)


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ({"transition": (1.0,)}, "4 numbers, as entry has 2"),
        ({"process_noise": (1.0,)}, "4 numbers, as entry has 2"),
        ({"readout": (1.0,)}, "2 numbers, as entry has 2"),
        ({"transition": (2.0, 0.0, 0.0, 2.0)}, "a measurement of all that grows by itself"),
        ({"entry": (0.0,) * 17}, "at most 16 numbers"),
    ],
)
def test_what_has_no_filter_is_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        KalmanFilter(**changes)
