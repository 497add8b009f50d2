"""Starts from rest, sources that begin between ticks, and motion that slides along a jump."""

import cmath
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from docs.papers.pn_runs import library
from proofmass.blocks import Difference, Integrator, MassSpringDamper, Pulse, Relay, Sign, Sine, Step
from proofmass.graphs.model.build import Graph
from proofmass.runner.continuous import integrate as stepping
from proofmass.runner.run.simulate import RunError, simulate
from tests.by_hand.amounts import amounts
from tests.reference import test_vibratory_gyroscope as gyroscope

ADAPTIVE = ["dormand_prince", "radau"]
MASS, DAMPING, STIFFNESS = 50.43e-9, 3.4e-3, 49.5627  # of a MassSpringDamper


def integrated(source: Any, rate: str = "1 kHz", **integration: Any) -> Graph:
    return Graph(
        name="integrated",
        rate=rate,
        blocks={"source": source, "x": Integrator()},
        wires=["source.output -> x.input"],
        probes=["x.output"],
        integration={"sources": "continuous", **integration},
    )


@pytest.mark.exhaustive(but=2)
@pytest.mark.defect("S620", before="off by up to 0.16 tick in 15 % of starts", after="right to 1e-9 of a tick")
@pytest.mark.parametrize("starts", amounts(4, 100))
@pytest.mark.parametrize("method", ["auto", "runge_kutta_4", *ADAPTIVE])
def test_a_step_that_begins_between_ticks_is_where_it_begins(method: str, starts: int) -> None:
    graph = integrated(Step(), method=method)
    for start in np.random.default_rng(620).uniform(0.0, 4.0, starts):
        shifted = graph.with_parameters({"source.start_time": float(start), "source.duration": 2e-3})
        found = simulate(shifted, samples=math.ceil(1000.0 * start) + 5, engine="compiled")["x.output"].values[-1]
        assert abs(found - 2e-3) < 1e-12


@pytest.mark.exhaustive("radau")
@pytest.mark.parametrize("method", ["auto", *ADAPTIVE])
def test_pulses_between_ticks_have_their_area(method: str) -> None:
    graph = integrated(Pulse(delay=1.23456e-4, repetition=math.pi / 3000.0, duty=0.3), method=method)
    trace = simulate(graph, samples=1000, engine="compiled")["x.output"]
    turns = (trace.times - 1.23456e-4) / (math.pi / 3000.0)
    area = np.where(turns > 0.0, np.floor(turns) * 0.3 + np.minimum(turns % 1.0, 0.3), 0.0) * math.pi / 3000.0
    assert np.abs(trace.values - area).max() < 1e-9 * area.max()


@pytest.mark.exhaustive("10 kHz-0.01081-radau")
@pytest.mark.defect("C620", before="no step is short enough", after="within the accuracy of the closed form")
@pytest.mark.parametrize("method", ["auto", *ADAPTIVE])
@pytest.mark.parametrize(("rate", "start"), [("10 kHz", 10.81e-3), ("1 kHz", 0.7194), ("1 kHz", 0.1)])
def test_a_mass_at_rest_is_pushed_later(method: str, rate: str, start: float) -> None:
    graph = Graph(
        name="pushed",
        rate=rate,
        blocks={"push": Step(amplitude=1e-6, start_time=start, unit="N"), "x": MassSpringDamper()},
        wires=["push.output -> x.force"],
        probes=["x.displacement"],
        integration={"sources": "continuous", "method": method},
    )
    trace = simulate(graph, duration=start + 5e-3, engine="compiled")["x.displacement"]
    root = cmath.sqrt((DAMPING / (2.0 * MASS)) ** 2 - STIFFNESS / MASS)
    fast, slow = -DAMPING / (2.0 * MASS) - root, -DAMPING / (2.0 * MASS) + root
    after = np.maximum(trace.times - start, 0.0)
    shape = 1.0 + (slow * np.exp(fast * after) - fast * np.exp(slow * after)) / (fast - slow)
    assert np.abs(trace.values - 1e-6 / STIFFNESS * shape.real).max() < 1e-9 * 1e-6 / STIFFNESS


@pytest.mark.exhaustive("radau")
@pytest.mark.defect("C621", before="no step is short enough in tick 0", after="as DOP853 of the published equations")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_gyroscope_starts_from_rest(method: str) -> None:
    graph = library("vibratory_gyroscope.toml")
    graph = replace(graph, integration=replace(graph.integration, method=method))
    result = simulate(graph, samples=1021, engine="compiled")
    absolute = [1e-21, 1e-16, 1e-25, 1e-20]
    expected = solve_ivp(gyroscope.rates, (0.0, 2e-3), [0.0] * 4, method="DOP853", rtol=1e-12, atol=absolute).y
    for signal, row in (("drive.displacement", 0), ("sense.displacement", 2)):
        assert abs(result[signal].values[-1] - expected[row, -1]) < 1e-8 * np.abs(expected[row]).max()


@pytest.mark.exhaustive("radau")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_both_engines_start_alike(method: str) -> None:
    graph = library("vibratory_gyroscope.toml")
    graph = replace(graph, integration=replace(graph.integration, method=method))
    python, compiled = (simulate(graph, samples=4, engine=engine) for engine in ("python", "compiled"))
    for signal in python:
        assert python[signal].values.tobytes() == compiled[signal].values.tobytes()


@pytest.mark.exhaustive
@pytest.mark.defect("C622", before="no step is short enough in tick 0", after="as the formula of its filter")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_a_readout_starts_from_rest(method: str) -> None:
    graph = library("capacitive_readout.toml").with_parameters({"displacement.amplitude": 20e-9})
    graph = replace(graph, integration=replace(graph.integration, method=method, substeps=None))
    result = simulate(graph, engine="compiled")
    turned = np.exp(-2j * math.pi * 0.01 * np.arange(101, 201))
    found = 2.0 * np.mean(result["modelled.mean"].values[101:201] * turned)
    s = 2j * math.pi * 1e3
    corner = s / (2.0 * math.pi * 20e3)
    mean = np.mean(np.exp(-s * np.arange(1, 65) / 6.4e6))
    assert found == pytest.approx(-20e-9j * 3.5301e8 * mean / (1.0 + math.sqrt(2.0) * corner + corner**2), rel=1e-5)


def sliding(method: str) -> Graph:
    """x' = u - sign(x): after 10 ms x stays at zero, where the rate has no value."""
    return Graph(
        name="sliding",
        rate="1 kHz",
        blocks={
            "u": Sine(amplitude=0.5, frequency=10.0),
            "n": Sign(unit="s"),
            "d": Difference(),
            "x": Integrator(initial=0.01),
        },
        wires=["u.output -> d.first", "n.output -> d.second", "d.output -> x.input", "x.output -> n.input"],
        probes=["x.output"],
        integration={"sources": "continuous", "method": method},
    )


@pytest.mark.exhaustive
@pytest.mark.defect("H620", before="no answer", after="a sentence after half a second")
@pytest.mark.parametrize("method", ADAPTIVE)
def test_motion_along_a_jump_ends_with_a_sentence(method: str) -> None:
    with pytest.raises(RunError, match=r"in tick 1\d, t = 0\.01\d s") as told:
        simulate(sliding(method), samples=100, engine="compiled")
    assert "slides along a jump" in str(told.value)
    assert "n.above_zero" in str(told.value)
    assert "substeps = 100" in str(told.value)


def test_the_jump_that_motion_slides_along_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps that each end at one corner are its doing, not that of the accuracy."""
    monkeypatch.setattr(stepping, "MOST_SHORT", 20)
    with pytest.raises(RunError, match=r"n\.above_zero(.|\n)* the motion slides along a jump, which"):
        simulate(sliding("radau"), samples=20, engine="python")


@pytest.mark.exhaustive
@pytest.mark.defect("S621", before="200,000 switchings are counted of 10,000,000", after="a sentence in tick 0")
@pytest.mark.parametrize(("limit", "events"), [("MOST_EVENTS", 100), ("CHATTER", 50)])
def test_a_relay_that_chatters_ends_with_a_sentence(limit: str, events: int, monkeypatch: pytest.MonkeyPatch) -> None:
    due, asked = stepping._due, list[float]()
    monkeypatch.setattr(stepping, limit, events)
    monkeypatch.setattr(stepping, "_due", lambda tick, time, x: asked.append(time) or due(tick, time, x))
    graph = Graph(
        name="chattering",
        rate="1 kHz",
        blocks={"relay": Relay(lower=-1e-9, upper=1e-9, off=1.0, on=-1.0, input_unit="s"), "x": Integrator()},
        wires=["relay.output -> x.input", "x.output -> relay.input"],
        probes=["relay.switchings"],
    )
    with pytest.raises(RunError, match="in tick 0") as told:
        simulate(graph, samples=20, engine="python")
    assert told.value.problem.key == "relay.distance"
    assert "events in a tick" in str(told.value)
    assert len(asked) < 200 * events, "it ends by the first of them"
    slower = graph.with_parameters({"relay.lower": -1e-4, "relay.upper": 1e-4})
    assert simulate(slower, samples=20, engine="compiled")["relay.switchings"].values[-1] == 95
