"""The mass between stops: its rebounds by hand; closed-form times of impact are in runner/planning/test_events.py."""

import numpy as np
import pytest

from proofmass.blocks import MassSpringDamper, Pulse, Step
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.mechanics.mass_between_stops import (
    MassBetweenStops,
    State,
    clearance,
    derivative,
    hit,
    pressure,
    release,
)
from proofmass.blocks.mechanics.mass_spring_damper import State as Free
from proofmass.blocks.mechanics.mass_spring_damper import derivative as free_derivative
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate


def test_between_the_stops_it_is_a_mass_on_a_spring() -> None:
    p, free = MassBetweenStops(), MassSpringDamper()
    for x, v, force in ((0.0, 0.0, 1e-6), (1e-7, -2e-4, 0.0), (-3e-7, 1e-3, 5e-6)):
        moved = derivative(p, State(x, v, 0, 0.0), force)
        assert moved[:2] == free_derivative(free, Free(x, v), force)
        assert moved[2:] == (0, 0.0)


def test_clearance_is_the_way_to_the_stop_ahead() -> None:
    p = MassBetweenStops(lowest=-1e-6, highest=2e-6)
    assert clearance(p, State(0.5e-6, 1.0, 0, 0.0)) == pytest.approx(1.5e-6)
    assert clearance(p, State(0.5e-6, -1.0, 0, 0.0)) == pytest.approx(1.5e-6)
    assert clearance(p, State(2e-6, -1.0, 0, 0.0)) > 0.0


def test_a_rebound_keeps_the_share_of_the_speed() -> None:
    p = MassBetweenStops(lowest=-1e-6, highest=2e-6, restitution=0.5, sticking_speed=1e-3)
    assert hit(p, State(2.1e-6, 0.8, 0, 0.0), 0.25) == State(2e-6, -0.4, 0, 0.25)
    assert hit(p, State(-1.1e-6, -0.8, 0, 0.0), 0.25) == State(-1e-6, 0.4, 0, 0.25)


def test_a_slow_rebound_stays_at_the_stop_until_it_is_pulled_away() -> None:
    p = MassBetweenStops(restitution=0.5, sticking_speed=1e-3)
    held = hit(p, State(p.highest, 1e-3, 0, 0.0), 0.25)
    assert held == State(p.highest, 0.0, 1, 0.25)
    spring = p.stiffness * p.highest
    assert derivative(p, held, 2.0 * spring)[:2] == (0.0, 0.0)
    assert pressure(p, held, 1.001 * spring) > 0.0 > pressure(p, held, 0.999 * spring)
    freed = release(p, held)
    assert freed == State(p.highest, 0.0, 0, 0.25)
    assert clearance(p, freed) > 0.0 < pressure(p, freed, 0.0)


def test_a_shock_presses_it_against_the_stop_and_lets_it_go() -> None:
    p = MassBetweenStops()
    shock = Pulse(amplitude=3e-4, repetition=1.0, duty=3e-4, delay=1e-4, unit="N")  # the spring there: 94 uN
    graph = Graph(
        name="shock",
        rate="200 kHz",
        blocks={"shock": shock, "mass": p},
        wires=["shock.output -> mass.force"],
        probes=["mass.displacement", "mass.contact", "mass.last_impact"],
    )
    result = simulate(graph, duration="1 ms", engine="python")
    contact, x = result["mass.contact"].values, result["mass.displacement"].values
    assert set(contact) == {0, 1}
    assert (x[contact == 1] == p.highest).all()
    assert x.max() == p.highest
    held = np.flatnonzero(contact) / 200e3
    assert 1e-4 < result["mass.last_impact"].values[-1] < held[0] < 1.5e-4
    assert held[-1] == pytest.approx(4e-4, abs=1e-5)
    assert abs(x[-1]) < 1e-3 * p.highest


@pytest.mark.parametrize(
    "wrong", [{"lowest": 2e-6}, {"initial_displacement": 3e-6}, {"restitution": 1.1}, {"stiffness": -1.0}]
)
def test_what_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ModelError):
        MassBetweenStops(**wrong)


@pytest.mark.derivation(
    MassBetweenStops,
    equation="m x'' + c x' + k x = F between the stops, v -> -e v at both",
    source="a ball that falls by h and bounces: impacts at sqrt(2 h / g) (1 + 2 e + 2 e^2 + ...), a geometric series",
    convention="e is of speeds, not of energies; places of stops from rest, not from the start",
)
def test_a_ball_that_bounces() -> None:
    g, height, e, mass = 9.80665, 1.2e-3, 0.6, 2e-6
    free = {"mass": mass, "damping": 0.0, "stiffness": 0.0, "restitution": e, "sticking_speed": 0.011}
    ball = MassBetweenStops(lowest=-0.4e-3, highest=5e-3, initial_displacement=0.8e-3, **free)
    graph = Graph(
        name="ball",
        rate="4 kHz",
        blocks={"weight": Step(amplitude=-mass * g, unit="N"), "ball": ball},
        wires=["weight.output -> ball.force"],
        probes=["ball.last_impact", "ball.contact", "ball.displacement"],
    )
    result = simulate(graph, samples=240, engine="python")
    fall = np.sqrt(2.0 * height / g)  # at 153 mm/s; the sixth impact rebounds with 7 mm/s and sticks
    impacts = fall * (1.0 + 2.0 * np.cumsum([0.0, *e ** np.arange(1.0, 6.0)]))
    assert np.unique(result["ball.last_impact"].values)[1:] == pytest.approx(impacts, rel=1e-8)
    resting = result["ball.contact"].values == -1
    assert np.flatnonzero(resting)[0] / 4e3 == pytest.approx(impacts[-1], abs=1.0 / 4e3)
    assert (result["ball.displacement"].values[resting] == -0.4e-3).all()
