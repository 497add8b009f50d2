"""The stepped resonator against SciPy's discretisations, and against its own limits."""

import math

import numpy as np
import pytest
from scipy.signal import cont2discrete

from proofmass.blocks import DiscreteMassSpringDamper
from tests.by_hand.functions import drive

MASS, DAMPING, STIFFNESS = 50.43e-9, 4.57e-3, 51.48
A = np.array([[0.0, 1.0], [-STIFFNESS / MASS, -DAMPING / MASS]])
B = np.array([[0.0], [1.0 / MASS]])
PERIOD = 2e-6
RULES = {"forward_euler": (0.0, 0.0), "semi_implicit": (0.0, 1.0), "tustin": (0.5, 0.5)}


def stepped(method: str, forces: list[float], period: float = PERIOD, **changes: float) -> list[dict[str, float]]:
    rule = dict(zip(("acceleration_at_end", "velocity_at_end"), RULES[method], strict=True))
    block = DiscreteMassSpringDamper(**{"damping": DAMPING, "stiffness": STIFFNESS} | rule | changes)
    return drive(block, [{"force": force} for force in forces], period)


@pytest.mark.derivation(
    DiscreteMassSpringDamper,
    equation="v1 = v + T a, x1 = x + T v, a = (F - c v - k x) / m, each before, at the end or the mean of both",
    source="SciPy's rule of Euler, Tustin's rule of a held force by solved matrices, kick and drift by hand",
    convention="F is that of the tick and held; outputs are those before the step",
)
@pytest.mark.parametrize("method", ["forward_euler", "semi_implicit", "tustin"])
def test_against_matrices_by_scipy_and_by_hand(method: str) -> None:
    forces = np.random.default_rng(4).normal(scale=1e-6, size=400)
    if method == "forward_euler":
        ad, bd = cont2discrete((A, B, np.eye(2), np.zeros((2, 1))), PERIOD, "euler")[:2]
    elif method == "tustin":  # of a force that is held: (1 - T A / 2)^-1 (1 + T A / 2), and T B for T (B + B) / 2
        left = np.eye(2) - 0.5 * PERIOD * A
        ad, bd = np.linalg.solve(left, np.eye(2) + 0.5 * PERIOD * A), np.linalg.solve(left, PERIOD * B)
    else:  # the two updates one after the other
        kick = np.array([[1.0, 0.0], PERIOD * A[1]]) + np.array([[0.0, 0.0], [0.0, 1.0]])
        drift = np.array([[1.0, PERIOD], [0.0, 1.0]])
        ad, bd = drift @ kick, drift @ (PERIOD * B)
    x, expected = np.zeros(2), []
    for force in forces:
        expected.append(x)
        x = ad @ x + bd[:, 0] * force
    found = [(row["displacement"], row["velocity"]) for row in stepped(method, forces.tolist())]
    assert np.array(found) == pytest.approx(np.array(expected), rel=1e-9, abs=1e-20)


@pytest.mark.parametrize("method", ["forward_euler", "semi_implicit", "tustin"])
def test_a_constant_force_is_force_over_stiffness(method: str) -> None:
    assert stepped(method, [1e-6] * 2000)[-1]["displacement"] == pytest.approx(1e-6 / STIFFNESS, rel=1e-9)


def test_forward_euler_takes_the_damping_off() -> None:
    """T c / m damps and T^2 k / m does not: the amplitude grows by sqrt(1 - T c / m + T^2 k / m) a step."""
    period = 1e-6
    for damping, grows in ((0.9 * period * STIFFNESS, True), (1.1 * period * STIFFNESS, False)):
        rows = stepped("forward_euler", [1e-6, *[0.0] * 3000], period, damping=damping)
        energy = [STIFFNESS * row["displacement"] ** 2 + MASS * row["velocity"] ** 2 for row in (rows[500], rows[3000])]
        assert (energy[1] > energy[0]) is grows


def test_the_error_of_tustin_is_of_the_second_order() -> None:
    damping, w = 7.12e-5, 2.0 * math.pi * 8465.57
    errors = []
    for steps in (100, 200):
        period = 2.0 * math.pi / w / steps
        rows = stepped(
            "tustin", [1e-6] * (11 * steps // 4 + 1), period, mass=48.67e-9, stiffness=137.7, damping=damping
        )
        decay = damping / 2.0 / 48.67e-9
        free, t = math.sqrt(137.7 / 48.67e-9 - decay**2), 11 * steps // 4 * period
        exact = 1e-6 / 137.7 * (1 - math.exp(-decay * t) * (math.cos(free * t) + decay / free * math.sin(free * t)))
        errors.append(abs(rows[-1]["displacement"] - exact))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
