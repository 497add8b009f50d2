"""The gyroscope against scipy's matrix exponential, its scale factor, and what its errors look like."""

import math
from typing import Any

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import Constant, ModeCoupledGyroscope, Step
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
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


def pushed(block: ModeCoupledGyroscope) -> np.ndarray:
    """x, x', y, y' from the first tick after a push along x on."""
    push: dict[str, Block] = {"push": Step(amplitude=1e-3, duration=25e-6, unit="N"), "gyro": block}
    ports = ("drive_displacement", "drive_velocity", "sense_displacement", "sense_velocity")
    graph = Graph(
        name="pushed",
        rate="40 kHz",
        blocks=push,
        wires=["push.output -> gyro.drive_force"],
        probes=[f"gyro.{port}" for port in ports],
    )
    result = simulate(graph, samples=300, engine="python")
    return np.array([result[f"gyro.{port}"].values for port in ports])[:, 1:]


def swing(start: complex, speed: complex, w: float, decay: float, t: Any) -> Any:
    """A free damped swing."""
    free = math.sqrt(w * w - decay * decay)
    return np.exp(-decay * t) * (start * np.cos(free * t) + (speed + decay * start) / free * np.sin(free * t))


@pytest.mark.derivation(
    ModeCoupledGyroscope,
    equation="x'' + ... = Fx / m + 2 k W y', y'' + ... = Fy / m - 2 k W x'",
    source="Foucault's pendulum: a swing that keeps its ellipse in a frame at rest, seen from a case that turns by W t",
    convention="k = 1 of a mass that moves as a whole; the ellipse turns by -k W t in the plane of x and y",
    wrong="the documents called k the part of the mass that turns, without what it is of a ring: n times Bryan's",
)
def test_foucaults_pendulum() -> None:
    """At rest the spring is w^2 + W^2: the centrifugal force, which the block leaves out, comes off it again."""
    w, turn, t = 2.0 * math.pi * 900.0, 150.0, np.arange(299) / 40_000.0
    same = {"drive_frequency": 900.0, "sense_frequency": 900.0, "drive_quality": 1e15, "sense_quality": 1e15}
    x, vx, y, vy = pushed(ModeCoupledGyroscope(rotation=turn, **same))
    start, speed = x[0] + 1j * y[0], vx[0] + 1j * vy[0]
    at_rest = swing(start, speed + 1j * turn * start, math.hypot(w, turn), 0.0, t)
    assert x + 1j * y == pytest.approx(at_rest * np.exp(-1j * turn * t), abs=1e-9 * np.abs(x).max())


@pytest.mark.derivation(
    ModeCoupledGyroscope,
    equation="kxy = 2 k m wx Wq, cxy = 2 k m Wd",
    source="two swings that know nothing of each other, in axes of spring and damper that lean by 0.2 rad",
    convention="Wq and Wd are rates of rotation whose force is as large; Q of each mode with its own frequency",
)
def test_a_suspension_that_leans() -> None:
    lean, (soft, stiff), (less, more) = 0.2, (2.0 * math.pi * np.array([850.0, 960.0])), (40.0, 90.0)
    axes = np.array([[math.cos(lean), -math.sin(lean)], [math.sin(lean), math.cos(lean)]])
    spring, damper = axes @ np.diag([soft**2, stiff**2]) @ axes.T, axes @ np.diag([2 * less, 2 * more]) @ axes.T
    wx, wy, gain = math.sqrt(spring[0, 0]), math.sqrt(spring[1, 1]), 0.7
    block = ModeCoupledGyroscope(
        drive_frequency=wx / (2.0 * math.pi),
        sense_frequency=wy / (2.0 * math.pi),
        drive_quality=wx / damper[0, 0],
        sense_quality=wy / damper[1, 1],
        angular_gain=gain,
        quadrature_rate=spring[0, 1] / (2.0 * gain * wx),
        damping_rate=damper[0, 1] / (2.0 * gain),
    )
    x, vx, y, vy = pushed(block)
    start, speed, t = axes.T @ [x[0], y[0]], axes.T @ [vx[0], vy[0]], np.arange(299) / 40_000.0
    own = [swing(start[i], speed[i], (soft, stiff)[i], (less, more)[i], t) for i in range(2)]
    assert np.array([x, y]) == pytest.approx(axes @ np.array(own), abs=1e-9 * np.abs(x).max())
