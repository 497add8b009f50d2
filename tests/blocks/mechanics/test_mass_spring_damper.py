"""The derivative of the proof mass against its equation of motion and its energy balance."""

import math

import control
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks import Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.mechanics.mass_spring_damper import MassSpringDamper, State, derivative, displacement, velocity
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

displacements = st.integers(-(10**6), 10**6).map(lambda n: 1e-11 * n)
velocities = st.integers(-(10**6), 10**6).map(lambda n: 1e-6 * n)
forces = st.integers(-(10**6), 10**6).map(lambda n: 1e-9 * n)


@given(displacements, velocities, forces)
def test_equation_of_motion(x: float, v: float, force: float) -> None:
    p = MassSpringDamper()
    moved = derivative(p, State(x, v), force)
    assert moved.displacement == v
    terms = (p.mass * moved.velocity, p.damping * v, p.stiffness * x)
    assert math.fsum(terms) == pytest.approx(force, abs=1e-15 * sum(map(abs, (*terms, force))))


@given(displacements, velocities, forces)
def test_power_into_the_mass_is_what_the_damper_leaves(x: float, v: float, force: float) -> None:
    p = MassSpringDamper()
    moved = derivative(p, State(x, v), force)
    growth = p.mass * v * moved.velocity + p.stiffness * x * moved.displacement
    size = abs(force * v) + p.damping * v * v + p.stiffness * abs(x * v)
    assert growth == pytest.approx(force * v - p.damping * v * v, abs=4e-15 * size)


def test_state_space_is_the_transfer_function() -> None:
    p = MassSpringDamper()
    columns = [derivative(p, State(1.0, 0.0), 0.0), derivative(p, State(0.0, 1.0), 0.0)]
    entry = np.array([derivative(p, State(0.0, 0.0), 1.0)]).T
    system = control.ss(np.array(columns).T, entry, [[1.0, 0.0]], [[0.0]])
    for omega in (0.0, 1e3, 2 * math.pi * 4989.46, 1e6):
        s = 1j * omega
        assert system(s) == pytest.approx(1.0 / (p.mass * s * s + p.damping * s + p.stiffness), rel=1e-12)


def test_figures_of_the_default_accelerometer() -> None:
    p = MassSpringDamper()
    assert math.sqrt(p.stiffness / p.mass) / (2 * math.pi) == pytest.approx(4989.46, rel=1e-6)
    assert math.sqrt(p.stiffness * p.mass) / p.damping == pytest.approx(0.46499, rel=1e-5)


def test_outputs_read_the_state_and_no_input() -> None:
    p, x = MassSpringDamper(), State(2.0, 3.0)
    assert (displacement(p, x), velocity(p, x)) == (2.0, 3.0)
    assert MassSpringDamper.feedthrough("displacement") == MassSpringDamper.feedthrough("velocity") == ()
    assert MassSpringDamper.continuous()
    assert MassSpringDamper.linear


@pytest.mark.parametrize("wrong", [{"mass": 0.0}, {"stiffness": 0.0}, {"damping": -1e-9}])
def test_what_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ModelError, match="must be >"):
        MassSpringDamper(**wrong)


@pytest.mark.derivation(
    MassSpringDamper,
    equation="m x'' + c x' + k x = F",
    source="logarithmic decrement and damped period of a free swing, and the weight that k holds at rest",
    convention="c = m w0 / Q = 2 zeta sqrt(k m): of the velocity, not half of it; F acts on the mass",
)
def test_the_decrement_of_a_free_swing() -> None:
    mass, stiffness, damping = 3e-6, 12.0, 9e-4
    zeta = damping / (2.0 * math.sqrt(stiffness * mass))
    swing = math.sqrt(stiffness / mass) * math.sqrt(1.0 - zeta**2)
    graph = Graph(
        name="swing",
        rate=40.0 * swing / (2.0 * math.pi),
        blocks={
            "push": Step(amplitude=2e-4, unit="N"),
            "mass": MassSpringDamper(mass=mass, damping=damping, stiffness=stiffness),
        },
        wires=["push.output -> mass.force"],
        probes=["mass.displacement"],
    )
    moved = simulate(graph, samples=200, engine="python")["mass.displacement"].values - 2e-4 / stiffness
    decrement = 2.0 * math.pi * zeta / math.sqrt(1.0 - zeta**2)
    assert moved[40:] == pytest.approx(math.exp(-decrement) * moved[:-40], rel=1e-9, abs=1e-16)
    assert moved[0] == pytest.approx(-2e-4 / stiffness)
