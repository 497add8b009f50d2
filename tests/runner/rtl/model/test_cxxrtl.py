"""Compiled models of Verilog against the blocks' functions in Python."""

import ctypes
import random

import numpy as np
import pytest

from proofmass.blocks import FixedCordicExponentialPipeline, FixedCorrelationCell, FixedPID
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.rtl.machine.reference import ModuleReference, as_it_runs
from proofmass.runner.rtl.model import cxxrtl
from proofmass.runner.rtl.model.cxxrtl import VerilogModel
from proofmass.runner.rtl.text.verilog import module_text
from tests.by_hand.modules import Reference, module_of

pytest.importorskip("pyosys")

CLOCKS = 2000

needs_compiler = pytest.mark.skipif(cxxrtl.compiler() is None, reason="needs a C++ compiler")


@pytest.mark.exhaustive
@needs_compiler
@pytest.mark.parametrize("block", [FixedPID(), FixedCorrelationCell(lag=2, order=4)], ids=lambda b: type(b).__name__)
def test_a_model_does_what_the_functions_do(block: Block) -> None:
    module, draws = module_of(block), random.Random(1)
    inputs = {
        port.name: np.array([draws.choice((low, high, draws.randint(low, high))) for _ in range(CLOCKS)])
        for port in module.inputs
        for low, high in [(port.word.low, port.word.high)]
    }
    found = VerilogModel(ModuleReference(module), module_text(module)).run(inputs, CLOCKS)
    reference = Reference(module)
    for t in range(CLOCKS):
        expected = reference.tick({name: int(column[t]) for name, column in inputs.items()})
        assert {name: column[t] for name, column in found.items()} == expected


@pytest.mark.exhaustive
@needs_compiler
def test_the_pipelined_exponential_gives_every_input_its_value_later() -> None:
    pipeline = FixedCordicExponentialPipeline(fraction_bits=8, iterations=6)
    module = module_of(pipeline)
    angles = np.arange(1 << 8)
    ticks = len(angles) + 32
    found = VerilogModel(ModuleReference(module), module_text(module)).run({"angle": np.resize(angles, ticks)}, ticks)
    reference = Reference(module)
    expected = [reference.tick({"angle": int(angle)})["exponential"] for angle in np.resize(angles, ticks)]
    assert found["exponential"].tolist() == expected


def called(model: VerilogModel, name: str, *given: int) -> int:
    """What a compiled loop gets from a function of a model."""
    function = model.function(name)
    kinds = [ctypes.c_int64] * len(function.parameters)
    found: int = ctypes.CFUNCTYPE(ctypes.c_int64, *kinds)(function.address)(model.address, *given)
    return found


@pytest.mark.exhaustive
@needs_compiler
@pytest.mark.parametrize("settling", [True, False])
def test_a_clock_from_any_registers(settling: bool) -> None:
    module = module_of(FixedPID())
    reference = ModuleReference(module)
    model, draws = VerilogModel(reference, module_text(module)), random.Random(2)
    for _ in range(50):
        held = {each.name: draws.randint(each.word.low, each.word.high) for each in reference.registers}
        given = {each.name: draws.randint(each.word.low, each.word.high) for each in reference.inputs}
        for number, value in enumerate(held.values()):
            called(model, "set_register", number, value)
        assert [called(model, "register", number) for number in range(len(held))] == list(held.values())
        clock = reference.clock(held | given, as_it_runs)
        if settling:
            called(model, "settle", *given.values())
            assert [called(model, "output", n) for n in range(len(clock.outputs))] == list(clock.outputs.values())
        called(model, "clock", *given.values())
        assert [called(model, "register", n) for n in range(len(held))] == list(clock.following.values())


def test_without_a_compiler_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cxxrtl.shutil, "which", lambda name: None)
    module = module_of(FixedPID())
    with pytest.raises(ModelError, match=r"there is no C\+\+ compiler: it makes compiled models of Verilog"):
        VerilogModel(ModuleReference(module), module_text(module))
