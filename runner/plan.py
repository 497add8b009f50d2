"""From a graph to the plan that both engines read: checked, flat, scheduled, with constants, starts and solvers."""

import math
from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declare import Block
from proofmass.blocks.fixed_point import FixedValue
from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.check import checked
from proofmass.graphs.flatten import flatten
from proofmass.graphs.graph import Graph, split
from proofmass.graphs.schedule import Node, schedule
from proofmass.runner.constants import constants_of, start_of
from proofmass.runner.digital import DigitalBlock, digital_block
from proofmass.runner.interpret import Interpreter
from proofmass.runner.planned import Plan, PlannedProbe
from proofmass.runner.recording import read_recordings
from proofmass.runner.solvers import find_solvers
from proofmass.runner.step_formats import held_as

__all__ = ["Plan", "PlannedProbe", "plan"]


def plan(graph: Graph) -> Plan:
    """Check, schedule and prepare a graph; raises `ModelError`."""
    probed = graph.probes  # as they are named there
    graph = flatten(checked(graph))
    scheduled = schedule(graph)
    made = Plan(graph, scheduled, {}, {}, {}, (), (), {})  # answers what follows from the schedule alone
    constants, starts, problems = dict[str, Any](), dict[str, Any](), list[Problem]()
    buffers: dict[Node, tuple[float, ...]] = {}
    as_set: dict[str, Any] = {}  # of blocks with driven parameters too
    digital: dict[str, DigitalBlock] = {}
    for name, block in graph.blocks.items():
        driven = any((name, p) in scheduled.drivers for p in block.parameters)
        try:
            if block.digital():
                prepared = digital[name] = digital_block(name, block, made.block_period(name))
                constants[name], starts[name] = prepared.constants, prepared.start
                buffers |= {(name, b): values for b, values in prepared.buffers.items()}
                continue
            as_set[name] = constants_of(block, block, made.block_period(name))
            constants[name] = None if driven else as_set[name]
            if not all(map(math.isfinite, as_set[name] or ())):
                raise ArithmeticError("one of them is not finite")
            recorded = read_recordings(graph, name)
            filled = {b: recorded.get(b) or _zeros(block, b) for b in block.buffers}
            starts[name] = start_of(block, filled)
        except ModelError as error:
            problems += error.problems
        except (ArithmeticError, ValueError) as error:
            problems.append(
                Problem(
                    message=f"its constants cannot be computed: {error}",
                    key=f"blocks.{name}",
                    got=repr(block),
                    hint="take a wider format, or a smaller parameter"
                    if block.digital()
                    else "look for a parameter many orders of magnitude off",
                    path=("blocks", name),
                )
            )
        else:
            buffers |= {(name, b): tuple(values) for b, values in filled.items()}
    if problems:
        raise ModelError([graph.placed(problem) for problem in problems])
    ready = Plan(graph, scheduled, constants, starts, buffers, (), (), digital)
    solvers = find_solvers(ready, as_set, lambda: _first_tick(ready))
    buffers |= {solver.largest: (0.0,) * len(solver.group.states) for solver in solvers if solver.tolerance}
    named = sorted(zip(probed, graph.probes, strict=True))
    probes = tuple(_probe(made, probe.signal, split(inner.signal), probe.every) for probe, inner in named)
    return Plan(graph, scheduled, constants, starts, buffers, solvers, probes, digital)


def _first_tick(ready: Plan) -> tuple[Mapping[str, Any], Mapping[Node, Any]]:
    """Constants and wires of tick 0, about which the continuous groups are linearised."""
    return Interpreter(ready, ready.graph.seed).first_tick()


def _zeros(block: Block, buffer: str) -> list[float]:
    declared = block.buffers[buffer]
    zero = 0 if held_as(declared.dtype) is int else 0.0
    return [zero] * math.prod(block.shape_of(declared))


def _probe(made: Plan, signal: str, node: Node, every: int) -> PlannedProbe:
    block = made.blocks[node[0]]
    port = block.outputs[node[1]]
    return PlannedProbe(
        signal,
        node,
        made.stride(node) * every,
        held_as(port.dtype),
        block.shape_of(port),
        block.unit_of(port),
        port.doc,
        block.format_of(port.name) if port.dtype is FixedValue else None,
    )
