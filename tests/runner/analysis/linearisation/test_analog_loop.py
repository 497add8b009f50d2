"""Loops among continuous blocks, opened at any of their wires: against closed forms and python-control."""

import json
import math
from pathlib import Path

import control
import numpy as np
import pytest

import proofmass
from proofmass.blocks import Constant, Difference, Gain, LowPass, Product, Pulse, Sum, TransferFunction, UnitDelay
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.analysis.linearisation.analog_loop import _matters
from proofmass.runner.analysis.linearisation.find_loops import find_loops
from proofmass.runner.analysis.linearisation.orbit import FROZEN
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.command_line import main
from proofmass.runner.planning.plan import plan

THIRD_ORDER = {"numerator": (10.0,), "denominator": (1.0, 11.0, 10.0, 0.0)}  # 10 / (s (s + 1) (s + 10))


def servo(**plant: tuple[float, ...]) -> Graph:
    blocks: dict[str, Block] = {
        "set": Constant(value=0.3),
        "error": Difference(),
        "amplifier": Gain(gain=1.0),
        "plant": TransferFunction(**(plant or THIRD_ORDER)),
    }
    wires = [
        "set.output -> error.first",
        "plant.strictly_proper_part -> error.second",
        "error.output -> amplifier.input",
        "amplifier.output -> plant.input",
    ]
    return Graph(name="servo", rate=1000, blocks=blocks, wires=wires, duration=1)


@pytest.mark.exhaustive
@pytest.mark.defect("M1", before="hints go in a circle", after="margins in continuous time, at any wire")
@pytest.mark.parametrize("wire", ["error.output", "amplifier.output", "plant.strictly_proper_part", ""])
def test_a_servo_of_third_order(wire: str) -> None:
    """L is real at w^2 = 10, where |L| = 1 / 11: Routh's limit is a factor of 11."""
    found = proofmass.margins(servo(), wire)
    assert found.stable
    assert found.system.continuous
    assert found.gain_margin == pytest.approx(11.0, rel=1e-12)
    assert found.gain_margin_frequency == pytest.approx(math.sqrt(10.0) / (2.0 * math.pi), rel=1e-12)
    s = control.tf("s")
    _, degrees, _, _, crossover, _ = control.stability_margins(10 / (s * (s + 1) * (s + 10)))
    assert found.phase_margin == pytest.approx(math.radians(degrees), rel=1e-9)
    assert found.gain_crossovers == (pytest.approx(crossover / (2.0 * math.pi), rel=1e-9),)
    assert found.delay_margin == pytest.approx(math.radians(degrees) / crossover, rel=1e-9)
    assert np.sort(found.poles) == pytest.approx(np.sort(np.roots([1.0, 11.0, 10.0, 10.0])), rel=1e-9)
    disk = control.disk_margins(control.ss(10 / (s * (s + 1) * (s + 10))), np.geomspace(1e-2, 1e2, 20_001), skew=0.0)
    assert found.disk_margin == pytest.approx(float(disk[0]), rel=1e-5)


@pytest.mark.defect("S95", before="stable, without a word", after="a note says until when")
def test_a_switch_that_waits_is_told() -> None:
    """A weight of 1 becomes 20 after 2 s, above the limit of 11: a run settles until then, and grows afterwards."""
    graph = servo()
    blocks = {**graph.blocks, "weight": Pulse(amplitude=19.0, offset=1.0, repetition=100.0, delay=2.0)}
    blocks["amplifier"] = Product()
    wires = [wire for wire in map(str, graph.wires) if "amplifier.input" not in wire]
    wires += ["error.output -> amplifier.first", "weight.output -> amplifier.second"]
    switched = Graph(name="servo", rate=1000, blocks=blocks, wires=wires, probes=["error.output"])
    found = proofmass.margins(switched, "error.output")
    assert found.gain_margin == pytest.approx(11.0, rel=1e-9)
    (told,) = (note for note in found.system.map.notes if "switch" in note)
    assert "a switch changes it within 2 s" in told
    after = proofmass.margins(switched, "error.output", at="2.1 s")
    assert after.verdict == "unstable"
    assert not any("switch" in note for note in after.system.map.notes)
    trace = np.abs(proofmass.simulate(switched, samples=12_000)["error.output"].values)
    assert trace[1500:2000].max() < trace[:500].max() < trace[11_000:].max()
    assert trace[11_000:].max() > 3.0 * trace[7_000:8_000].max()


def test_all_wires_are_found() -> None:
    (loop,) = find_loops(plan(servo()))
    assert loop.open_at == loop.ports == ("amplifier.output", "error.output", "plant.strictly_proper_part")


def test_an_unstable_servo() -> None:
    """100 / (s (s + 1) (s + 10)): stable with factors up to 1.1."""
    found = proofmass.margins(servo(numerator=(100.0 * 11.0 / 10.0 * 1.25,), denominator=THIRD_ORDER["denominator"]))
    assert found.verdict == "unstable"
    assert found.stable_gains == ((0.0, pytest.approx(0.8, rel=1e-9)),)


def test_the_state_space_is_for_python_control() -> None:
    system = proofmass.linearise(servo(), loop="error.output")
    assert system.dt == 0.0
    w = np.geomspace(0.1, 100.0, 7)
    expected = 10.0 / (1j * w * (1j * w + 1.0) * (1j * w + 10.0))
    assert system(1j * w) == pytest.approx(expected, rel=1e-9)
    assert system.state_labels == ["plant:first", "plant:second", "plant:third"]
    assert (system.input_labels, system.output_labels) == (["error:output"], ["error:output back"])


@pytest.mark.exhaustive
def test_a_gain_that_depends_on_the_operating_point() -> None:
    """x' = w (2 - x^2 - x): at rest at 1, where the loop through the square has the gain 2 behind a LowPass."""
    blocks: dict[str, Block] = {
        "set": Constant(value=2.0),
        "error": Difference(),
        "lag": LowPass(corner_frequency=1.0),
        "square": Product(),
    }
    wires = [
        "set.output -> error.first",
        "square.output -> error.second",
        "error.output -> lag.input",
        "lag.output -> square.first",
        "lag.output -> square.second",
    ]
    graph = Graph(name="square", rate=1000, blocks=blocks, wires=wires)
    found = proofmass.margins(graph, "square.output", at="settled")
    assert found.poles == pytest.approx([-3.0 * 2.0 * math.pi], rel=1e-9)
    assert found.system.map.time > 0.1
    assert found.gain_crossovers == (pytest.approx(math.sqrt(3.0), rel=1e-9),)
    (note,) = proofmass.margins(graph, "square.output", at="10 ms").system.map.notes
    assert "the operating point moves" in note


def mixed() -> Graph:
    blocks: dict[str, Block] = {
        "outer": Sum(),
        "lag": LowPass(corner_frequency=10.0),
        "inner": Gain(gain=-4.0),
        "slow": UnitDelay(),
        "back": Gain(gain=-0.5),
    }
    wires = [
        "lag.output -> inner.input",
        "inner.output -> outer.first",
        "back.output -> outer.second",
        "outer.output -> lag.input",
        "lag.output -> slow.input",
        "slow.output -> back.input",
    ]
    return Graph(name="mixed", rate=1000, blocks=blocks, wires=wires)


def test_an_analog_loop_within_a_sampled_one() -> None:
    found = proofmass.margins(mixed(), "inner.output")
    assert found.poles == pytest.approx([-5.0 * 2.0 * math.pi * 10.0])
    (note,) = found.system.map.notes
    assert note == "loops through discrete blocks are open here: held are back.output"
    assert not proofmass.margins(mixed(), "back.output").system.continuous


def test_what_cannot_be_opened_in_continuous_time() -> None:
    blocks: dict[str, Block] = {"a": LowPass(), "b": LowPass(), "hold": UnitDelay()}
    wires = ["a.output -> b.input", "b.output -> hold.input", "hold.output -> a.input"]
    graph = Graph(name="sampled", rate=1000, blocks=blocks, wires=wires)
    with pytest.raises(ModelError) as caught:
        proofmass.margins(graph, "a.output")
    (problem,) = caught.value.problems
    assert "no loop among continuous blocks goes through a.output" in problem.message
    assert problem.hint == "open the loop at b.output or hold.output"
    assert proofmass.margins(graph, "b.output").sample == 1e-3


@pytest.mark.exhaustive
def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "servo.toml"
    path.write_text(write_graph(servo()))
    picture = tmp_path / "servo.svg"
    assert main(["margins", str(path), "--plot", str(picture)]) == 0
    said = capsys.readouterr().out
    assert "gain margin       +20.83 dB (x 11)" in said
    assert "delay margin      1.0548 s\n" in said
    assert picture.stat().st_size > 10_000
    assert main(["margins", str(path), "--json", "--sensitivity", "set.output", "error.output"]) == 0
    (loop,) = json.loads(capsys.readouterr().out)["loops"]
    assert (loop["period_s"], loop["delay_margin_samples"]) == (0.0, None)


@pytest.mark.parametrize("scale", [1.0, 1e-3])
@pytest.mark.parametrize(("gain", "matters"), [(130.0, 120.0), (25.0, 75.0)])
def test_a_change_matters_within_turns_of_the_lowest_crossover(gain: float, matters: float, scale: float) -> None:
    """K / (s + 50) crosses one at sqrt(K^2 - 50^2); where it does not, the pole of the closed loop counts."""
    wire = (("x", "output", 0),)
    matrix = np.array([[-50.0 * scale, scale, 0.0], [-gain, 0.0, 0.0]])
    within = _matters(PeriodMap((("x", "state", -1),), wire, wire, matrix, {}, 0.0))
    assert within == pytest.approx(1.0 / (FROZEN * matters * scale), rel=0.02)
    still = PeriodMap((), wire, wire, np.array([[-gain, 0.0]]), {}, 0.0)
    assert _matters(still) == math.inf
