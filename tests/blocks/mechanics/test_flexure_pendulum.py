"""The derivative of the pendulum against its equation of motion and its energy balance."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.mechanics.flexure_pendulum import FlexurePendulum, State, angle, angular_velocity, derivative
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

angles = st.integers(-(10**6), 10**6).map(lambda n: 1e-9 * n)
velocities = st.integers(-(10**6), 10**6).map(lambda n: 1e-5 * n)
torques = st.integers(-(10**6), 10**6).map(lambda n: 1e-9 * n)


@given(angles, velocities, torques)
def test_equation_of_motion_and_energy(theta: float, omega: float, torque: float) -> None:
    p = FlexurePendulum()
    moved = derivative(p, State(theta, omega), torque)
    assert moved.angle == omega
    terms = (p.inertia * moved.angular_velocity, p.damping * omega, p.stiffness * theta)
    size = sum(map(abs, (*terms, torque)))
    assert math.fsum(terms) == pytest.approx(torque, abs=1e-15 * size)
    growth = p.inertia * omega * moved.angular_velocity + p.stiffness * theta * moved.angle
    assert growth == pytest.approx(torque * omega - p.damping * omega * omega, abs=4e-15 * size * abs(omega))


def test_state_space_is_the_transfer_function() -> None:
    p = FlexurePendulum()
    columns = [derivative(p, State(1.0, 0.0), 0.0), derivative(p, State(0.0, 1.0), 0.0)]
    entry = np.array([derivative(p, State(0.0, 0.0), 1.0)]).T
    system = control.ss(np.array(columns).T, entry, [[1.0, 0.0]], [[0.0]])
    for omega in (0.0, 10.0, 1e3, 1e5):
        s = 1j * omega
        assert system(s) == pytest.approx(1.0 / (p.inertia * s * s + p.damping * s + p.stiffness), rel=1e-12)


def test_outputs_read_the_state_and_no_input() -> None:
    p, x = FlexurePendulum(), State(2.0, 3.0)
    assert (angle(p, x), angular_velocity(p, x)) == (2.0, 3.0)
    assert FlexurePendulum.feedthrough("angle") == FlexurePendulum.feedthrough("angular_velocity") == ()


def test_units_take_angles_in_degrees() -> None:
    assert FlexurePendulum(stiffness="3 uN*m/deg").stiffness == pytest.approx(3e-6 * 180 / math.pi, rel=1e-15)
    with pytest.raises(ModelError, match="must be > 0"):
        FlexurePendulum(inertia=-1e-7)


@pytest.mark.derivation(
    FlexurePendulum,
    equation="J th'' + C th' + D th = M",
    source="weight of 0.4 g on an arm of 8 mm: rest at m g l / D, and the overshoot of the logarithmic decrement",
    convention="angle in rad, torque per rad; C is of N m s/rad, twice the part that goes with the decay times J",
)
def test_the_overshoot_of_a_pendulum_under_its_weight() -> None:
    inertia, stiffness, decay = 2.0e-7, 5.0e-3, 30.0
    swing = math.sqrt(stiffness / inertia - decay**2)
    rest = 0.4e-3 * 9.80665 * 8e-3 / stiffness
    graph = Graph(
        name="weight",
        rate=50.0 * swing / math.pi,  # ticks: 50 in half a swing
        blocks={
            "weight": Step(amplitude=rest * stiffness, unit="N*m"),
            "pendulum": FlexurePendulum(inertia=inertia, damping=2.0 * decay * inertia, stiffness=stiffness),
        },
        wires=["weight.output -> pendulum.torque"],
        probes=["pendulum.angle", "pendulum.angular_velocity"],
    )
    result = simulate(graph, samples=151, engine="python")
    angle, speed = result["pendulum.angle"].values, result["pendulum.angular_velocity"].values
    fall = math.exp(-math.pi * decay / swing)
    assert angle[[50, 100, 150]] == pytest.approx(rest * np.array([1.0 + fall, 1.0 - fall**2, 1.0 + fall**3]), rel=1e-9)
    assert speed[[50, 100, 150]] == pytest.approx(np.zeros(3), abs=1e-9 * np.abs(speed).max())
