"""Events between ticks: their instants in closed form, in both engines, and what cannot go on."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest

from proofmass.blocks import Constant, GapClosingActuator, LowPass, MassBetweenStops, Relay, Sine, Step
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.graphs.model.build import Graph
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate

ENGINES: list[EngineName] = ["python", "compiled"]
GRAVITY, RESTITUTION, HEIGHT = 9.80665, 0.95, 1.0


def both(graph: Graph, samples: int, interpreted: int) -> Result:
    """The result of the compiled engine, after a look that plain Python starts with the same bits."""
    python = simulate(graph, samples=interpreted, engine="python")
    compiled = simulate(graph, samples=samples, engine="compiled")
    for signal in python:
        assert python[signal].values.tobytes() == compiled[signal].values[:interpreted].tobytes(), signal
    return compiled


def instants(result: Result, signal: str) -> list[float]:
    """The different values of a port that holds the time of the last event, in their order."""
    return [float(t) for t in np.unique(result[signal].values) if t > 0.0]


def bouncing_ball(rate: str, **integration: Any) -> Graph:
    ball = MassBetweenStops(
        mass=1.0,
        damping=0.0,
        stiffness=0.0,
        lowest=0.0,
        highest=10.0,
        restitution=RESTITUTION,
        initial_displacement=HEIGHT,
    )
    return Graph(
        name="bouncing ball",
        rate=rate,
        blocks={"weight": Constant(value=-GRAVITY, unit="N"), "ball": ball},
        wires=["weight.output -> ball.force"],
        probes=["ball.displacement", "ball.last_impact"],
        integration=integration,
    )


def impacts(count: int) -> list[float]:
    """When a ball that falls from rest hits the ground."""
    times, flight = [math.sqrt(2.0 * HEIGHT / GRAVITY)], 2.0 * math.sqrt(2.0 * HEIGHT / GRAVITY)
    for _ in range(count - 1):
        flight *= RESTITUTION
        times.append(times[-1] + flight)
    return times


@pytest.mark.exhaustive
def test_a_hundred_impacts_of_a_bouncing_ball() -> None:
    found = instants(both(bouncing_ball("1 kHz"), 18_000, 2_000), "ball.last_impact")
    assert len(found) > 100
    for time, expected in zip(found, impacts(100), strict=False):
        assert abs(time - expected) < 1e-12  # a thousandth of a millionth of a tick


def test_the_tolerance_of_events_is_kept() -> None:
    # At 7 Hz there are many impacts in a tick, of which the last is seen.
    result = simulate(bouncing_ball("7 Hz", event_tolerance="1 us"), samples=122, engine="compiled")
    found = [time for time in instants(result, "ball.last_impact") if time < 16.0]  # then flights are microseconds
    expected = impacts(200)
    near = [min(expected, key=lambda t: abs(t - time)) - time for time in found]
    assert len(found) > 40
    assert max(map(abs, near)) < 1e-6


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", ["runge_kutta_4", "dormand_prince", "radau"])
def test_a_hundred_switchings_of_a_relay_round_a_lag(method: str) -> None:
    tau = 0.01
    graph = Graph(
        name="relay round a lag",
        rate="1 kHz",
        blocks={
            "relay": Relay(lower=-0.5, upper=0.5, off=1.0, on=-1.0),
            "lag": LowPass(corner_frequency=1.0 / (2.0 * math.pi * tau)),
        },
        wires=["relay.output -> lag.input", "lag.output -> relay.input"],
        probes=["relay.last_switching", "relay.switchings", "lag.output"],
        integration={"method": method, "accuracy": 1e-12},
    )
    result = both(graph, 1_150, {"runge_kutta_4": 100, "dormand_prince": 100, "radau": 20}[method])
    found = instants(result, "relay.last_switching")
    first, half = tau * math.log(2.0), tau * math.log(3.0)
    assert len(found) == result["relay.switchings"].values[-1] == 1 + int((1.149 - first) / half)
    for number, time in enumerate(found):
        assert abs(time - (first + number * half)) < 1e-11
    assert np.abs(result["lag.output"].values).max() <= 0.5 + 1e-9


def pulled_in(voltage: float) -> bool:
    """Whether parallel plates close at that voltage, the mass being overdamped."""
    blocks = {
        "plates": GapClosingActuator(bias=voltage, capacitance=1.3e-12, gap=2e-6, push_pull=False),
        "mass": MassBetweenStops(lowest=-1.9e-6, highest=1.9e-6),
        "drive": Constant(value=0.0, unit="V"),
    }
    graph = Graph(
        name="pull-in",
        rate="100 kHz",
        blocks=blocks,
        wires=[
            "drive.output -> plates.voltage",
            "mass.displacement -> plates.displacement",
            "plates.force -> mass.force",
        ],
        probes=["mass.contact"],
    )
    return bool(simulate(graph, duration="20 ms", engine="compiled")["mass.contact"].values[-1] == 1)


@pytest.mark.exhaustive
def test_pull_in_voltage_of_parallel_plates() -> None:
    mass, plates = MassBetweenStops(), GapClosingActuator(capacitance=1.3e-12, gap=2e-6)
    expected = math.sqrt(8.0 * mass.stiffness * plates.gap**2 / (27.0 * plates.capacitance))
    assert expected == pytest.approx(6.72, abs=5e-3)
    assert not pulled_in(0.999 * expected)
    assert pulled_in(1.001 * expected)


class Count(NamedTuple):
    count: int


class Stuck(Block):
    """Its event leaves the clearance where it is."""

    input = Input("1", "Input.", default=0.0)


@Stuck.output("1")
def count(p: Any, x: Count) -> int:
    """Events so far."""
    return x.count


def again(p: Any, x: Count) -> Count:
    return Count(x.count + 1)


@Stuck.event(then=again)
def below(p: Any, x: Count, time: float, input: float) -> float:
    return 0.0105 - time - input


@pytest.mark.exhaustive
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("wires", [[], ["step.output -> stuck.input"]], ids=["within a tick", "where it begins"])
def test_an_event_without_end_stops_the_run(engine: EngineName, wires: list[str]) -> None:
    blocks: dict[str, Block] = {"stuck": Stuck(), "step": Step(start_time=0.01)}
    graph = Graph(name="stuck", rate="1 kHz", blocks=blocks, wires=wires, probes=["stuck.count"])
    with pytest.raises(RunError) as told:
        simulate(graph, samples=100, engine=engine)
    assert told.value.problem.key == "stuck.below"
    assert "in tick 10, t = 0.01 s" in str(told.value)
    assert "again and again at one instant" in str(told.value)


def test_blocks_with_events_are_stepped_though_they_are_linear() -> None:
    solver = plan(bouncing_ball("1 kHz")).solvers[0]
    assert (solver.method, solver.substeps) == ("dormand_prince", 1)


@pytest.mark.exhaustive
def test_a_driven_parameter_of_a_block_with_events_is_the_parameter_set() -> None:
    def graph(damping: float, driven: bool) -> Graph:
        blocks: dict[str, Block] = {
            "shake": Sine(amplitude=2e-4, frequency=900.0, unit="N"),
            "mass": MassBetweenStops(damping=3.4e-3 if driven else damping, restitution=0.5),
        }
        wires = ["shake.output -> mass.force"]
        if driven:
            blocks["gas"] = Constant(value=damping, unit="kg/s")
            wires.append("gas.output -> mass.damping")
        return Graph(
            name="driven",
            rate="20 kHz",
            blocks=blocks,
            wires=wires,
            probes=["mass.displacement", "mass.last_impact"],
            integration={"method": "runge_kutta_4"},
        )

    constant, driven = (simulate(graph(2e-3, d), samples=60, engine="python") for d in (False, True))
    assert len(instants(constant, "mass.last_impact")) > 1
    for signal in constant:
        assert constant[signal].values.tobytes() == driven[signal].values.tobytes()
