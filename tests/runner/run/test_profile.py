"""The profile of a run: the bits of the plain loop, every block among the parts, and times that grow with the work."""

import json
import math
from types import SimpleNamespace
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import pytest
from scipy.stats import norm

from proofmass import Graph, block
from proofmass.blocks import Comparator, Constant, Counter, Difference, Gain, Sine, Sum, Switch
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.command_line import main
from proofmass.runner.program.timed_tick import CLOCK
from proofmass.runner.run import profile as profiling
from proofmass.runner.run.profile import profile
from proofmass.runner.run.simulate import RunOptions, simulate

X86_64 = llvm.get_default_triple().startswith("x86_64")
pytestmark = pytest.mark.skipif(not X86_64, reason="needs x86-64")


@block("1", value="1")
def short(p: Any, value: float) -> float:
    """Forty products, each of the one before."""
    for _ in range(40):
        value = 0.5 * value + 1.0
    return value


@block("1", value="1")
def long(p: Any, value: float) -> float:
    """Ten times as many."""
    for _ in range(400):
        value = 0.5 * value + 1.0
    return value


@pytest.mark.exhaustive
def test_ten_times_the_work_takes_ten_times_as_long() -> None:
    blocks = {"sine": Sine(), "short": short(), "long": long()}
    wires = ["sine.output -> short.value", "short.short -> long.value"]
    graph = Graph(name="work", rate="1 kHz", samples=2000, blocks=blocks, wires=wires, probes=["long.long"])
    result, profiled = profile(graph, RunOptions())
    assert result.digest == simulate(graph, engine="python").digest
    parts = {part.name: part for part in profiled.parts}
    assert {"sine", "short", "long", "recording", "the loop itself"} <= parts.keys()
    assert parts["long"].nanoseconds > 4.0 * parts["short"].nanoseconds  # 10 on a machine that does nothing else
    # each of the 400 waits for the one before: a product and a sum take at least 4 cycles, at most 5 GHz
    assert parts["long"].nanoseconds > 400 * 4 / 5.0
    assert list(profiled.phases) == ["check", "plan", "compile", "run"]


def test_parts_share_the_time_of_a_stretch_less_that_of_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """1 us for 10 ticks, of which the clock counts 1, 3 and 6 tenths."""
    loop = SimpleNamespace(parts=[CLOCK, "a", "b"])
    monkeypatch.setattr(profiling, "ProfiledLoop", lambda *_: loop)
    monkeypatch.setattr(profiling, "_stretch", lambda *_: (10, profiling.np.array([100, 300, 600]), 1e-6))
    clock, _, parts = profiling._parts(profiling.plan(Graph(name="", blocks={"one": Constant()}, rate=1.0)), 0, 10)
    assert clock == pytest.approx(10.0)
    assert {part.name: part.nanoseconds for part in parts} == pytest.approx({"a": 20.0, "b": 50.0})


def test_an_error_is_the_standard_error_of_a_lower_quartile(monkeypatch: pytest.MonkeyPatch) -> None:
    """sqrt(1/4 3/4 / n) / density of it, by the theory of order statistics; stretches spread as normal numbers."""
    loop = SimpleNamespace(parts=[CLOCK, "a", "b"])
    monkeypatch.setattr(profiling, "ProfiledLoop", lambda *_: loop)
    ranks = norm.ppf((np.arange(profiling.STRETCHES) + 0.5) / profiling.STRETCHES)
    counts = iter([[100.0, 300.0 + 20.0 * z, 600.0 - 20.0 * z] for z in (0.0, *ranks)])
    monkeypatch.setattr(profiling, "_stretch", lambda *_: (10, np.array(next(counts)), 1e-6))
    _, _, parts = profiling._parts(profiling.plan(Graph(name="", blocks={"one": Constant()}, rate=1.0)), 0, 10)
    density = norm.pdf(norm.ppf(0.25)) / 2.0  # per nanosecond, of a standard deviation of 2 ns
    expected = math.sqrt(0.25 * 0.75 / profiling.STRETCHES) / density
    assert [part.error for part in parts] == pytest.approx([expected] * 2, rel=0.02)


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", ["quartz_calibration", "six_axis_imu", "temperature_compensation_m1"])
@pytest.mark.friendly(39, "every block has its time")
def test_every_block_is_a_part_and_the_clock_changes_no_bit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Rates, groups of continuous blocks, registers and vectors: the timed program records what the plain one does."""
    monkeypatch.setattr(profiling, "STRETCHES", 1)
    graph = read_graph(library_file(f"{name}.toml"))
    planned = profiling.plan(graph)
    loop = profiling.ProfiledLoop(planned, graph.seed)
    rows = [profiling.np.empty((p.rows(0, 600), *p.shape), dtype=p.dtype) for p in planned.probes]
    counts = loop.advance(600, rows)
    assert (counts >= 0).all()
    assert counts.sum() > 0
    result = simulate(graph, samples=600, engine="python")
    for probe, values in zip(planned.probes, rows, strict=True):
        expected = result[probe.signal]
        got = values if probe.format is None else profiling.np.ldexp(values.astype(float), -probe.format.fraction)
        assert profiling.np.array_equal(got, expected.values, equal_nan=True), probe.signal
    named = {name for part in loop.parts for name in part.removeprefix("loop of ").split(", ")}
    scheduled = {step[0] for step in planned.schedule.order if isinstance(step, tuple)}
    assert {name for name in scheduled if not name.startswith("measures.")} <= named


@pytest.mark.defect("S743", before="--profile of a graph with a solved loop: AttributeError", after="its part")
def test_a_loop_that_is_solved_within_a_tick_is_a_part() -> None:
    """y = 1 - 3 y, and z = y + 2."""
    blocks = {"one": Constant(value=1.0), "error": Difference(), "gain": Gain(gain=3.0), "more": Sum()}
    blocks |= {"two": Constant(value=2.0)}
    wires = ["one.output -> error.first", "gain.output -> error.second", "error.output -> gain.input"]
    wires += ["error.output -> more.first", "two.output -> more.second"]
    newton = {"algebraic_loops": "newton"}
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["more.output"], integration=newton)
    loop = profiling.ProfiledLoop(profiling.plan(graph), 0)
    rows = [profiling.np.empty(5)]
    counts = loop.advance(5, rows)
    assert rows[0].tolist() == [2.25] * 5
    assert len(counts) == len(loop.parts)
    [solved] = [part for part in loop.parts if part.startswith("loop of ")]
    assert solved.removeprefix("loop of ") in {"error", "gain"}
    assert "more" in loop.parts


def test_numbers_of_each_kind_go_through_what_holds_them() -> None:
    """A number is held between two looks at the clock: a float, an integer and a truth value, each in its register."""
    blocks = {"sine": Sine(amplitude=2.0, frequency=90.0), "count": Counter(modulus=2**40), "zero": Constant(value=0.0)}
    blocks |= {"above": Comparator(), "chosen": Switch()}
    wires = ["sine.output -> above.input", "above.on -> chosen.choose_first", "sine.output -> chosen.first"]
    wires += ["zero.output -> chosen.second"]
    probes = ["chosen.output", "count.count"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=probes)
    rows = [profiling.np.empty(20), profiling.np.empty(20, dtype=int)]
    profiling.ProfiledLoop(profiling.plan(graph), 0).advance(20, rows)
    wave = [2.0 * math.sin(2.0 * math.pi * 0.09 * n) for n in range(20)]
    assert rows[0] == pytest.approx([max(value, 0.0) for value in wave], abs=1e-12)
    assert rows[1].tolist() == list(range(20))


@pytest.mark.exhaustive
@pytest.mark.friendly(39, "as a table by one option")
def test_the_command_shows_it_as_a_table_and_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "library:template", "--profile", "--quiet"]) == 0
    text = capsys.readouterr().out
    assert "part of a tick" in text
    assert "each part alone" in text
    assert main(["run", "library:template", "--profile", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)["profile"]
    assert list(data["seconds"]) == ["read", "check", "plan", "compile", "run"]
    assert {part["part"] for part in data["parts"]} >= {"adc", "sensor", "recording"}
    assert main(["run", "library:template", "--profile", "--engine", "python"]) == 2


def test_other_processors_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(profiling, "can_profile", lambda: False)
    with pytest.raises(ModelError, match="x86-64 only"):
        profile(read_graph(library_file("template.toml")), RunOptions())


def test_a_wrong_graph_is_told_before_anything_is_timed() -> None:
    graph = Graph(name="wrong", rate="1 kHz", samples=10, blocks={"short": short()}, wires=[])
    with pytest.raises(ModelError, match=r"short\.value"):
        profile(graph, RunOptions())
