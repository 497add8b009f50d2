"""Hardware in the loop: a graph with compiled Verilog in the place of its digital blocks, bit for bit."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from proofmass.blocks import FixedCorrelationCell, FixedGain, FixedQuantiser, Gain, Sine
from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.blocks.arithmetic.pipeline import pipe
from proofmass.blocks.declaration.declare import Block, Input
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.model import cxxrtl
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.engines import make_engine
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from tests.by_hand.machines import loop_at_rates

pytest.importorskip("pyosys")

ROOT = Path(__file__).parents[4]
CALIBRATION = library_file("self_calibration_fixed.toml")
TICKS = 3000

IN_ANOTHER_PROCESS = """\
import sys
sys.path[:0] = ["src", "."]
sys.modules["numba"] = None  # nothing is compiled anew
from tests.runner.rtl.model.test_co_simulation import TICKS, simulate, through_both
print(*simulate(through_both(), samples=TICKS, engine="cxxrtl").traces["doubled.output"].values.tolist())
"""

needs_compiler = pytest.mark.skipif(cxxrtl.compiler() is None, reason="needs a C++ compiler")


class Above(Block):
    """Whether a number is above zero."""

    input = Input("1", "The number.")


@Above.output("1")
def output(p: Above, input: float) -> bool:
    """Whether it is."""
    return input > 0.0


class Late(Block):
    """A register that the simulation does not know."""

    input = Input("1", "What comes late.", dtype=FixedValue)


@Late.formats
def formats(p: Late) -> dict[str, Fixed]:
    return {"input": Fixed(16, 12), "late": Fixed(16, 12)}


@Late.output("1")
def late(p: Late, input: FixedValue) -> FixedValue:
    """The input, in hardware a tick later."""
    return pipe(input)


def through_both(gain: float = 0.75, amplitude: float = 2.5) -> Graph:
    """Through hardware, what is analogue, and hardware again within a tick, at rates of their own."""
    graph = loop_at_rates(error=3000, gain=3000, integrator=1000)
    blocks = graph.blocks | {
        "setpoint": Sine(amplitude=amplitude, frequency=317.0),
        "quantiser": FixedQuantiser(overflow="refuse"),
        "gain": FixedGain(gain=gain, input_format=Fixed(17, 12)),
        "halved": Gain(gain=0.5),
        "again": FixedQuantiser(),
        "doubled": FixedGain(gain=2.0),
        "above": Above(),
        "cell": FixedCorrelationCell(lag=3, order=2, unit="1"),
    }
    wires = [
        *graph.wires,
        "number.output -> halved.input",
        "halved.output -> again.input",
        "again.output -> doubled.input",
        "setpoint.output -> above.input",
        "above.output -> cell.bit",
        "quantiser.output -> cell.response",
    ]
    rates = {**graph.rates, "doubled": 3000, "cell": 3000}
    probes = [*graph.probes, "doubled.output", "cell.coefficient"]
    return replace(graph, blocks=blocks, wires=wires, rates=rates, probes=probes)


def bits(result: Result) -> dict[str, bytes]:
    return {name: trace.values.tobytes() for name, trace in result.traces.items()}


def interrupting(ticks: int) -> Any:
    """A progress that interrupts this process, once."""

    def press() -> Iterator[None]:
        os.kill(os.getpid(), signal.SIGINT)
        yield

    pressed = press()
    return lambda done, total: next(pressed, None) if done >= ticks else None


@pytest.mark.exhaustive
@needs_compiler
def test_a_graph_with_its_hardware_beside_gives_the_same_bits() -> None:
    whole = simulate(through_both(), samples=TICKS, engine="cxxrtl")
    expected = simulate(through_both(), samples=TICKS, engine="python")
    assert bits(whole) == bits(expected)
    assert all(len(set(trace.values.tolist())) > 10 for trace in expected.traces.values())
    assert whole.provenance["engine"] == "cxxrtl"
    assert "integrator" in expected.overflows
    assert "integrator" not in whole.overflows  # hardware keeps no count


@pytest.mark.exhaustive
@needs_compiler
def test_the_whole_calibration_to_the_bit_in_every_register() -> None:
    planned = plan(read_graph(CALIBRATION))
    one, other = (make_engine(planned, name, 1, 0, start(planned), planned.ticks()) for name in ("compiled", "cxxrtl"))
    for first in range(0, planned.ticks(), 399_989):  # anywhere in a chip
        last = min(first + 399_989, planned.ticks())
        rows, others = ([np.zeros(probe.rows(first, last)) for probe in planned.probes] for _ in range(2))
        assert one.advance(last, rows)
        assert other.advance(last, others)
        assert [each.tolist() for each in rows] == [each.tolist() for each in others]
        expected, found = one.memory(), other.memory()
        assert (found.tick, found.states, found.buffers) == (expected.tick, expected.states, expected.buffers)
    assert found.wires["stiffness", "stiffness"] / 2**12 == pytest.approx(51.48, rel=4e-4)  # that of the device
    assert found.wires["damping", "damping"] / 2**22 == pytest.approx(4.57e-3, rel=2e-3)


@pytest.mark.exhaustive
@needs_compiler
@pytest.mark.parametrize("ticks", [1, 1111])
def test_the_engines_take_over_from_each_other(ticks: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.run.simulate.CHUNK_BYTES", 700)
    graph = through_both()
    whole = bits(simulate(graph, samples=TICKS, engine="python"))
    engines: list[EngineName] = ["python", "cxxrtl", "compiled", "cxxrtl", "python"]
    for number, engine in enumerate(engines):
        progress = interrupting(ticks + 400 * number)
        simulate(graph, samples=TICKS, engine=engine, folder=tmp_path, progress=progress, resume=number > 0)
    ended = simulate(graph, samples=TICKS, engine="cxxrtl", folder=tmp_path, resume=True)
    assert bits(ended) == whole


@pytest.mark.exhaustive
@needs_compiler
def test_a_count_that_hardware_did_not_keep_stays_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("proofmass.runner.run.simulate.CHUNK_BYTES", 700)
    simulate(through_both(), samples=TICKS, engine="cxxrtl", folder=tmp_path, progress=interrupting(100))
    for number, engine in enumerate(("python", "compiled")):
        progress = interrupting(1000 + 1000 * number)
        going_on = simulate(
            through_both(), samples=TICKS, engine=engine, folder=tmp_path, progress=progress, resume=True
        )
        assert "integrator" not in going_on.overflows
        assert "again" in going_on.overflows


@pytest.mark.exhaustive
@needs_compiler
def test_another_text_is_another_model_in_the_same_process() -> None:
    for gain in (0.75, 0.5, 0.75):
        graph = through_both(gain)
        found = simulate(graph, samples=TICKS, engine="cxxrtl")
        assert bits(found) == bits(simulate(graph, samples=TICKS, engine="compiled"))


@pytest.mark.exhaustive
@needs_compiler
def test_machine_code_that_was_kept_finds_the_functions_of_a_new_process() -> None:
    found = simulate(through_both(), samples=TICKS, engine="cxxrtl").traces["doubled.output"].values
    ended = subprocess.run(
        [sys.executable, "-c", IN_ANOTHER_PROCESS], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert ended.stdout.split() == [str(value) for value in found.tolist()], ended.stderr


@pytest.mark.exhaustive
@needs_compiler
def test_a_number_that_does_not_fit_is_named_as_without_hardware() -> None:
    problems = []
    for engine in ("python", "cxxrtl"):
        with pytest.raises(RunError) as caught:
            simulate(through_both(amplitude=9.0), samples=TICKS, engine=engine)
        problems.append(caught.value.problem)
    assert problems[0] == problems[1]
    assert problems[0].key == "quantiser.output"


def test_hardware_that_is_late_is_refused() -> None:
    graph = Graph(
        name="late",
        rate=1000,
        blocks={"sine": Sine(), "quantiser": FixedQuantiser(), "late": Late()},
        wires=["sine.output -> quantiser.input", "quantiser.output -> late.input"],
        probes=["late.late"],
    )
    with pytest.raises(ModelError, match="hardware with pipeline cuts is late, and the graph would see that") as caught:
        simulate(graph, samples=10, engine="cxxrtl")
    assert "1 ticks" in str(caught.value)


def test_what_is_missing_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    with monkeypatch.context() as patched:
        patched.setattr(cxxrtl.shutil, "which", lambda name: None)
        with pytest.raises(ModelError, match=r"there is no C\+\+ compiler: it makes compiled models of Verilog"):
            simulate(through_both(), samples=10, engine="cxxrtl")
    monkeypatch.setattr("proofmass.blocks.declaration.libraries.installed", lambda package: False)
    with pytest.raises(ModelError, match=r"pyosys is not installed: it makes compiled models of Verilog"):
        simulate(through_both(), samples=10, engine="cxxrtl")
