"""The self-checking test bench: its vectors, and that Icarus Verilog passes and fails it."""

import shutil
import subprocess
from pathlib import Path

import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.rtl.bench.bench import bench_files
from proofmass.runner.rtl.bench.vectors import Vectors
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.text.machine_verilog import machine_text
from tests.by_hand.machines import loop_at_rates, made
from tests.runner.rtl.text.test_machine_verilog import cut_graph

needs_icarus = pytest.mark.skipif(shutil.which("iverilog") is None, reason="Icarus Verilog is not installed")


def test_vectors_are_hexadecimal_words_the_first_port_lowest() -> None:
    machine, vectors = made(loop_at_rates())
    files = bench_files(machine, vectors)
    assert sorted(files) == ["top_bench.v", "top_inputs.hex", "top_outputs.hex"]
    inputs = files["top_inputs.hex"].split()
    assert [int(word, 16) for word in inputs] == [int(v) & 0xFFFF for v in vectors.inputs["quantiser_output"]]
    assert [port.name for port in machine.outputs] == ["integrator_output", "error_output"]
    assert all(len(word) == 9 for word in files["top_outputs.hex"].split())  # 16 and 17 bits
    both = [int(word, 16) for word in files["top_outputs.hex"].split()]
    assert [word & 0xFFFF for word in both] == [int(v) & 0xFFFF for v in vectors.outputs["integrator_output"]]
    assert [word >> 16 for word in both] == [int(v) & 0x1FFFF for v in vectors.outputs["error_output"]]


def test_a_machine_without_inputs_has_no_stimuli() -> None:
    from proofmass.blocks import ShiftRegister

    graph = Graph(name="g", rate=1, samples=50, blocks={"a": ShiftRegister()}, wires=[], probes=["a.bit"])
    files = bench_files(*made(graph))
    assert sorted(files) == ["shift_register_bench.v", "shift_register_outputs.hex"]
    assert "stimuli" not in files["shift_register_bench.v"]


def played(machine: Machine, vectors: Vectors, folder: Path) -> str:
    for name, text in {**bench_files(machine, vectors), "machine.v": machine_text(machine)}.items():
        (folder / name).write_text(text, encoding="utf-8")
    bench = next(folder.glob("*_bench.v")).name
    command = ["iverilog", "-g2001", "-o", "out", "machine.v", bench]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return subprocess.run(["vvp", "-n", "out"], cwd=folder, check=True, capture_output=True, text=True).stdout


@needs_icarus
@pytest.mark.parametrize(("graph", "clocks"), [(loop_at_rates(), 121), (cut_graph(1, 3), 101), (cut_graph(0, 0), 101)])
def test_icarus_finds_no_difference(graph: Graph, clocks: int, tmp_path: Path) -> None:
    assert played(*made(graph), tmp_path) == f"PASS: {clocks} clocks\n"


@needs_icarus
def test_icarus_finds_no_difference_in_the_self_calibration(tmp_path: Path) -> None:
    machine, vectors = made(read_graph(library_file("self_calibration_fixed.toml")), clocks=3000)
    assert played(machine, vectors, tmp_path) == "PASS: 3000 clocks\n"


@needs_icarus
def test_icarus_tells_differences(tmp_path: Path) -> None:
    machine, vectors = made(loop_at_rates())
    vectors.outputs["integrator_output"][9:40] += 1
    lines = played(machine, vectors, tmp_path).splitlines()
    value = int(vectors.outputs["integrator_output"][9])
    assert lines[0] == f"clock 9: integrator_output is {value - 1}, not {value}"
    assert lines[-1] == "FAIL: 31 differences in 121 clocks"
    assert len(lines) == 11
