"""Graphs handed to python-control, and what is said where that cannot be."""

import math

import control
import numpy as np
import pytest

import proofmass
from proofmass.blocks import LowPass, Saturation, ShiftRegister, Step, Sum, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.linearise import loops_of
from proofmass.runner.analysis.linearisation.no_loop import not_periodic
from proofmass.runner.analysis.margins.stability import all_margins
from proofmass.runner.planning.plan import plan
from tests.by_hand.crossing_loops import BLOCKS, WIRES

GRAPH = read_graph(library_file("closed_loop_accelerometer.toml"))


def test_names_and_time_step_of_the_closed_loop() -> None:
    system = proofmass.linearise(GRAPH, ["acceleration.output"], ["dac.voltage", "pendulum.angle"])
    assert isinstance(system, control.StateSpace)
    assert system.input_labels == ["acceleration:output"]
    assert system.output_labels == ["dac:voltage", "pendulum:angle"]
    assert system.state_labels[:2] == ["pendulum:angle", "pendulum:angular_velocity"]
    assert system.dt == 2e-5
    # m L a is balanced by the torquer: voltage = -K0 R a / kt at rest.
    assert control.dcgain(system)[0] == pytest.approx(-8.0e-6 * 342.0 / 0.065, rel=1e-9)
    assert control.dcgain(system)[1] == pytest.approx(0.0, abs=1e-12)


def test_the_response_is_that_of_a_run() -> None:
    """A small step through python-control and through the graph, whose converters are made fine."""
    quiet = {"acceleration.amplitude": 0.0, "acceleration.offset": 0.0, "reference.slope": 0.0}
    graph = GRAPH.with_parameters({**quiet, "adc.bits": 32, "dac.bits": 32})
    system = proofmass.linearise(graph, ["acceleration.output"], ["pendulum.angle"])
    _, expected = control.step_response(system, np.arange(400) * system.dt)
    pushed = Graph(
        name="pushed",
        rate=graph.rate,
        blocks={**graph.blocks, "acceleration": Step(amplitude=1.0, unit="m/s^2")},
        wires=graph.wires,
        probes=["pendulum.angle"],
    )
    angle = proofmass.simulate(pushed, samples=400)["pendulum.angle"].values
    assert np.max(np.abs(angle - expected)) < 2e-6 * np.max(np.abs(expected))


@pytest.mark.exhaustive
def test_the_open_loop_is_that_of_negative_feedback() -> None:
    system = proofmass.linearise(GRAPH, loop="main")
    closed = control.feedback(system, 1)
    found = proofmass.margins(GRAPH)
    assert np.sort(np.abs(closed.poles())) == pytest.approx(np.sort(np.abs(found.poles)), abs=1e-9)
    sampled = control.frd(
        system, np.geomspace(1.0, 0.999 * math.pi / system.dt, 20_000)
    )  # polynomials are not up to it
    gain, phase, *_ = control.margin(sampled)
    assert gain == pytest.approx(found.gain_margin, rel=1e-3)
    assert phase == pytest.approx(math.degrees(found.phase_margin or 0.0), abs=0.05)
    opened = proofmass.linearise(GRAPH, loop="dac.voltage")
    assert np.array_equal(opened.A, system.A)


def problem_of(**more: object) -> str:
    with pytest.raises(ModelError) as caught:
        proofmass.linearise(GRAPH, **more)  # type: ignore[arg-type]
    return str(caught.value)


def test_what_is_misspelt() -> None:
    assert "did you mean voltage?" in problem_of(inputs=["acceleration.output"], outputs=["dac.voltag"])
    assert "did you mean main?" in problem_of(loop="mian")
    assert "there is no such loop" in problem_of(loop="x")
    assert "is an input" in problem_of(loop="dac.number")
    assert "at:" in problem_of(loop="main", at="1 kg")


def made(blocks: dict[str, Block], wires: list[str]) -> Graph:
    return Graph(name="loops", rate=1000, blocks=blocks, wires=wires)


def refused(graph: Graph, loop: str = "") -> str:
    with pytest.raises(ModelError) as caught:
        proofmass.margins(graph, loop)
    return str(caught.value)


def test_what_cannot_be_opened() -> None:
    no_loop = made({"a": UnitDelay(), "b": Step()}, ["b.output -> a.input"])
    assert "the graph has no loop" in refused(no_loop)
    assert "what goes in at b.output does not come back" in refused(no_loop, "b.output")
    bits = made({"bits": ShiftRegister()}, [])
    assert "not an output that is one number" in refused(bits, "bits.bit")
    wires = ["a.output -> b.input", "b.output -> c.input", "c.output -> a.input"]
    sampled = made({"a": LowPass(), "b": LowPass(), "c": UnitDelay()}, wires)
    assert "no loop among continuous blocks goes through a.output" in refused(sampled, "a.output")
    several = made({"a": UnitDelay(), "b": UnitDelay()}, ["a.output -> a.input", "b.output -> b.input"])
    assert 'margins(graph, "a.output")' in refused(several)


def test_a_limit_that_is_reached_opens_the_loop() -> None:
    blocks: dict[str, Block] = {
        "bias": Step(amplitude=9.0),
        "sum": Sum(),
        "limit": Saturation(),
        "delay": UnitDelay(),
    }
    wires = [
        "bias.output -> sum.first",
        "delay.output -> sum.second",
        "sum.output -> limit.input",
        "limit.output -> delay.input",
    ]
    assert "a limit may be reached there" in refused(made(blocks, wires), "delay.output")


def test_loops_that_share_wires_are_opened_one_by_one() -> None:
    """No output opens both loops; each is opened with the other closed."""
    planned = plan(made(BLOCKS, WIRES))
    assert list(loops_of(planned)) == ["a.output", "b.output"]
    found = all_margins(planned)
    assert [one.open_at for one in found.values()] == ["a.output", "b.output"]


def test_what_a_loop_among_continuous_blocks_is_told_names_its_block() -> None:
    """The place of the block in the file, and the output as its key."""
    problem = not_periodic(("sensor", "displacement"))
    assert (problem.path, problem.key) == (("blocks", "sensor"), "sensor.displacement")
