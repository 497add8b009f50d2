"""CPU seconds from a plan to machine code, beside gcc -O3 for the same program: `python benchmarks/compile.py`.

Each graph of the library in a process that has lowered nothing before; then all of them in one process; then chains of
blocks. The parts: writing the program (lowering included), printing it for LLVM, LLVM's passes, the object file.

`--short` prints what optimising takes and gains beside code of short runs, and from which run on it pays.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from bisect import bisect_left
from collections.abc import Callable
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm

from proofmass import Graph, read_graph
from proofmass.blocks import Constant, Gain, Saturation, UnitDelay
from proofmass.graphs.files.library import library_file, library_files
from proofmass.graphs.model.exports import runs_alone
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.program.tick import write_tick
from proofmass.runner.run.estimates import is_short
from proofmass.runner.targets import machine_code
from proofmass.runner.targets.c99 import c99_text
from proofmass.runner.targets.llvm_text import llvm_text
from proofmass.runner.targets.machine_code import QUICK
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan, settings

PARTS = ("plan", "write", "print", "parse", "passes", "emit")
_LONG = 0.02  # seconds of ticks that are timed


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="graphs of the library, or chain_N; all when none is named")
    parser.add_argument("--gcc", action="store_true", help="compile the C of each as well")
    parser.add_argument("--one", action="store_true", help="measure one graph in this process, as JSON")
    parser.add_argument("--short", action="store_true", help="what optimising takes and gains")
    parser.add_argument("--chains", type=int, nargs="*", default=[], metavar="BLOCKS")
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps([measured(graph_of(name), arguments.gcc) for name in arguments.names]))
        return
    names = arguments.names or library()
    if arguments.short:
        print(f"{'graph':34} {'optimising':>11} {'in a tick':>11} {'pays from':>13} {'is taken from':>14}")
        for name in names:
            optimised(name, plan(graph_of(name).changed(probes=())))
        return
    print(f"{'graph':34} {'blocks':>6} {'lines':>7} " + " ".join(f"{part:>7}" for part in (*PARTS, "sum", "gcc")))
    for name in names:
        show(name, alone([name], arguments.gcc)[0])
    if not arguments.names:
        together = alone(names, False)
        show("all in one process", {key: sum(row[key] for row in together) for key in together[0]})
    for blocks in arguments.chains:
        show(f"chain_{blocks}", alone([f"chain_{blocks}"], arguments.gcc)[0])


def library() -> list[str]:
    """Names of the graphs that run alone."""
    paths = (path for path in library_files().values() if path.suffix == ".toml")
    graphs = [path for path in paths if "[blocks" in path.read_text(encoding="utf-8")]
    return [path.stem for path in graphs if runs_alone(flatten(read_graph(path)))]


def graph_of(name: str) -> Graph:
    """A graph of the library, or a chain of blocks one behind the other."""
    if not name.startswith("chain_"):
        return read_graph(library_file(f"{name}.toml"))
    count = int(name.removeprefix("chain_"))
    blocks: dict[str, Any] = {"source": Constant(value=1.0)}
    wires, before = [], "source.output"
    for number in range(count - 1):
        kinds = Gain(gain=1.0 - 1e-6 * number), UnitDelay(), Saturation(lowest=-1e3, highest=1e3)
        blocks[f"block_{number}"] = kinds[number % len(kinds)]
        wires.append(f"{before} -> block_{number}.input")
        before = f"block_{number}.output"
    return Graph(name=name, rate="10 kHz", samples=10, blocks=blocks, wires=wires, probes=[before])


def alone(names: list[str], gcc: bool) -> list[dict[str, float]]:
    """What is measured in a fresh process."""
    command = [sys.executable, __file__, "--one", *(["--gcc"] if gcc else []), *names]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True, env=os.environ)
    rows: list[dict[str, float]] = json.loads(done.stdout)
    return rows


def measured(graph: Graph, gcc: bool) -> dict[str, float]:
    """CPU seconds of each part."""
    row: dict[str, float] = {"blocks": 0, "lines": 0}
    clock = time.process_time()

    def note(part: str) -> None:
        nonlocal clock
        now = time.process_time()
        row[part], clock = now - clock, now

    planned = plan(graph)
    note("plan")
    written = write_tick(planned)
    note("write")
    text, told = llvm_text(written.program), settings(written)
    note("print")
    machine = machine_code.machine_of(told)
    module = llvm.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    note("parse")
    machine_code.optimise(module, machine, told)
    note("passes")
    machine.emit_object(module)
    note("emit")
    row |= {"blocks": len(planned.blocks), "lines": text.count("\n")}
    row["sum"] = sum(row[part] for part in PARTS[1:])
    row["gcc"] = of_gcc(c99_text(written.program)) if gcc else 0.0
    return row


def optimised(name: str, planned: Plan) -> None:
    """Print what optimising the machine code of a plan takes and gains, and for which ticks it is done."""
    written, found = write_tick(planned), []
    for told in (settings(written), QUICK):
        clock = time.process_time()
        machine_code.object_code(llvm_text(written.program), told)
        compiling = time.process_time() - clock
        compiled = CompiledPlan(planned, written, machine_code.load(written.program, told))
        found.append((compiling, min(_tick(planned, compiled) for _ in range(3))))
    (longer, tick), (quick, slow) = found
    pays, taken = (longer - quick) / max(slow - tick, 1e-12), bisect_left(range(LARGEST_RUN), True, key=_taken(planned))
    print(
        f"{name:34} {1e3 * (longer - quick):8.0f} ms {1e9 * (slow - tick):8.0f} ns {pays:13,.0f} {taken:14,}",
        flush=True,
    )


def _taken(planned: Plan) -> Callable[[int], bool]:
    return lambda ticks: not is_short(planned, ticks)


def _tick(planned: Plan, compiled: CompiledPlan) -> float:
    """CPU seconds of a tick."""
    loop, ticks = CompiledLoop(planned, 0, 0, None, compiled), 1_000
    while True:
        clock, first = time.process_time(), loop.tick
        loop.advance(first + ticks, ())
        spent = time.process_time() - clock
        if spent > _LONG:
            return spent / ticks
        ticks *= 4


def of_gcc(text: str) -> float:
    """CPU seconds of gcc -O3."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.c"
        file.write_text(text)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = ["gcc", "-O3", "-march=native", "-std=c99", "-ffp-contract=off", "-c", str(file), "-o", f"{folder}/o"]
        subprocess.run(command, check=True)
        behind = resource.getrusage(resource.RUSAGE_CHILDREN)
    return behind.ru_utime + behind.ru_stime - before.ru_utime - before.ru_stime


def show(name: str, row: dict[str, float]) -> None:
    """A line of the table."""
    numbers = " ".join(f"{row[part]:7.2f}" for part in (*PARTS, "sum", "gcc"))
    print(f"{name:34} {row['blocks']:6.0f} {row['lines']:7.0f} {numbers}", flush=True)


if __name__ == "__main__":
    main()
