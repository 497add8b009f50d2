"""Compiled models of Verilog against the blocks' functions in Python, and the engine that runs one in a graph."""

import random
from pathlib import Path

import numpy as np
import pytest

from proofmass.blocks.declare import Block
from proofmass.blocks.fixed_cordic_exponential_pipeline import FixedCordicExponentialPipeline
from proofmass.blocks.fixed_correlation_cell import FixedCorrelationCell
from proofmass.blocks.fixed_pid import FixedPID
from proofmass.blocks.problem import ModelError
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.engine.engines import make_engine
from proofmass.runner.engine.memory import start
from proofmass.runner.engine.plan import plan
from proofmass.runner.engine.simulate import simulate
from proofmass.runner.rtl import cxxrtl
from proofmass.runner.rtl.cxxrtl import Model
from proofmass.runner.rtl.reference import ModuleReference, as_it_runs
from proofmass.runner.rtl.verilog import module_text
from tests.runner.modules_by_hand import Reference, module_of

pytest.importorskip("pyosys")

CALIBRATION = Path(__file__).parents[2] / "graphs" / "library" / "self_calibration_fixed.toml"
CLOCKS = 2000

needs_compiler = pytest.mark.skipif(cxxrtl.compiler() is None, reason="needs a C++ compiler")


@needs_compiler
@pytest.mark.parametrize("block", [FixedPID(), FixedCorrelationCell(lag=2, order=4)], ids=lambda b: type(b).__name__)
def test_a_model_does_what_the_functions_do(block: Block) -> None:
    module, draws = module_of(block), random.Random(1)
    inputs = {
        port.name: np.array([draws.choice((low, high, draws.randint(low, high))) for _ in range(CLOCKS)])
        for port in module.inputs
        for low, high in [(port.word.low, port.word.high)]
    }
    found = Model(ModuleReference(module), module_text(module)).run(inputs, CLOCKS)
    reference = Reference(module)
    for t in range(CLOCKS):
        expected = reference.tick({name: int(column[t]) for name, column in inputs.items()})
        assert {name: column[t] for name, column in found.items()} == expected


@needs_compiler
def test_the_pipelined_exponential_gives_every_input_its_value_later() -> None:
    pipeline = FixedCordicExponentialPipeline(fraction_bits=8, iterations=6)
    module = module_of(pipeline)
    angles = np.arange(1 << 8)
    ticks = len(angles) + 32
    found = Model(ModuleReference(module), module_text(module)).run({"angle": np.resize(angles, ticks)}, ticks)
    reference = Reference(module)
    expected = [reference.tick({"angle": int(angle)})["exponential"] for angle in np.resize(angles, ticks)]
    assert found["exponential"].tolist() == expected


@needs_compiler
def test_registers_are_read_and_written() -> None:
    module = module_of(FixedPID())
    reference = ModuleReference(module)
    model, draws = Model(reference, module_text(module)), random.Random(2)
    held = {each.name: draws.randint(each.word.low, each.word.high) for each in reference.registers}
    given = {each.name: draws.randint(each.word.low, each.word.high) for each in reference.inputs}
    model.held = list(held.values())
    assert model.held == list(held.values())
    clock = reference.clock(held | given, as_it_runs)
    assert model.settled([given[port.name] for port in reference.inputs]) == list(clock.outputs.values())
    model.clock()
    assert model.held == list(clock.following.values())


def test_without_a_compiler_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cxxrtl.shutil, "which", lambda name: None)
    module = module_of(FixedPID())
    with pytest.raises(ModelError, match=r"there is no C\+\+ compiler: it makes compiled models of Verilog"):
        Model(ModuleReference(module), module_text(module))


@needs_compiler
def test_a_graph_with_its_hardware_beside_gives_the_same_bits(tmp_path: Path) -> None:
    graph = read_graph(CALIBRATION)
    whole = simulate(graph, samples=3000, engine="cxxrtl")
    expected = simulate(graph, samples=3000, engine="python")
    assert {name: trace.values.tolist() for name, trace in whole.traces.items()} == {
        name: trace.values.tolist() for name, trace in expected.traces.items()
    }
    assert whole.provenance["engine"] == "cxxrtl"
    assert "model" in expected.overflows
    assert "model" not in whole.overflows  # hardware keeps no count


@needs_compiler
def test_hardware_goes_on_from_any_tick() -> None:
    planned = plan(read_graph(CALIBRATION))
    whole = make_engine(planned, "cxxrtl", 1, 0, start(planned))
    interpreted = make_engine(planned, "python", 1, 0, start(planned))
    rows = [np.zeros(probe.rows(0, 2100)) for probe in planned.probes]
    interpreted.advance(1100, rows)
    going_on = make_engine(planned, "cxxrtl", 1, 0, interpreted.memory().copy())
    for engine in (whole, going_on, interpreted):
        engine.advance(2100, rows)
    expected = interpreted.memory()
    for engine in (whole, going_on):
        found = engine.memory()
        assert (found.tick, found.states, found.buffers) == (expected.tick, expected.states, expected.buffers)
