"""A block on its stimuli in four ways: plain Python, the compiled loop, CXXRTL, Icarus Verilog."""

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from rtl_stimuli import GIVEN, TESTED, Column

from proofmass.runner.engine.engines import make_engine
from proofmass.runner.engine.memory import Memory, start
from proofmass.runner.engine.planned import Plan
from proofmass.runner.rtl.bench import bench_files
from proofmass.runner.rtl.cxxrtl import Model
from proofmass.runner.rtl.machine import Machine
from proofmass.runner.rtl.machine_verilog import machine_text
from proofmass.runner.rtl.reference import reference_of
from proofmass.runner.rtl.vectors import Vectors

TRIALS = 5  # of which the fastest counts, since others may share the machine


class Found(NamedTuple):
    """Outputs of each clock by the names of the ports; registers after the last, by what Python calls them."""

    outputs: Mapping[str, Column]
    registers: Mapping[str, int]
    seconds: float


def by_python(planned: Plan, machine: Machine, clocks: int) -> tuple[Found, dict[str, int]]:
    """The functions of the block, interpreted; and in how many clocks each register changed."""
    engine = make_engine(planned, "python", 0, 0, start(planned))
    rows = _rows(planned, clocks)
    probed = list(zip(planned.probes, rows, strict=True))
    held = _registers(machine, engine.memory())
    changes = dict.fromkeys(held, 0)
    seconds = 0.0
    for clock in range(clocks):
        began = perf_counter()
        engine.advance(clock + 1, [each[probe.rows(0, clock) :] for probe, each in probed])
        seconds += perf_counter() - began
        following = _registers(machine, engine.memory())
        for name, value in following.items():
            changes[name] += value != held[name]
        held = following
    return Found(_outputs(planned, machine, rows, clocks), held, seconds), changes


def by_compiled_loop(planned: Plan, machine: Machine, clocks: int) -> Found:
    """The graph as one loop."""

    def run() -> Found:
        engine, rows = make_engine(planned, "compiled", 0, 0, start(planned)), _rows(planned, clocks)
        began = perf_counter()
        engine.advance(clocks, rows)
        seconds = perf_counter() - began
        return Found(_outputs(planned, machine, rows, clocks), _registers(machine, engine.memory()), seconds)

    return _fastest(run)


def by_model(planned: Plan, machine: Machine, columns: Mapping[str, Column], clocks: int) -> Found:
    """The Verilog compiled; behind pipeline cuts the run is longer by their ticks, and its registers are ahead."""
    late = machine.latency
    inputs = {name: np.pad(column, (0, late), "edge") for name, column in _inputs(machine, columns).items()}
    text = machine_text(machine)

    def run() -> Found:
        model = Model(reference_of(planned, machine), text)
        began = perf_counter()
        outputs = model.run(inputs, clocks + late)
        seconds = perf_counter() - began
        held = dict(zip((each.text.removeprefix(f"{TESTED}.") for each in model.registers), model.held, strict=True))
        registers = {} if late else {each.text: held[each.text] for each in machine.modules[0].registers}
        return Found({name: column[late:] for name, column in outputs.items()}, registers, seconds)

    return _fastest(run)


def by_icarus(machine: Machine, columns: Mapping[str, Column], expected: Found, folder: Path) -> tuple[str, float]:
    """What the self-checking bench ends with, and the seconds of its run."""
    clocks = len(next(iter(expected.outputs.values())))
    files = bench_files(machine, Vectors(clocks, _inputs(machine, columns), expected.outputs))
    files["machine.v"] = machine_text(machine)
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    sources = [name for name in files if name.endswith(".v")]
    subprocess.run(["iverilog", "-g2001", "-o", "bench", *sources], cwd=folder, check=True)
    began = perf_counter()
    ended = subprocess.run(["vvp", "-n", "bench"], cwd=folder, check=True, capture_output=True, text=True)
    return ended.stdout.splitlines()[-1], perf_counter() - began


def has_icarus() -> bool:
    """Whether Icarus Verilog is installed."""
    return shutil.which("iverilog") is not None


def _fastest(run: Callable[[], Found]) -> Found:
    return min((run() for _ in range(TRIALS)), key=lambda found: found.seconds)


def _rows(planned: Plan, clocks: int) -> list[Any]:
    return [np.zeros((probe.rows(0, clocks), *probe.shape), probe.dtype) for probe in planned.probes]


def _inputs(machine: Machine, columns: Mapping[str, Column]) -> dict[str, Column]:
    """Columns by port, from those by the names of the block's inputs."""
    return {port.name: columns[port.text.partition(".")[0].removeprefix(GIVEN)] for port in machine.inputs}


def _outputs(planned: Plan, machine: Machine, rows: list[Any], clocks: int) -> dict[str, Column]:
    """Columns by port: one for each entry of a vector; what comes once in several clocks stays in between."""
    wires = {
        probe.signal: np.repeat(values.astype(np.int64), probe.stride, axis=0)[:clocks]
        for probe, values in zip(planned.probes, rows, strict=True)
    }
    found = {}
    for port in machine.outputs:
        signal, _, entry = port.text.removesuffix("]").partition("[")
        found[port.name] = wires[signal][:, int(entry)] if entry else wires[signal]
    return found


def _registers(machine: Machine, memory: Memory) -> dict[str, int]:
    return dict(_held(machine, memory))


def _held(machine: Machine, memory: Memory) -> Iterator[tuple[str, int]]:
    for register in machine.modules[0].registers:
        buffer, _, entry = register.text.removesuffix("]").partition("[")
        if entry:
            yield register.text, int(memory.buffers[TESTED, buffer][int(entry)])
        else:
            yield register.text, int(getattr(memory.states[TESTED], register.text.removeprefix("x.")))
