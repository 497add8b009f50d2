"""Every block that becomes hardware on vectors at random: plain Python = compiled loop = CXXRTL = Icarus Verilog.

    python benchmarks/rtl_vectors.py [vectors] [block ...]

Blocks are named by their kind, or by their name in the table; without names all run, and after them every angle of 20
bits through the pipelined exponential, which is `exponential`. All outputs are compared in every clock, registers of
the compiled loop after the last. A row has the milliseconds from the functions to Verilog, the fewest of several, and
clocks a second, of processor time but for Icarus; those of the compiled loop are with what plays the vectors. Below it
stand the clocks in which outputs and registers changed. What differs, is slow or never changes is listed at the end;
the exit code is 1 then.
"""

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import groupby
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np
from rtl_blocks import Alone, blocks_alone
from rtl_stimuli import TESTED, Column, drawn, played
from rtl_ways import TRIALS, Found, by_compiled_loop, by_icarus, by_model, by_python

from proofmass.blocks import FixedCordicExponential, FixedCordicExponentialPipeline
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.rtl.machine.compose import compose
from proofmass.runner.rtl.machine.modules import Module
from proofmass.runner.rtl.text.machine_verilog import machine_text
from proofmass.runner.rtl.tools import programs

VECTORS = 100_000
LONGEST = 100.0  # milliseconds from the functions of a block to its Verilog
SLOWEST = 1e6  # clocks a second of a model
WAYS = ("Python", "compiled", "CXXRTL", "Icarus")
ANGLES = 1 << 20
SLOT = "a slot is longer than the stretches of stimuli"
STILL = {  # blocks of which some outputs and registers may never change, and why
    "quartz_calibration.switch_slots": SLOT,
    "quartz_calibration.test_slots": SLOT,
    "quartz_calibration_disturbed.sensor.switch_slots": SLOT,
    "quartz_calibration_disturbed.sensor.test_slots": SLOT,
    "quartz_recalibration.switch_slots": SLOT,
    "quartz_recalibration.sequencer": "it begins behind the drift",
}


@dataclass
class Row:
    """A row of the table."""

    name: str
    formats: str
    milliseconds: float = 0.0
    speeds: dict[str, float] = field(default_factory=dict)  # clocks a second
    notes: list[str] = field(default_factory=list)
    misses: list[str] = field(default_factory=list)
    changes: dict[str, int] = field(default_factory=dict)

    def __str__(self) -> str:
        speeds = " ".join(f"{f'{self.speeds[way]:,.0f}' if way in self.speeds else '-':>11}" for way in WAYS)
        verdict = "; ".join([*(self.misses or ["equal"]), *self.notes])
        return f"{self.milliseconds:6.1f} {speeds}  {self.name}: {self.formats}: {verdict}\n{'':8}{self._changes()}"

    def _changes(self) -> str:
        """Entries of a vector together."""
        texts = []
        for name, group in groupby(self.changes.items(), lambda each: each[0].partition("[")[0]):
            counts = [count for _, count in group]
            entries = f"[{len(counts)}]" if len(counts) > 1 else ""
            texts.append(f"{name}{entries} {min(counts):,}" + (f" to {max(counts):,}" if entries else ""))
        return ", ".join(texts)


def main() -> int:
    """Print the rows as they come; whether anything was missed."""
    numbers = [argument for argument in sys.argv[1:] if argument.isdigit()]
    vectors, names = int(numbers[0]) if numbers else VECTORS, {*sys.argv[1:]} - {*numbers}
    print(f"{vectors:,} vectors for each block")
    print(f"{'ms':>6} " + " ".join(f"{way:>11}" for way in WAYS), flush=True)
    misses = []
    for row in rows(vectors, names):
        print(row, flush=True)
        misses += [f"{row.name}: {miss}" for miss in row.misses]
    print("missed:" if misses else "nothing missed", *misses, sep="\n")
    return bool(misses)


def rows(vectors: int, names: set[str]) -> Iterator[Row]:
    """Of the blocks that are named, or of all."""
    for alone in blocks_alone():
        if not names or names & {alone.kind, alone.name}:
            yield compared(alone, drawn(alone.block, vectors), vectors)
    if not names or "exponential" in names:
        yield exponential()


def compared(alone: Alone, columns: Mapping[str, Column], clocks: int) -> Row:
    """A block run in all ways."""
    with TemporaryDirectory() as name:
        graph = played(alone.block, alone.rate, columns, Path(name))
        planned = plan(graph, wide=True)
        machine = compose(planned, [TESTED])
        expected, changes = by_python(planned, machine, columns, clocks)
        row = Row(alone.name, formats(machine.modules[0]), min(milliseconds(planned) for _ in range(TRIALS)))
        row.speeds["Python"] = clocks / expected.seconds
        _compare(row, "CXXRTL", by_model(planned, machine, columns, clocks), expected)
        try:
            _compare(row, "compiled", by_compiled_loop(plan(graph), machine, clocks), expected)
        except ModelError as error:
            row.notes.append(f"not compiled: {error.problems[0].got}")
        if programs.found("iverilog"):
            bench = by_icarus(machine, columns, expected)
            row.speeds["Icarus"] = clocks / bench.seconds
            if not bench.passed or bench.clocks != clocks:
                row.misses.append(str(bench))
    texts = {port.name: port.text.removeprefix(f"{TESTED}.") for port in machine.outputs}
    moved = {texts[name]: int(np.count_nonzero(np.diff(column))) for name, column in expected.outputs.items()}
    row.changes = moved | changes
    _judge(row, alone)
    return row


def exponential() -> Row:
    """Every angle through the pipelined exponential, and by how many ticks it is behind the one without stages."""
    later, now = FixedCordicExponentialPipeline(fraction_bits=20), FixedCordicExponential(fraction_bits=20)
    clocks = ANGLES + 64
    columns = {"angle": np.arange(clocks) % ANGLES}
    row = compared(Alone(later, Fraction(1000), "exponential"), columns, clocks)
    outputs = []
    for block in (now, later):
        with TemporaryDirectory() as name:
            planned = plan(played(block, Fraction(1000), columns, Path(name)))
            outputs.append(by_model(planned, compose(planned, [TESTED]), columns, clocks).outputs["exponential"])
    at = (n for n in range(64) if np.array_equal(outputs[0][:ANGLES], outputs[1][n : n + ANGLES]))
    late = next(at, None)
    row.notes.append(f"{ANGLES:,} angles {late} ticks later than without stages")
    if late is None:
        row.misses.append("differs from the one without stages")
    return row


def milliseconds(planned: Plan) -> float:
    """Time of the processor from the functions of the block to its Verilog."""
    began = process_time()
    machine_text(compose(planned, [TESTED]))
    return 1e3 * (process_time() - began)


def formats(module: Module) -> str:
    """Formats of the inputs and of the outputs, each once."""
    sides = ({str(port.word): None for port in ports} for ports in (module.inputs, module.outputs))
    return " -> ".join(", ".join(side) or "nothing" for side in sides)


def _compare(row: Row, way: str, outcome: Found, expected: Found) -> None:
    row.speeds[way] = len(next(iter(outcome.outputs.values()))) / outcome.seconds
    for name, column in expected.outputs.items():
        different = np.flatnonzero(outcome.outputs[name] != column)
        if len(different):
            row.misses.append(f"{way}: {name} DIFFERS in {len(different):,} clocks, first in {different[0]}")
    wrong = [name for name, value in outcome.registers.items() if value != expected.registers[name]]
    if wrong:
        row.misses.append(f"{way}: registers DIFFER at the end: {', '.join(wrong)}")


def _judge(row: Row, alone: Alone) -> None:
    """Note what was slow or stood still."""
    if row.milliseconds > LONGEST:
        row.misses.append(f"{row.milliseconds:.0f} ms to Verilog")
    if row.speeds["CXXRTL"] < SLOWEST:
        row.misses.append(f"CXXRTL at {row.speeds['CXXRTL']:,.0f} clocks a second")
    still = ", ".join(name for name, count in row.changes.items() if not count)
    why = STILL.get(alone.name, "")
    if not type(alone.block).inputs and "update" not in type(alone.block).functions:
        why = "they are constants"
    if still:
        (row.notes if why else row.misses).append(f"never changing: {still}" + f", as {why}" * bool(why))


if __name__ == "__main__":
    sys.exit(main())
