"""The test bench as a module for cocotb 2 that plays the same vectors: a start for one's own benches in Python.

Run it by `python NAME_cocotb.py`, with Icarus Verilog or the simulator named by the variable SIM.
"""

from collections.abc import Iterator, Sequence
from string import Template

from proofmass.runner.rtl.bench.bench import SHOWN, places
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.words import VerilogPort
from proofmass.runner.rtl.text.machine_verilog import top_name

_TEXT = Template('''\
"""Test bench of $name in cocotb 2: python ${name}_cocotb.py, with SIM=verilator for another simulator than Icarus."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import cocotb
from cocotb.triggers import Timer

NAME = "$name"
FOLDER = Path(__file__).parent
CLOCKS = $clocks
LATENCY = $latency  # clocks from an input to its outputs


class Port(NamedTuple):
    """A port, and where its bits stand in a line of vectors."""

    name: str
    lowest: int
    width: int
    signed: bool

    def bits(self, line: str) -> int:
        return (int(line, 16) >> self.lowest) & ((1 << self.width) - 1)

    def number(self, bits: str) -> int | str:
        """What bits such as "0110" say; those that are not known stay as they are."""
        if set(bits) - set("01"):
            return bits
        return int(bits, 2) - (1 << self.width if self.signed and bits[0] == "1" else 0)


INPUTS = [$inputs]
OUTPUTS = [$outputs]


def lines(name: str) -> list[str]:
    """The vectors in a file, a line a clock."""
    return (FOLDER / name).read_text(encoding="utf-8").split()


async def edge(dut: Any) -> None:
    """One rising edge of the clock, and half a period."""
    $edge


async def start(dut: Any) -> None:
    """Registers at their starts, enabled in every clock from then on."""
    $start


def differences(dut: Any, line: str) -> Iterator[str]:
    """What outputs are other than a line of vectors says."""
    for port in OUTPUTS:
        got, expected = str(getattr(dut, port.name).value), f"{port.bits(line):0{port.width}b}"
        if got != expected:
            yield f"{port.name} is {port.number(got)}, not {port.number(expected)}"


@cocotb.test()
async def outputs_are_those_of_the_simulation(dut: Any) -> None:
    applied, expected = $stimuli, lines(f"{NAME}_outputs.hex")
    wrong = 0
    await start(dut)
    for n in range(CLOCKS + LATENCY):
        if n < CLOCKS:
            for port in INPUTS:
                getattr(dut, port.name).value = port.bits(applied[n])
        await Timer(4, "ns")
        for difference in differences(dut, expected[n - LATENCY]) if n >= LATENCY else ():
            wrong += 1
            if wrong <= $shown:
                print(f"clock {n}: {difference}", flush=True)
        await edge(dut)
    print(f"FAIL: {wrong} differences in {CLOCKS} clocks" if wrong else f"PASS: {CLOCKS} clocks", flush=True)
    assert not wrong


if __name__ == "__main__":
    from cocotb_tools.runner import get_results, get_runner

    runner = get_runner(os.environ.get("SIM", "icarus"))
    runner.build(sources=[FOLDER / f"{NAME}.v"], hdl_toplevel=NAME, timescale=("1ns", "1ps"))
    tests, failed = get_results(runner.test(hdl_toplevel=NAME, test_module=Path(__file__).stem))
    sys.exit(1 if failed or not tests else 0)
''')
_EDGE = """await Timer(1, "ns")
    dut.clock.value = 1
    await Timer(5, "ns")
    dut.clock.value = 0"""
_START = """dut.clock.value, dut.reset.value, dut.enable.value = 0, 1, 1
    await Timer(4, "ns")
    await edge(dut)
    dut.reset.value = 0"""


def cocotb_name(name: str) -> str:
    """The file of the bench of the module `name`."""
    return f"{name}_cocotb.py"


def cocotb_files(machine: Machine, clocks: int) -> dict[str, str]:
    """The file of the bench by its name; it reads the vectors of the bench in Verilog."""
    name = top_name(machine)
    text = _TEXT.substitute(
        name=name,
        clocks=clocks,
        latency=machine.latency,
        inputs=", ".join(_ports(machine.inputs)),
        outputs=", ".join(_ports(machine.outputs)),
        stimuli='lines(f"{NAME}_inputs.hex")' if machine.inputs else "[]",
        edge=_EDGE if machine.clocked else 'await Timer(6, "ns")',
        start=_START if machine.clocked else 'await Timer(1, "ns")',
        shown=SHOWN,
    )
    return {cocotb_name(name): text}


def _ports(ports: Sequence[VerilogPort]) -> Iterator[str]:
    for port, low in places(ports):
        yield f'Port("{port.name}", {low}, {port.word.width}, {port.word.signed})'
