"""A block on its stimuli in four ways: plain Python, the compiled loop, CXXRTL, Icarus Verilog.

Seconds are those of the processor, so that others may share the machine, but for Icarus.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from time import process_time
from typing import Any, NamedTuple

import numpy as np
from rtl_stimuli import GIVEN, TESTED, Column

from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.rtl.bench.bench import bench_files
from proofmass.runner.rtl.bench.simulators import Played, play
from proofmass.runner.rtl.bench.vectors import Vectors
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.reference import reference_of
from proofmass.runner.rtl.model.cxxrtl import VerilogModel
from proofmass.runner.rtl.text.machine_verilog import machine_text, top_name
from proofmass.runner.run.engines import make_engine

TRIALS = 5  # of which the fastest counts


class Found(NamedTuple):
    """Outputs of each clock by port; registers after the last by what Python calls them, where they are seen."""

    outputs: Mapping[str, Column]
    registers: Mapping[str, int]
    seconds: float


def by_python(
    planned: Plan, machine: Machine, columns: Mapping[str, Column], clocks: int
) -> tuple[Found, dict[str, int]]:
    """The functions of the block alone, interpreted; and in how many clocks each register changed."""
    alone = _without_sources(planned)
    engine, rows, readers = (
        make_engine(alone, "python", 0, 0, start(alone), clocks),
        _rows(alone, clocks),
        _readers(machine),
    )
    memory = engine.memory()
    kinds = {name: held_as(port.dtype) for name, port in type(alone.blocks[TESTED]).inputs.items()}
    inputs = [(alone.schedule.drivers[TESTED, n], list(map(kind, columns[n].tolist()))) for n, kind in kinds.items()]
    probed = list(zip(alone.probes, rows, strict=True))
    values = [read(memory) for read in readers.values()]
    changes = [0] * len(values)
    began = process_time()
    for clock in range(clocks):
        for node, column in inputs:
            memory.wires[node] = column[clock]
        engine.advance(clock + 1, [each[probe.rows(0, clock) :] for probe, each in probed])
        following = [read(memory) for read in readers.values()]
        for i, value in enumerate(following):
            changes[i] += value != values[i]
        values = following
    seconds = process_time() - began
    outcome = Found(_outputs(alone, machine, rows, clocks), dict(zip(readers, values, strict=True)), seconds)
    return outcome, dict(zip(readers, changes, strict=True))


def _without_sources(planned: Plan) -> Plan:
    """The plan of the block alone: what its wires carry is written there clock by clock."""
    order = [node for node in planned.schedule.order if node[0] == TESTED]
    return replace(
        planned,
        schedule=replace(planned.schedule, order=order),
        blocks={TESTED: planned.blocks[TESTED]},
        buffers={node: held for node, held in planned.buffers.items() if node[0] == TESTED},
    )


def by_compiled_loop(planned: Plan, machine: Machine, clocks: int) -> Found:
    """The graph as one loop."""

    def run() -> Found:
        engine, rows = make_engine(planned, "compiled", 0, 0, start(planned), LARGEST_RUN), _rows(planned, clocks)
        began = process_time()
        engine.advance(clocks, rows)
        seconds = process_time() - began
        registers = {text: read(engine.memory()) for text, read in _readers(machine).items()}
        return Found(_outputs(planned, machine, rows, clocks), registers, seconds)

    return _fastest(run)


def by_model(planned: Plan, machine: Machine, columns: Mapping[str, Column], clocks: int) -> Found:
    """The Verilog compiled, its outputs alone; where it has pipeline cuts the run is longer by their ticks."""
    late = machine.latency
    inputs = {name: np.pad(column, (0, late), "edge") for name, column in _inputs(machine, columns).items()}
    text = machine_text(machine)

    def run() -> Found:
        model = VerilogModel(reference_of(planned, machine), text)
        began = process_time()
        outputs = model.run(inputs, clocks + late)
        seconds = process_time() - began
        return Found({name: column[late:] for name, column in outputs.items()}, {}, seconds)

    return _fastest(run)


def by_icarus(machine: Machine, columns: Mapping[str, Column], expected: Found) -> Played:
    """The self-checking bench, by the clock on the wall; raises `ModelError` where it cannot be played."""
    clocks = len(next(iter(expected.outputs.values())))
    files = bench_files(machine, Vectors(clocks, _inputs(machine, columns), expected.outputs))
    return play("icarus", machine, {f"{top_name(machine)}.v": machine_text(machine), **files})


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
    columns = {}
    for port in machine.outputs:
        signal, _, entry = port.text.removesuffix("]").partition("[")
        columns[port.name] = wires[signal][:, int(entry)] if entry else wires[signal]
    return columns


def _readers(machine: Machine) -> dict[str, Callable[[Memory], int]]:
    """What reads a register of the block, by what Python calls it."""
    return {register.text: _reader(register.text) for register in machine.modules[0].registers}


def _reader(text: str) -> Callable[[Memory], int]:
    buffer, _, entry = text.removesuffix("]").partition("[")
    if entry:
        place = int(entry)
        return lambda memory: int(memory.buffers[TESTED, buffer][place])
    field = text.removeprefix("x.")
    return lambda memory: int(getattr(memory.states[TESTED], field))
