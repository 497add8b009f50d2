"""Directions of dual numbers in a memory: each state, cell and held wire of a period gets one, and gives its slopes."""

from collections.abc import Mapping, Sequence
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.problem import Problem
from proofmass.runner.analysis.linearisation.rings import Entry, Rings
from proofmass.runner.derivatives.dual import PARAMETERS, SIGNALS, dual, plain
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

HELD = -2  # instead of an index: the value that a wire of a block with a clock offset holds as the period begins
PointSlopes = Mapping[Entry, Mapping[str, float]]  # derivatives of an operating point by parameters
NO_RINGS = Rings()


def place_of(memory: Memory, entry: Entry, rings: Rings) -> LastingPlace:
    """Return where an entry stands in a memory."""
    name, part, index = entry
    if index == HELD:
        return "wire", (name, part), 0
    if index < 0:
        return "state", name, memory.states[name]._fields.index(part)
    return "buffer", (name, part), rings.cell(memory, name, part, index)


def with_slopes(memory: Memory, plan: Plan, slopes: PointSlopes | None, rings: Rings) -> Memory:
    """Return a copy whose numbers have the derivatives of the operating point by the parameters."""
    begin, started = memory.copy(), start(plan)

    def moved(entry: Entry, now: Any, first: Any) -> Any:
        if slopes is None:
            return first if first == now else now
        return dual(now, slopes[entry], PARAMETERS) if entry in slopes else now

    for name, state in begin.states.items():
        if state is not None:
            fields = zip(state._fields, state, started.states[name], strict=True)
            begin.states[name] = type(state)(*(moved((name, field, -1), now, first) for field, now, first in fields))
    for (name, buffer), held in begin.of_blocks().items():
        if isinstance(held, list):
            for number in range(len(held)):
                cell = rings.cell(begin, name, buffer, number)
                held[cell] = moved((name, buffer, number), held[cell], started.buffers[name, buffer][cell])
    for name, port, index in slopes or ():
        if index == HELD:
            begin.wires[name, port] = moved((name, port, HELD), begin.wires[name, port], None)
    return begin


def seed(plan: Plan, begin: Memory, names: Sequence[str], counted: set[str], rings: Rings) -> list[Entry]:
    """Give every number of the states and buffers of blocks a direction of its own."""
    seeded: list[Entry] = []

    def moved(value: Any, kind: type, entry: Entry) -> Any:
        if kind is bool or (kind in (int, FixedValue) and entry[0] in counted):
            return value
        seeded.append(entry)
        return value + dual(0.0, {entry: 1.0}, SIGNALS)

    places = rings.places()
    for name in names:
        state = begin.states[name]
        if state is not None:
            kinds = type(state).__annotations__
            begin.states[name] = type(state)(
                *(
                    value if (name, field) in places else moved(value, kinds[field], (name, field, -1))
                    for field, value in zip(state._fields, state, strict=True)
                )
            )
        for buffer, declared in type(plan.blocks[name]).buffers.items():
            held = begin.buffers[name, buffer]
            if isinstance(held, list):
                for number in range(len(held)):
                    cell = rings.cell(begin, name, buffer, number)
                    held[cell] = moved(held[cell], declared.dtype, (name, buffer, number))
    return seeded


def seed_wires(plan: Plan, begin: Memory, names: set[str]) -> list[Entry]:
    """Give what wires still hold as the period begins a direction of its own; raises `ModelError` for a vector."""
    seeded: list[Entry] = []
    for name in sorted(names & plan.schedule.phases.keys()):
        for port, declared in type(plan.blocks[name]).outputs.items():
            if declared.shape:
                raise plan.graph.placed(_vector_held(name, port)).error
            if declared.dtype is not bool:
                entry = (name, port, HELD)
                begin.wires[name, port] = begin.wires[name, port] + dual(0.0, {entry: 1.0}, SIGNALS)
                seeded.append(entry)
    return seeded


def _vector_held(name: str, port: str) -> Problem:
    return Problem(
        message="cannot be linearised: a vector of a block with a clock offset is held from period to period",
        got=f"{name}.{port}",
        expected="outputs that are numbers",
        hint="take the offset out, or open the loop so that this block lies outside",
        path=("blocks", name, "clock_offset"),
    )


def without_slopes(memory: Memory) -> Memory:
    """Return a copy without slopes."""
    copy = memory.copy()
    for name, state in copy.states.items():
        if state is not None:
            copy.states[name] = type(state)(*map(plain, state))
    for node, held in copy.of_blocks().items():
        if isinstance(held, list):
            copy.buffers[node] = list(map(plain, held))
    for wire, value in copy.wires.items():
        copy.wires[wire] = list(map(plain, value)) if isinstance(value, list) else plain(value)
    return copy


def held_in(memory: Memory, entry: Entry, rings: Rings) -> Any:
    """Return what a memory holds for an entry."""
    name, field, index = entry
    if index == HELD:
        return memory.wires[name, field]
    if index < 0:
        return getattr(memory.states[name], field)
    return memory.buffers[name, field][rings.cell(memory, name, field, index)]
