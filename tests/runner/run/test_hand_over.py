"""Plain Python begins, machine code goes on: the same bits at every tick of the hand-over, and no worse an end."""

import dataclasses
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import Ramp
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph, read_graph_text
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.tick_loop import TickLoop
from proofmass.runner.reference.interpret import Interpreter
from proofmass.runner.run import hand_over
from proofmass.runner.run import simulate as simulation
from proofmass.runner.run.compiling import Compiling
from proofmass.runner.run.hand_over import HandOver
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunError, simulate
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
from tests.by_hand.graph_texts import ALONE
from tests.by_hand.hand_over import ReadyAfter, as_text, handed_over, run

SEVERAL_RATES = read_graph_text("""
name = "several rates, noise, vectors, driven parameters, measures"
rate = "10 kHz"
seed = 5
wires = [
    "chips.bit -> level.bit", "level.output -> mass.force", "mass.displacement -> readout.input",
    "readout.output -> sum.first", "noise.output -> sum.second", "sum.output -> adc.voltage",
    "adc.code -> cells.code", "chips.bit -> cells.bit", "number.output -> dac.number",
    "reference.output -> dac.reference", "sum.output -> slow.input",
]
probes = ["adc.code", { signal = "sum.output", every = 3 }, "cells.impulse_response", "dac.voltage", "slow.output"]
blocks.chips = { kind = "ShiftRegister", length = 4, taps = 12, seed = 1, rate = "2 kHz" }
blocks.level = { kind = "OneBitActuator", level = "1 uN", rate = "2 kHz" }
blocks.mass = { kind = "MassSpringDamper", damping = 1e-4 }
blocks.number = { kind = "Ramp", slope = 400.0, offset = -0.3 }
blocks.noise = { kind = "WhiteNoise", density = 0.01, unit = "V", rate = "10/3 kHz" }
blocks.sum = { kind = "Sum", unit = "V" }
blocks.adc = { kind = "AnalogToDigital", bits = 16, reference = "16 V" }
blocks.cells = { kind = "Correlator", cells = 3, chips = 15 }
blocks.reference = { kind = "Ramp", slope = "3 V/s", offset = "2 V", unit = "V", rate = "2 kHz" }
blocks.dac = { kind = "DigitalToAnalog", bits = 16 }
blocks.slow = { kind = "UnitDelay", unit = "V", rate = "10/7 kHz" }
[blocks.readout]
kind = "TransferFunction"
numerator = [3e6]
denominator = [1e-4, 1.0]
input_unit = "m"
output_unit = "V"
[measures]
mean = { signal = "sum.output", statistic = "mean" }
noise = { signal = "sum.output", statistic = "std", from = "2 ms" }
""")
BOUNCING = read_graph_text("""
name = "a ball between stops"
rate = "100 Hz"
wires = ["weight.output -> ball.force"]
probes = ["ball.displacement", "ball.last_impact"]
blocks.weight = { kind = "Constant", value = "-9.80665 N", unit = "N" }
[blocks.ball]
kind = "MassBetweenStops"
mass = "1 kg"
damping = 0.0
stiffness = 0.0
lowest = "0 m"
highest = "10 m"
restitution = 0.9
initial_displacement = "0.2 m"
""")
LIBRARY = ("recorded_motion", "vibratory_gyroscope", "closed_loop_accelerometer", "self_calibration_fixed")


def of_library(name: str) -> Graph:
    return read_graph(library_file(f"{name}.toml"))


def same_at(graph: Graph, hand_overs: list[tuple[int, ...]], last: int) -> None:
    """The same rows and memory as of either engine alone, wherever the chunks of plain Python end."""
    planned = plan(graph)
    compiled = CompiledPlan(planned)
    seed = planned.graph.seed
    expected, memory = run(Interpreter(planned, seed, 0, start(planned)), planned, (last,))
    rows, of_compiled = run(CompiledLoop(planned, seed, 0, None, compiled), planned, (last,))
    assert rows == expected
    assert as_text(of_compiled) == as_text(memory)
    for ticks in hand_overs:
        rows, of_both = handed_over(compiled, ticks, last)
        assert rows == expected, ticks
        assert as_text(of_both) == as_text(memory), ticks


class TestBits:
    @pytest.mark.exhaustive
    def test_at_every_tick_of_several_rates(self) -> None:
        same_at(SEVERAL_RATES, [(tick,) for tick in range(1, 72)], 73)

    def test_before_the_first_tick_and_after_odd_chunks(self) -> None:
        same_at(SEVERAL_RATES, [(), (1, 2), (3, 10, 31), (16, 48, 49, 50)], 120)

    @pytest.mark.exhaustive
    def test_between_and_in_ticks_with_events(self) -> None:
        same_at(BOUNCING, [(tick,) for tick in range(1, 100, 3)], 110)

    @pytest.mark.exhaustive("radau")
    @pytest.mark.parametrize("method", ["runge_kutta_4", "dormand_prince", "radau"])
    def test_among_steps_of_a_group(self, method: str) -> None:
        stepped = dataclasses.replace(BOUNCING, integration={"method": method})  # type: ignore[arg-type]
        same_at(stepped, [(1,), (17,), (20, 21), (40,)], 60)

    @pytest.mark.parametrize("name", LIBRARY)
    def test_of_graphs_of_the_library(self, name: str) -> None:
        same_at(of_library(name), [(), (1,), (13, 29)], 60)

    @pytest.mark.exhaustive
    @pytest.mark.parametrize("name", [path.stem for path in ALONE])
    def test_of_every_graph_of_the_library(self, name: str) -> None:
        same_at(of_library(name), [(tick,) for tick in (1, 2, 3, 5, 8, 13, 21, 34, 55, 89)], 100)


def ready_after(looks: int, monkeypatch: pytest.MonkeyPatch) -> list[ReadyAfter]:
    """Let the next runs have machine code that is ready after so many chunks, also the short ones."""
    made: list[ReadyAfter] = []

    def compiling(planned: Plan, quick: bool) -> ReadyAfter:
        made.append(ReadyAfter(CompiledPlan(planned, quick=quick), looks))
        return made[-1]

    monkeypatch.setattr(hand_over, "Compiling", compiling)
    monkeypatch.setattr(hand_over, "choose", lambda planned, ticks, wanted: "compiled" if wanted == "auto" else wanted)
    return made


def facts(result: Result) -> tuple[Any, ...]:
    measures = {name: (measure.value, measure.unit) for name, measure in result.measures.items()}
    return result.digest, measures, dict(result.overflows), result.ticks


def interrupted_after(ticks: int) -> Callable[[int, int], None]:
    """A progress that presses Ctrl-C, once."""
    sent: list[int] = []

    def progress(done: int, total: int) -> None:
        if done >= ticks and not sent:
            sent.append(done)
            os.kill(os.getpid(), signal.SIGINT)

    return progress


class TestRuns:
    @pytest.mark.parametrize("looks", [0, 1, 2, 5])
    def test_the_result_is_that_of_one_engine(self, looks: int, monkeypatch: pytest.MonkeyPatch) -> None:
        expected = simulate(SEVERAL_RATES, samples=1500, engine="python")
        ready_after(looks, monkeypatch)
        monkeypatch.setattr(simulation, "CHUNK_BYTES", 2000)
        found = simulate(SEVERAL_RATES, samples=1500)
        assert facts(found) == facts(expected)
        assert found.provenance["engine"] == "compiled"
        assert ("handed_over" in found.provenance) == (looks > 0)

    def test_provenance_says_where_and_no_digest_has_it(self, monkeypatch: pytest.MonkeyPatch) -> None:
        ready_after(1, monkeypatch)
        found = simulate(SEVERAL_RATES, samples=100)
        assert found.provenance["handed_over"] == "by plain Python at tick 16"
        assert found.digest == simulate(SEVERAL_RATES, samples=100, engine="compiled").digest

    @pytest.mark.exhaustive("stops2")
    @pytest.mark.parametrize("stops", [[40], [700], [40, 700, 1200]])
    def test_a_run_that_is_interrupted_goes_on(
        self, stops: list[int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        expected = simulate(SEVERAL_RATES, samples=1500, engine="python")
        ready_after(3, monkeypatch)
        monkeypatch.setattr(simulation, "CHUNK_BYTES", 2000)
        for number, ticks in enumerate(stops):
            progress = interrupted_after(ticks)
            half = simulate(SEVERAL_RATES, samples=1500, folder=tmp_path, progress=progress, resume=number > 0)
            assert half.interrupted
        assert facts(simulate(SEVERAL_RATES, samples=1500, folder=tmp_path, resume=True)) == facts(expected)

    @pytest.mark.parametrize("looks", [1, 3])
    def test_a_fault_behind_it_is_named_by_its_tick(self, looks: int, monkeypatch: pytest.MonkeyPatch) -> None:
        graph = read_graph_text("""
            name = "grows"
            rate = "1 kHz"
            wires = ["gain.output -> delay.input", "delay.output -> gain.input"]
            blocks.gain = { kind = "Gain", gain = 3.0 }
            blocks.delay = { kind = "UnitDelay", initial = 1.0 }
        """)
        with pytest.raises(RunError) as expected:
            simulate(graph, samples=2000, engine="python")
        ready_after(looks, monkeypatch)
        with pytest.raises(RunError) as found:
            simulate(graph, samples=2000)
        assert str(found.value) == str(expected.value)
        assert "in tick 646" in str(found.value)  # 3**647 is beyond 1.8e308


class TestCompiling:
    def test_a_run_that_plain_python_ends_soon_is_not_compiled(self) -> None:
        planned = plan(SEVERAL_RATES)
        never = ReadyAfter(CompiledPlan(planned), 10**9)
        engine = HandOver(planned, 0, 0, start(planned), never, 200, expected=3600.0)
        run(engine, planned, (16, 48, 200))
        assert (engine.name, engine.handed_over, never.asked) == ("python", None, 0)
        engine = HandOver(planned, 0, 0, start(planned), never, 200, expected=1e-9)
        run(engine, planned, (16, 48, 200))
        assert never.asked == 2

    @pytest.mark.exhaustive
    def test_it_is_looked_up_first_and_made_when_it_is_wanted(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr("proofmass.runner.targets.machine_code._loaded", {})
        planned = plan(BOUNCING)
        compiling = Compiling(planned)
        assert compiling.looked.wait(60.0)
        assert not compiling.ended.wait(0.05)
        assert not (tmp_path / "cache").exists()
        compiling.want()
        compiling.want()
        assert compiling.ended.wait(60.0)
        assert compiling.result().plan is planned
        assert len(list((tmp_path / "cache").glob("*.o"))) == 1
        warm = Compiling(planned)
        assert warm.ended.wait(60.0)
        assert warm.looked.is_set()

    def test_it_is_made_if_it_was_wanted_while_it_is_looked_up(
        self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        wanted = threading.Event()

        def write(planned: Plan) -> TickLoop:
            assert wanted.wait(60.0)
            return write_tick(planned)

        monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path))
        monkeypatch.setattr("proofmass.runner.program.tick.write_tick", write)
        planned = plan(Graph(name="", rate=1, blocks={"ramp": Ramp(slope=2.0)}, probes=["ramp.output"]))
        compiling = Compiling(planned)
        compiling.want()
        wanted.set()
        assert compiling.ended.wait(60.0)
        assert compiling.result().plan is planned

    @pytest.mark.exhaustive
    def test_cold_and_warm_runs(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PROOFMASS_CACHE", str(tmp_path / "cache"))
        monkeypatch.setattr("proofmass.runner.targets.machine_code._loaded", {})
        monkeypatch.setattr(hand_over, "LOOKING_SECONDS", 60.0)
        cold, warm = (simulate(SEVERAL_RATES, samples=200_000) for _ in range(2))
        assert facts(cold) == facts(warm) == facts(simulate(SEVERAL_RATES, samples=200_000, engine="compiled"))
        assert cold.provenance["handed_over"].startswith("by plain Python at tick ")
        assert warm.provenance["engine"] == "compiled"
        assert "handed_over" not in warm.provenance

    def test_what_goes_wrong_in_the_thread_ends_the_run(self, monkeypatch: pytest.MonkeyPatch) -> None:
        def refuse(planned: Plan) -> TickLoop:
            raise ModelError([Problem(message="is beyond what is compiled", key="ball")])

        monkeypatch.setattr("proofmass.runner.program.tick.write_tick", refuse)
        with pytest.raises(ModelError, match="ball: is beyond what is compiled"):
            simulate(BOUNCING, samples=10**7)
        assert simulate(BOUNCING, samples=10).provenance["engine"] == "python"


CHAIN = """
import atexit, os, signal, sys, threading, time
from proofmass import Graph, simulate
from proofmass.blocks import Constant, Gain, Saturation, UnitDelay
blocks = {"source": Constant(value=1.0)}
wires, before = [], "source.output"
for number in range(600):
    kinds = Gain(gain=0.5 + 1e-3 * number), UnitDelay(), Saturation(lowest=-1e3, highest=1e3)
    blocks[f"b{number}"] = kinds[number % 3]
    wires.append(f"{before} -> b{number}.input")
    before = f"b{number}.output"
graph = Graph(name="chain", rate="10 kHz", blocks=blocks, wires=wires, probes=[before])
"""


def ended(script: str, tmp_path: Path) -> tuple[int, str, float]:
    """Exit code, output and seconds of a process with an empty cache."""
    began = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-X", "faulthandler", "-c", CHAIN + script],
        env=os.environ | {"PROOFMASS_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )
    return done.returncode, done.stdout + done.stderr, time.perf_counter() - began


class TestTheEndOfTheProcess:
    @pytest.mark.exhaustive
    def test_ctrl_c_while_it_compiles(self, tmp_path: Path) -> None:
        script = """
first = []
def progress(done, total):
    if done >= 16 and not first:
        first.append(any(t.name == "proofmass compiling" for t in threading.enumerate()))
        os.kill(os.getpid(), signal.SIGINT)
result = simulate(graph.changed(probes=()), samples=10**9, progress=progress)
print(first, result.interrupted, result.provenance["engine"])
"""
        code, text, _ = ended(script, tmp_path)
        assert (code, text) == (0, "[True] True python\n")

    @pytest.mark.exhaustive
    def test_a_fault_while_it_compiles(self, tmp_path: Path) -> None:
        script = """
def progress(done, total):
    if done >= 16:
        raise SystemExit(3)
simulate(graph.changed(probes=()), samples=10**9, progress=progress)
"""
        code, text, _ = ended(script, tmp_path)
        assert (code, text) == (3, "")

    @pytest.mark.exhaustive
    def test_writing_the_program_keeps_no_process(self, tmp_path: Path) -> None:
        script = """
from proofmass.runner.program import tick
tick.write_tick = lambda planned: time.sleep(60.0)
def progress(done, total):
    if done >= 16:
        raise SystemExit(4)
simulate(graph.changed(probes=()), samples=10**9, progress=progress)
"""
        code, text, seconds = ended(script, tmp_path)
        assert (code, text) == (4, "")
        assert seconds < 50.0

    @pytest.mark.exhaustive
    @pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
    def test_a_child_made_while_it_compiles_can_compile(self, tmp_path: Path) -> None:
        script = """
import warnings
warnings.simplefilter("ignore")
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.compiling import Compiling
compiling = Compiling(plan(graph)); compiling.looked.wait(); compiling.want(); time.sleep(0.1)
child = os.fork()
small = Graph(name="small", rate=1000, blocks={"gain": Gain(), "one": Constant()}, wires=["one.output -> gain.input"])
if child == 0:
    os._exit(simulate(small, samples=10, engine="compiled").ticks)
print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), compiling.ended.wait(60.0))
"""
        code, text, _ = ended(script, tmp_path)
        assert (code, text) == (0, "10 True\n")
