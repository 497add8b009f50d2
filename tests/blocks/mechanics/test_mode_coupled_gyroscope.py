"""The gyroscope against scipy's matrix exponential, its scale factor, and what its errors look like."""

import math

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import Constant, ModeCoupledGyroscope, Step
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate

MASS = 5e-8
QUADRATURE, DAMPING = 2e-3 / (1.6 * MASS * 1600.0 * math.pi), 1e-6 / (1.6 * MASS)  # of 2 mN/m and 1 mg/s
PARAMETERS = {
    "mass": MASS,
    "drive_frequency": 800.0,
    "sense_frequency": 830.0,
    "drive_quality": 40.0,
    "sense_quality": 25.0,
    "angular_gain": 0.8,
    "quadrature_rate": QUADRATURE,
    "damping_rate": DAMPING,
}


def matrix(rotation: float) -> np.ndarray:
    """Of x, vx, y, vy, from the equations of motion with 2 x 2 matrices of mass, damping and stiffness."""
    k = np.diag([MASS * (2.0 * np.pi * f) ** 2 for f in (800.0, 830.0)]) + 2e-3 * np.array([[0.0, 1.0], [1.0, 0.0]])
    c = np.diag([MASS * 2.0 * np.pi * f / q for f, q in ((800.0, 40.0), (830.0, 25.0))])
    c += 1e-6 * np.array([[0.0, 1.0], [1.0, 0.0]]) + 2.0 * 0.8 * MASS * rotation * np.array([[0.0, -1.0], [1.0, 0.0]])
    a = np.zeros((4, 4))
    a[0, 1] = a[2, 3] = 1.0
    a[np.ix_([1, 3], [0, 2])], a[np.ix_([1, 3], [1, 3])] = -k / MASS, -c / MASS
    return a


@pytest.mark.parametrize("driven", [False, True])
def test_a_step_of_the_drive_force_against_the_matrix_exponential(driven: bool) -> None:
    rotation = 20.0
    graph = Graph(
        name="gyroscope",
        rate="20 kHz",
        blocks={
            "push": Step(amplitude=1e-6, unit="N"),
            "rate": Constant(value=rotation, unit="rad/s"),
            "gyro": ModeCoupledGyroscope(**PARAMETERS, rotation=0.0 if driven else rotation),
        },
        wires=["push.output -> gyro.drive_force", *(["rate.output -> gyro.rotation"] if driven else [])],
        probes=["gyro.drive_displacement", "gyro.drive_velocity", "gyro.sense_displacement", "gyro.sense_velocity"],
    )
    result = simulate(graph, samples=200, engine="python")
    a = matrix(rotation)
    rest = np.linalg.solve(a, [0.0, 1e-6 / MASS, 0.0, 0.0])
    expected = np.array([linalg.expm(a * n / 20_000.0) @ rest - rest for n in range(200)])
    found = np.array([result[name].values for name in result]).T
    assert np.abs(found - expected).max(axis=0) == pytest.approx(0.0 * expected[0], abs=1e-11 * np.abs(expected).max())


def test_anisodamping_looks_like_a_rate() -> None:
    """Both forces on the sense mode are along the drive velocity."""
    c = ModeCoupledGyroscope.functions["constants"].function
    f = ModeCoupledGyroscope.functions["derivative"].function
    state = ModeCoupledGyroscope.state_class()
    assert state is not None
    moving = state(0.0, 1.0, 0.0, 0.0)
    by_damping = f(c(ModeCoupledGyroscope(damping_rate=0.01), 1.0), moving, 0.0, 0.0)
    by_rate = f(c(ModeCoupledGyroscope(rotation=0.01), 1.0), moving, 0.0, 0.0)
    assert by_damping.vy == pytest.approx(by_rate.vy, rel=1e-14)
    assert by_rate.vy == pytest.approx(-2.0 * 0.01, rel=1e-14)


def test_rotation_is_held_and_the_rest_linear() -> None:
    assert ModeCoupledGyroscope.drivable("rotation")
    assert ModeCoupledGyroscope.linear
    assert math.isclose(ModeCoupledGyroscope().angular_gain, 1.0)
