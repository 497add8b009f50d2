"""The bench for cocotb: that it is Python, where bits of ports stand, and how it reads bits that are not known."""

import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from proofmass.blocks import ShiftRegister
from proofmass.graphs.model.build import Graph
from proofmass.runner.rtl.bench.bench import bench_files
from proofmass.runner.rtl.bench.cocotb_bench import cocotb_files
from proofmass.runner.rtl.text.machine_verilog import machine_text
from tests.by_hand.machines import loop_at_rates, made

_ASK = """\
import json, sys
from unittest.mock import MagicMock
cocotb = MagicMock()
cocotb.test = lambda: lambda function: function
sys.modules |= {"cocotb": cocotb, "cocotb.triggers": cocotb}
import top_cocotb as bench
error = bench.OUTPUTS[1]
lines = bench.lines("top_outputs.hex")
numbers = [error.number(f"{error.bits(line):0{error.width}b}") for line in lines]
print(json.dumps([[list(port) for port in bench.OUTPUTS], numbers, error.number("x0x")]))
"""


def test_ports_are_where_the_vectors_have_them(tmp_path: Path) -> None:
    machine, vectors = made(loop_at_rates())
    for name, text in {**bench_files(machine, vectors), **cocotb_files(machine, vectors.clocks)}.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    said = subprocess.run([sys.executable, "-c", _ASK], cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    found: list[Any] = json.loads(said)
    assert found[0] == [["integrator_output", 0, 16, True], ["error_output", 16, 17, True]]
    assert found[1] == vectors.outputs["error_output"].tolist()
    assert found[2] == "x0x"


def test_it_runs_by_itself_where_cocotb_is(tmp_path: Path) -> None:
    pytest.importorskip("cocotb")
    if shutil.which("iverilog") is None:
        pytest.skip("Icarus Verilog is not installed")
    graph = Graph(name="g", rate=1, samples=50, blocks={"a": ShiftRegister()}, wires=[], probes=["a.bit"])
    machine, vectors = made(graph)
    files = {**bench_files(machine, vectors), **cocotb_files(machine, vectors.clocks)}
    files["shift_register.v"] = machine_text(machine)
    for changed, code in ((False, 0), (True, 1)):
        for name, text in files.items():
            written = text.replace("10'd1023", "10'd1") if changed else text
            (tmp_path / name).write_text(written, encoding="utf-8")
        ended = subprocess.run(
            [sys.executable, "shift_register_cocotb.py"], cwd=tmp_path, check=False, capture_output=True, text=True
        )
        assert ended.returncode == code
        assert ("FAIL: " if changed else "PASS: 50 clocks") in ended.stdout
