"""Test vectors: values of the ports of a machine in every clock of a simulation of its graph."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from proofmass.blocks.declaration.instance import shape_of
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.host.arrays import Integers
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan, PlannedProbe
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.rtl.machine.machine import Machine
from proofmass.runner.rtl.machine.words import VerilogPort
from proofmass.runner.run.engines import choose, make_engine
from proofmass.runner.run.faults import RunError, failed, name_fault
from proofmass.runner.run.recorder import room

MOST_CLOCKS = 10_000  # by default


@dataclass(frozen=True)
class Vectors:
    """Integers of each port in each clock, by the names of the ports."""

    clocks: int
    inputs: Mapping[str, Integers]
    outputs: Mapping[str, Integers]


def simulated(planned: Plan, machine: Machine, clocks: int | None = None) -> Vectors:
    """Return vectors of so many clocks, or of the graph's duration, then at most `MOST_CLOCKS`.

    Raises `ModelError` where neither says how many, `RunError` where the simulation fails.
    """
    base = int(planned.schedule.base_rate / machine.rate)  # ticks in a clock
    if clocks is None:
        clocks = min(-(-planned.ticks() // base), MOST_CLOCKS)
    rows = _recorded(planned, {_node(port) for port in (*machine.inputs, *machine.outputs)}, base, clocks)
    return Vectors(clocks, dict(_columns(rows, machine.inputs)), dict(_columns(rows, machine.outputs)))


def _recorded(planned: Plan, nodes: Iterable[Endpoint], base: int, clocks: int) -> dict[Endpoint, Integers]:
    """Values of wires in each clock: integers, or rows of them if a wire carries a vector."""
    probes = tuple(_probe(planned, node, base) for node in sorted(nodes))
    recording = replace(planned, probes=probes)
    ticks, seed = clocks * base, planned.graph.seed
    rows = room(recording, 0, ticks)
    engine = make_engine(recording, choose(recording, ticks, "auto"), seed, 0, start(recording), ticks)
    try:
        if not engine.advance(ticks, rows):
            name_fault(recording, seed, 0, start(recording), ticks)
    except TickError as fault:
        raise RunError(failed(planned, fault)) from fault.__cause__
    at = np.arange(clocks) * base
    return {p.node: values[at // p.stride].astype(np.int64) for p, values in zip(probes, rows, strict=True)}


def _probe(planned: Plan, node: Endpoint, base: int) -> PlannedProbe:
    """Return a probe with one row a clock, if the wire has a value in each clock."""
    block = planned.blocks[node[0]]
    port = type(block).outputs[node[1]]
    stride = planned.stride(node)
    shape = shape_of(block, port)
    return PlannedProbe(
        ".".join(node), node, base if base % stride == 0 else stride, held_as(port.dtype), shape, "1", port.doc
    )


def _columns(rows: Mapping[Endpoint, Integers], ports: Iterable[VerilogPort]) -> Iterator[tuple[str, Integers]]:
    for port in ports:
        entry = port.text.partition("[")[2].rstrip("]")
        values = rows[_node(port)]
        yield port.name, values[:, int(entry)] if entry else values


def _node(port: VerilogPort) -> Endpoint:
    return split(port.text.partition("[")[0])
