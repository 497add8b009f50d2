"""Modules as Amaranth Elaboratables, proved equal to the functions of Python: through RTLIL, Yosys and the solver."""

import re
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.command_line import main
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.machine.reference import ModuleReference
from proofmass.runner.rtl.proof.proof import prove
from proofmass.runner.rtl.text.amaranth import amaranth_files, class_name
from proofmass.runner.rtl.tools.yosys import run_yosys
from tests.by_hand.machines import loop_at_rates, made
from tests.runner.rtl.text.test_machine_verilog import cut_graph


def verilog_of(module: Module, text: str, folder: Path) -> str:
    """The Verilog that Yosys makes of the Elaboratable of a module."""
    rtlil = pytest.importorskip("amaranth.back.rtlil")
    from amaranth.hdl import Signal

    space: dict[str, Any] = {}
    exec(compile(text, "machine_amaranth.py", "exec"), space)
    design = space[class_name(module)]()
    ports = [value for value in vars(design).values() if isinstance(value, Signal)]
    written = named_by_registers(rtlil.convert(design, name=module.name, ports=ports), module)
    (folder / "design.il").write_text(written, encoding="utf-8")
    clocking = ["rename clk clock", "rename rst reset"] if module.clocked else []
    run_yosys(folder, ["read_rtlil design.il", f"cd {module.name}", *clocking, "cd ..", "write_verilog design.v"])
    return (folder / "design.v").read_text(encoding="utf-8")


def named_by_registers(rtlil: str, module: Module) -> str:
    """Amaranth calls a register that is an output by the output; here by the register."""
    registers = "|".join(register.name for register in module.registers)
    outputs = "|".join(port.name for port in module.outputs)
    for register, output in re.findall(rf"^ *connect \\({registers}) \\({outputs})\b.*$", rtlil, re.MULTILINE):
        rtlil = re.sub(rf"^( *connect) \\{register} .*$", rf"\1 \\{output} \\{register}", rtlil, flags=re.MULTILINE)
        used = rf"^(?! *wire | *connect \\{output} )(.*)\\{output}\b"
        while re.search(used, rtlil, re.MULTILINE):
            rtlil = re.sub(used, rf"\1\\{register}", rtlil, flags=re.MULTILINE)
    return rtlil


def proofs_of(machine: Machine, folder: Path, old: str = "", new: str = "") -> dict[str, tuple[int, int]]:
    pytest.importorskip("pyosys")
    pytest.importorskip("bitwuzla")
    (text,) = amaranth_files(machine).values()
    guesses = {(node.low, node.high) for module in machine.modules for node in module.live}
    found = {}
    for module in machine.modules:
        proof = prove(ModuleReference(module), verilog_of(module, text.replace(old, new), folder), guesses)
        found[module.name] = (proof.proved, proof.goals)
    return found


@pytest.mark.exhaustive
@pytest.mark.parametrize("graph", [loop_at_rates(), cut_graph(1, 3)], ids=["loop", "cuts"])
def test_modules_are_proved_equal_to_python(graph: Any, tmp_path: Path) -> None:
    found = proofs_of(made(graph)[0], tmp_path)
    assert len(found) >= 3
    for name, (proved, goals) in found.items():
        assert (proved, goals) == (goals, goals), name


@pytest.mark.exhaustive
def test_the_digital_half_of_the_calibration_is_proved_equal_to_python(tmp_path: Path) -> None:
    machine, _ = made(read_graph(library_file("self_calibration_fixed.toml")), clocks=1)
    for name, (proved, goals) in proofs_of(machine, tmp_path).items():
        assert proved == goals > 0, name


@pytest.mark.exhaustive
def test_another_operation_is_refuted(tmp_path: Path) -> None:
    found = proofs_of(made(loop_at_rates())[0], tmp_path, "self.first - self.second", "self.first + self.second")
    proved, goals = found["fixed_difference"]
    assert proved < goals


class State(NamedTuple):
    m: int


class Toggle(Block):
    """A state whose name the class has another use for."""


@Toggle.output("1")
def enabled(p: Toggle, x: State) -> int:
    """The last bit."""
    return x.m


@Toggle.update
def update(p: Toggle, x: State) -> State:
    return State(1 - x.m)


def test_names_of_the_class_itself_are_kept_free(tmp_path: Path) -> None:
    graph = Graph(name="g", rate=1, samples=3, blocks={"a": Toggle()}, wires=[], probes=["a.enabled"])
    machine, _ = made(graph)
    (text,) = amaranth_files(machine).values()
    assert 'm_ = Signal(1, name="m", init=0)  # x.m (1, 0) unsigned' in text
    ((proved, goals),) = proofs_of(machine, tmp_path).values()
    assert proved == goals > 0


def test_lines_tell_their_python_and_the_command_writes_them(tmp_path: Path) -> None:
    words = ["rtl", str(library_file("self_calibration_fixed.toml")), "--block", "stiffness", "--ticks", "1"]
    assert main([*words, "-o", str(tmp_path), "--amaranth"]) == 0
    text = (tmp_path / "fixed_stiffness_controller_amaranth.py").read_text(encoding="utf-8")
    assert "class FixedStiffnessController(Elaboratable):" in text
    assert "self.measured = Signal(signed(16))  # (16, 12) V: Response y of the device." in text
    lines = [line for line in text.splitlines() if "m.d.comb += " in line and "self.stiffness" not in line]
    assert lines
    assert all("fixed_stiffness_controller.py:" in line for line in lines)
