"""Directions of dual numbers in a memory: each state, cell and held wire of a period gets one, and gives its slopes."""

from collections.abc import Callable, Iterable, Mapping, Sequence
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


def at_place(memory: Memory, place: LastingPlace) -> Any:
    """Return what a memory holds at a place."""
    kind, of, number = place
    if kind == "state":
        return memory.states[of][number]
    return memory.buffers[of][number] if kind == "buffer" else memory.wires[of]


def put(memory: Memory, place: LastingPlace, value: Any) -> None:
    """Put a number at a place of a memory."""
    kind, of, number = place
    held: Any = memory.wires[of] if kind == "wire" else memory.buffers[of] if kind == "buffer" else None
    if kind == "state":
        state = memory.states[of]
        memory.states[of] = state._replace(**{state._fields[number]: value})
    elif isinstance(held, list):
        held[number] = value
    else:
        memory.wires[of] = value


def held_in(memory: Memory, entry: Entry, rings: Rings) -> Any:
    """Return what a memory holds for an entry."""
    return at_place(memory, place_of(memory, entry, rings))


def _change(
    plan: Plan, memory: Memory, names: Iterable[str], rings: Rings, change: Callable[[Entry, type, Any], Any]
) -> None:
    """Put what is made of each number that blocks hold, by its entry and kind, in its place."""
    for name in names:
        state = memory.states[name]
        if state is not None:
            fields = zip(type(state).__annotations__.items(), state, strict=True)
            memory.states[name] = type(state)(*(change((name, field, -1), kind, v) for (field, kind), v in fields))
        for buffer, declared in type(plan.blocks[name]).buffers.items():
            held = memory.buffers[name, buffer]
            for number in range(len(held)) if isinstance(held, list) else ():
                cell = rings.cell(memory, name, buffer, number)
                held[cell] = change((name, buffer, number), declared.dtype, held[cell])  # type: ignore[index]


def with_slopes(memory: Memory, plan: Plan, slopes: PointSlopes | None, rings: Rings) -> Memory:
    """Return a copy whose numbers have the derivatives of the operating point by the parameters.

    Those that are not among them have the derivatives of the start, while they have its value.
    """
    begin, started = memory.copy(), start(plan)

    def moved(entry: Entry, kind: type, now: Any) -> Any:
        if slopes is not None and entry in slopes:
            return dual(now, slopes[entry], PARAMETERS)
        first = at_place(started, place_of(begin, entry, rings))
        return first if first == now else now

    _change(plan, begin, begin.states, rings, moved)
    for name, port, index in slopes or ():
        if index == HELD:
            begin.wires[name, port] = moved((name, port, HELD), float, begin.wires[name, port])
    return begin


def along(plan: Plan, memory: Memory, names: Iterable[str], slope: Callable[[], float]) -> Memory:
    """Return a copy whose numbers, those of some blocks, all move along one direction with some slopes."""
    begin = memory.copy()

    def moved(entry: Entry, kind: type, value: Any) -> Any:
        return value + dual(0.0, {"along": slope()}, SIGNALS) if kind is float else value

    _change(plan, begin, names, NO_RINGS, moved)
    return begin


def seed(plan: Plan, begin: Memory, names: Sequence[str], counted: set[str], rings: Rings) -> list[Entry]:
    """Give every number of the states and buffers of blocks a direction of its own."""
    seeded: list[Entry] = []
    places = rings.places()

    def moved(entry: Entry, kind: type, value: Any) -> Any:
        if kind is bool or entry[:2] in places or (kind in (int, FixedValue) and entry[0] in counted):
            return value
        seeded.append(entry)
        return value + dual(0.0, {entry: 1.0}, SIGNALS)

    _change(plan, begin, names, rings, moved)
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


def without_slopes(memory: Memory, plan: Plan) -> Memory:
    """Return a copy without slopes."""
    copy = memory.copy()
    _change(plan, copy, copy.states, NO_RINGS, lambda entry, kind, value: plain(value))
    for wire, value in copy.wires.items():
        copy.wires[wire] = list(map(plain, value)) if isinstance(value, list) else plain(value)
    return copy
