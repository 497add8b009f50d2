"""Planning: a graph is checked, made flat, scheduled, given constants, states and solvers."""

import dataclasses
import math
import types
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import format_of, shape_of, unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.check import scheduled
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.derived import derived_measures
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.fixed.digital import DigitalBlock, digital_block
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.plan.constants import constants_of, start_of
from proofmass.runner.plan.keys import VectorOf
from proofmass.runner.plan.measuring import planned_measures, with_measures
from proofmass.runner.plan.planned import Driven, Filled, Plan, PlannedProbe, WiredPlan
from proofmass.runner.plan.recording import read_recordings
from proofmass.runner.planning.solvers import find_solvers
from proofmass.runner.reference.interpret import Outputs

__all__ = ["Plan", "PlannedProbe", "plan", "varied"]

Recordings = Mapping[str, Mapping[str, tuple[float, ...]]]
NO_RECORDINGS: Recordings = types.MappingProxyType({})


def plan(
    graph: GraphSource, *, wide: bool = False, recordings: Recordings = NO_RECORDINGS, free: Iterable[str] = ()
) -> Plan:
    """Check, schedule and prepare a graph; raises `ModelError`.

    With `wide` fixed-point blocks may have values of more than 64 bits, which the compiled engine
    cannot run. `recordings` are played in place of those in files, by block and buffer. Parameters
    that are `free`, by `"block.parameter"` of the flat graph, are those that `varied` may change.
    """
    graph = graph_from(graph)
    flat = flatten(graph)
    flat, order = with_measures(flat, scheduled(flat))
    wired = WiredPlan(graph=flat, schedule=order, blocks=flat.blocks)
    prepared, problems = _made(wired, flat.blocks, wide, recordings)
    if problems:
        raise ModelError([flat.placed(problem) for problem in problems])
    filled = Filled(graph=flat, schedule=order, blocks=flat.blocks, **_numbers_of(prepared))
    as_set = {name: block.as_set for name, block in prepared.items() if block.digital is None}
    solvers = find_solvers(filled, as_set, lambda: Outputs(filled, flat.seed).first_tick(), frozenset(free))
    largest: dict[VectorOf, tuple[float, ...]] = {
        solver.largest: (0.0,) * len(solver.group.states) for solver in solvers if solver.tolerance
    }
    named = sorted(zip(graph.probes, flat.probes, strict=True))  # by the names in the graph
    return Plan(
        graph=flat,
        schedule=order,
        blocks=flat.blocks,
        constants=filled.constants,
        starts=filled.starts,
        buffers={**filled.buffers, **largest},
        digital=filled.digital,
        solvers=solvers,
        probes=tuple(_probe(wired, probe.signal, split(inner.signal), probe.every) for probe, inner in named),
        measures=planned_measures(flat, order),
        derived=derived_measures(flat),
    )


def varied(planned: Plan, blocks: Mapping[str, Block]) -> Plan:
    """Return the plan with other numbers in some blocks; order, wiring and methods stay.

    `Plan.same_sizes` says whether one loop runs both. Raises `ModelError` where constants cannot be
    computed.
    """
    changed = dataclasses.replace(planned, blocks={**planned.blocks, **blocks})
    made, problems = _made(changed, blocks)
    if problems:
        raise ModelError(problems)
    numbers: dict[str, Any] = {
        table: {**getattr(planned, table), **entries} for table, entries in _numbers_of(made).items()
    }
    return dataclasses.replace(changed, **numbers)


class _Made(NamedTuple):
    """The numbers that a block brings into a plan."""

    as_set: Any  # constants for the parameters as set, also of blocks with driven parameters
    constants: Any
    start: Any
    buffers: Mapping[Endpoint, tuple[float, ...]]
    digital: DigitalBlock | None = None


def _made(
    planned: WiredPlan, names: Iterable[str], wide: bool = False, recordings: Recordings = NO_RECORDINGS
) -> tuple[dict[str, _Made], list[Problem]]:
    """Constants, starts and buffers of some blocks of a plan."""
    prepared, problems = dict[str, _Made](), list[Problem]()
    drivers = planned.schedule.drivers
    for name in names:
        block = planned.blocks[name]
        kind = type(block)
        try:
            if kind.has_formats():
                traced = digital_block(name, block, planned.block_period(name), wide=wide)
                held = {(name, b): values for b, values in traced.buffers.items()}
                prepared[name] = _Made(None, traced.constants, traced.start, held, traced)
                continue
            as_set = constants_of(block, block, planned.block_period(name))
            if not all(map(math.isfinite, numbers_in(as_set or ()))):
                raise ArithmeticError("one of them is not finite")
            recorded = recordings.get(name) or read_recordings(planned.graph, name)
            filled: dict[str, Any] = {b: recorded.get(b) or _zeros(block, b) for b in kind.buffers}
            begin = start_of(block, filled, planned.block_period(name))
        except ModelError as error:
            problems += error.problems
        except (ArithmeticError, ValueError) as error:
            problems.append(
                Problem(
                    message=f"its constants cannot be computed: {error}",
                    got=repr(block),
                    hint=getattr(error, "hint", "")
                    or (
                        "take a wider format, or a smaller parameter"
                        if kind.has_formats()
                        else "look for a parameter many orders of magnitude off"
                    ),
                    path=("blocks", name),
                )
            )
        else:
            driven = any((name, p) in drivers for p in kind.parameters)
            buffers = {(name, b): tuple(values) for b, values in filled.items()}
            prepared[name] = _Made(as_set, Driven() if driven else as_set, begin, buffers)
    return prepared, problems


def _numbers_of(prepared: Mapping[str, _Made]) -> dict[str, Any]:
    """Return the constants, starts, buffers and digital forms of some blocks, by plan fields."""
    return {
        "constants": {name: block.constants for name, block in prepared.items()},
        "starts": {name: block.start for name, block in prepared.items()},
        "buffers": {node: held for block in prepared.values() for node, held in block.buffers.items()},
        "digital": {name: block.digital for name, block in prepared.items() if block.digital is not None},
    }


def numbers_in(values: Iterable[Any]) -> Iterator[float]:
    """All numbers of constants, those of tuples among them too."""
    for value in values:
        if isinstance(value, tuple):
            yield from numbers_in(value)
        else:
            yield value


def _zeros(block: Block, buffer: str) -> list[float]:
    declared = type(block).buffers[buffer]
    zero = 0 if held_as(declared.dtype) is int else 0.0
    return [zero] * math.prod(shape_of(block, declared))


def _probe(wired: WiredPlan, signal: str, node: Endpoint, every: int) -> PlannedProbe:
    block = wired.blocks[node[0]]
    port = type(block).outputs[node[1]]
    return PlannedProbe(
        signal,
        node,
        wired.stride(node) * every,
        held_as(port.dtype),
        shape_of(block, port),
        unit_of(block, port),
        port.doc,
        format_of(block, port.name) if port.dtype is FixedValue else None,
        wired.beat(node).phase,
    )
