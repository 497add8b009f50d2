"""What a run says before it starts and when it cannot go on: sizes, engines, faults."""

import threading
import time
from typing import Any

import pytest

from proofmass.blocks import Constant, ElectrostaticSoftening, FixedProduct, FixedQuantiser, Ramp, Step
from proofmass.graphs.model.build import Graph
from proofmass.runner.plan.memory import start
from proofmass.runner.planning.plan import plan
from proofmass.runner.run.compiling import Compiling
from proofmass.runner.run.engines import INTERPRETED_PART, choose
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.hand_over import HandOver
from proofmass.runner.run.simulate import simulate
from proofmass.runner.run.trace_size import size_text
from proofmass.runner.targets.machine_code import LlvmModule

STEP = Graph(name="", rate="1 kHz", blocks={"step": Step()}, probes=["step.output"])


def test_plates_that_touch_are_told_with_their_tick_and_their_cure() -> None:
    plates = ElectrostaticSoftening()
    blocks = {"ramp": Ramp(slope=5e-4, unit="m"), "volts": Constant(value=1.0, unit="V"), "plates": plates}
    wires = ["ramp.output -> plates.displacement", "volts.output -> plates.voltage"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["plates.force"])
    touched = 8  # 8 x 0.5 um is the gap of 4 um
    with pytest.raises(RunError) as caught:
        simulate(graph, samples=100, engine="python")
    problem = caught.value.problem
    assert problem.key == "plates.force"
    assert problem.message == f"has no value in tick {touched}, t = {touched * 1e-3:.9g} s"
    assert problem.got == "nan"
    assert problem.hint.startswith(type(plates).outputs["force"].no_value)
    assert "ramp.output" in problem.hint


def test_numbers_wider_than_64_bits_are_interpreted() -> None:
    wide: dict[str, Any] = {"first_format": "(40, 20)", "second_format": "(40, 20)", "output_format": "(40, 20)"}
    blocks = {"step": Step(), "code": FixedQuantiser(output_format="(40, 20)"), "squared": FixedProduct(**wide)}
    wires = ["step.output -> code.input", "code.output -> squared.first", "code.output -> squared.second"]
    graph = Graph(name="", rate="1 kHz", blocks=blocks, wires=wires, probes=["squared.output"])
    planned = plan(graph, wide=True)
    assert choose(planned, 10**9, "auto") == "python"
    assert choose(plan(STEP), 10**9, "auto") == "compiled"


def test_a_long_run_says_how_long_it_is() -> None:
    planned = plan(STEP)
    assert size_text(planned, 1000) == ""
    assert size_text(planned, 2**30) == "1,073,741,824 ticks, 8,192 MiB of traces"


def test_what_goes_wrong_with_compiling_is_raised_where_the_run_is(monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: Any) -> LlvmModule:
        raise MemoryError("no room for code")

    monkeypatch.setattr(LlvmModule, "of", broken)
    compiling = Compiling(plan(STEP))
    assert compiling.ended.wait(60.0)
    with pytest.raises(MemoryError, match="no room for code"):
        compiling.result()


class NeverReady:
    """Machine code that is not ready, and whether somebody wants it."""

    def __init__(self) -> None:
        self.looked, self.ended, self.wanted = threading.Event(), threading.Event(), False
        self.looked.set()

    def want(self) -> None:
        self.wanted = True


@pytest.mark.parametrize(("expected", "wanted"), [(1e6, False), (15.0, True)])
def test_a_run_that_plain_python_ends_sooner_does_not_wait(expected: float, wanted: bool) -> None:
    """Ten seconds are left: less than a part of what compiling takes, or more than it but less than all of it."""
    assert INTERPRETED_PART * 15.0 < 10.0 < 15.0
    planned, compiling = plan(STEP), NeverReady()
    engine = HandOver(planned, 0, 0, start(planned), compiling, 10, expected)  # type: ignore[arg-type]
    engine._chunk = (1, 1.0)
    began = time.perf_counter()
    assert not engine._is_ready(compiling)  # type: ignore[arg-type]
    assert time.perf_counter() - began < 0.5, "it did not wait"
    assert compiling.wanted is wanted
    assert engine.name == "python"
