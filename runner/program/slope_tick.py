"""A tick of a plan with its slopes: what numbers that last, and events of the tick, do to all numbers that last.

Events are wires that are chosen when the program runs (`events`), and with noise all that draws or rounds.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, TypeAlias

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.build import Builder, operand, parameters_like
from proofmass.runner.program.events import (
    AT_WIRES,
    COUNT,
    EVENT,
    MATRICES,
    MOVED,
    OF_NOISE,
    OWNER,
    TOLD,
    UNKNOWN,
    VALUES,
    Events,
    Marks,
)
from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    TRUTH,
    Function,
    Operand,
    Program,
    Storage,
    Value,
    Variable,
)
from proofmass.runner.program.lower import call, program
from proofmass.runner.program.structure import Lowered
from proofmass.runner.program.tangent_rules import TangentStep
from proofmass.runner.program.tangents import Tangents
from proofmass.runner.program.tick import TickWriter
from proofmass.runner.program.tick_loop import TickLoop

NONE, FIRST_EVENT = -1, -2  # instead of a number that lasts, in a lane: no direction, event 0; events go downwards
AS_BEFORE, RENEWED, AT_REST = range(
    3
)  # matrices that follow from numbers are made anew with their slopes, or have none
SEEDED = 3  # matrices as before; not one number alone has a slope, but all as given
_Several: TypeAlias = tuple[Any, ...]
_STILL, _FOLLOWED = "number without slope", "number that a matrix follows from"


@dataclass(frozen=True)
class SlopeTick:
    """The program of ticks in some directions, one for each lane, and what it is called with."""

    written: TickLoop  # of the tick alone: places of its numbers
    program: Program
    shared: frozenset[Storage]  # what all lanes read
    apart: frozenset[Storage]  # what is another in each lane: directions, and all slopes
    wires: dict[Endpoint, int]  # by which a wire is chosen
    blocks: dict[str, int]  # by which events tell their block


def write_slopes(plan: Plan, noise: bool = False) -> SlopeTick:
    """Return the program of a plan without probes. Its algebraic loops and inexact groups are those of `has_slopes`."""
    writer = _MarkingWriter(replace(plan, probes=()), noise)
    loop = writer.written()
    entry = loop.program.entry
    scratch = writer.numbers.scratch_array
    moved = [p for p in entry.parameters if isinstance(p, Storage) and p.writable and p not in writer.events]
    rules = {**AT_WIRES, **(OF_NOISE if noise else {}), _STILL: lambda s: operand(0.0), _FOLLOWED: _followed}
    sloped = Tangents(rules, writer.events).of(entry, tuple(p in moved for p in entry.parameters))
    moved.remove(scratch)
    directions = _Directions(entry, moved, scratch, writer.events)
    whole = program(directions.written(sloped))
    return SlopeTick(loop, whole, directions.shared, directions.apart, writer.wires, writer.blocks)


class _MarkingWriter(TickWriter):
    """Writes a tick in which each wire of one number may be an event; with `noise` deviates are events too."""

    def __init__(self, plan: Plan, noise: bool) -> None:
        super().__init__(plan)
        self.wires: dict[Endpoint, int] = {}
        self.blocks = {name: number for number, name in enumerate(plan.blocks)}
        self.events = Events.of(self.builder)
        self._marks, self._noise = Marks.beside(self.builder), noise
        self.digital.resting = self._marks.rest
        if noise:
            self.digital.dropping = self._marks.drop
        self._still = _marked(self.builder, _STILL)
        self._followed = _marked(self.builder, _FOLLOWED)

    def renewing(self, matrix: Storage, followed: Sequence[Operand]) -> Operand:
        builder = self.builder
        for value in followed:
            builder.call(self._followed, value)
        what = builder.load(self.events.state, MATRICES)
        assert matrix.length is not None
        with (
            builder.when(builder.compute("equal_integers", what, AT_REST)),
            builder.counted(0, matrix.length, 1, "entry") as i,
        ):
            builder.store(matrix, i, *builder.call(self._still, builder.load(matrix, i)))
        return builder.compute("equal_integers", what, RENEWED)

    def value_of(self, name: str, function: str) -> Lowered:
        self._runs(name)
        return super().value_of(name, function)

    def driven(self, name: str) -> None:
        self._runs(name)
        super().driven(name)

    def draw(self, name: str) -> None:
        super().draw(name)
        if not self._noise:
            return
        self._runs(name)
        builder, deviate = self.builder, self.frame.deviates[name]
        drawn = builder.compute("less_integers", 0, builder.load(self.events.state, VALUES))
        value = builder.compute("select", drawn, builder.get(deviate), 0.0)
        builder.set(deviate, *builder.call(self._marks.deviate, value))

    def output(self, name: str, port: str) -> None:
        super().output(name, port)
        wire = self.frame.wires[name, port]
        if isinstance(wire, Variable) and wire.kind is not TRUTH:
            number = self.wires.setdefault((name, port), len(self.wires))
            (value,) = self.builder.call(self._marks.wires[wire.kind], self.builder.get(wire), number)
            self.builder.set(wire, value)

    def _runs(self, name: str) -> None:
        if self._noise:
            self.builder.store(self.events.state, OWNER, self.blocks[name])


def _marked(builder: Builder, origin: str) -> Function:
    """Return a function that gives a number back, and that has slopes of its own."""
    inner = builder.beside(origin.replace(" ", "_"))
    inner.origin = origin
    inner.give(inner.parameter(FLOAT, "value"))
    return inner.function()


def _followed(s: TangentStep) -> Operand:
    builder, lane, slope = s.builder, Events(*s.beside).lane, s.dx[0]
    apart = builder.compute("not_equal", slope, 0.0)
    builder.store(lane, MOVED, builder.compute("select", apart, 1.0, builder.load(lane, MOVED)))
    return slope


class _Directions:
    """Writes the function of some ticks, each in several directions from one memory: a row of slopes for each.

    Its parameters are those of the tick and the slopes of scratch; for the arrays that move, in
    their order, their slopes and what they are before a tick, and their lengths; the places of
    entries whose slopes are kept, of one array after the other, and where those of each end; slopes
    of all entries that a seeded row begins with; the directions, what becomes of matrices in each
    row of them, their number and that of events; the rows, which are the slopes that are kept,
    those at the events, and whether matrices have some; and for each tick its number of events, and
    what these tell. What is kept in scratch holds for all directions, and slopes of matrices for
    the following rows. Lanes have a direction each: all but the slopes is shared by them.
    """

    def __init__(self, entry: Function, moved: Sequence[Storage], scratch: Storage, events: Events) -> None:
        self.entry = entry
        builder = self.builder = Builder("in_directions", entry.origin)
        self.copies: dict[Any, Any] = {p: parameters_like(builder, p.name, p) for p in entry.parameters}
        self.slopes: dict[Value | Storage, Storage] = {scratch: builder.array(FLOAT, None, "scratch_slopes", True)}
        self.moved = tuple(self.copies[array] for array in moved)
        self.slopes |= {a: builder.array(FLOAT, a.length, f"{a.name}_slopes", True) for a in moved}
        self.before = tuple(builder.array(array.entry, None, f"{array.name}_before", True) for array in moved)
        lengths = builder.array(INTEGER, len(moved), "lengths")
        self.kept = builder.array(INTEGER, None, "kept")
        self.ends = builder.array(INTEGER, len(moved), "ends")
        self.seeds = builder.array(FLOAT, None, "seeds")
        self.directions = builder.array(INTEGER, None, "directions")
        self.matrices = builder.array(INTEGER, None, "matrices")
        self.number = builder.parameter(INTEGER, "number")
        self.most = builder.parameter(INTEGER, "most")
        self.rows = builder.array(FLOAT, None, "rows", True)
        self.tellings = builder.array(FLOAT, None, "tellings", True)
        self.events = Events(*(self.copies[array] for array in events))
        self.lengths = tuple(builder.load(lengths, k) for k, _ in enumerate(moved))
        self.own = tuple(self.slopes[array] for array in moved)
        lanes = self.events.heard, self.events.lane
        self.apart = frozenset([self.directions, self.seeds, self.rows, *self.slopes.values(), *lanes])
        arrays = [*self.copies.values(), *self.before, lengths, self.kept, self.ends, self.matrices, self.tellings]
        self.shared = frozenset(a for a in arrays if isinstance(a, Storage)) - self.apart

    def written(self, sloped: Function) -> Function:
        """Return the function, by that of the tick with slopes."""
        builder, entry = self.builder, self.entry
        kept = builder.load(self.ends, len(self.moved) - 1)
        width = builder.compute("add_integers", builder.compute("add_integers", kept, self.most), 1)
        (first, last), others = (self.copies[p] for p in entry.parameters[:2]), entry.parameters[2:]
        given = [each for p in others for each in (self.copies[p], *filter(None, [self.slopes.get(p)]))]
        with builder.counted(first, last, 1, "tick") as tick:
            following = builder.compute("add_integers", tick, 1)
            number = builder.compute("subtract_integers", tick, first)
            done = builder.compute("multiply_integers", number, self.number)
            call(builder, _save, (self.moved, self.before, self.lengths))
            with builder.counted(0, self.number, 1, "row") as row:
                builder.store(self.events.state, MATRICES, builder.load(self.matrices, row))
                direction = builder.load(self.directions, row)
                begun = direction, self.moved, self.own, self.before, self.lengths, self.seeds, self.events
                call(builder, _begin, begun)
                builder.call(sloped, tick, following, *given)
                place = builder.compute("multiply_integers", builder.compute("add_integers", done, row), width)
                call(builder, _keep, (self.rows, place, self.own, self.kept, self.ends, self.events, self.most))
            call(builder, _tell, (self.tellings, number, self.events, self.most))
        return builder.function()


# -- in the loop: functions that programs call -----------------------------------------------------


def _save(moved: _Several, before: _Several, lengths: _Several) -> None:
    """Keep what numbers are before a tick."""
    for array, kept, length in zip(moved, before, lengths, strict=True):
        for i in range(length):
            kept[i] = array[i]


def _begin(
    direction: int,
    moved: _Several,
    slopes: _Several,
    before: _Several,
    lengths: _Several,
    seeds: Any,
    events: Any,
) -> None:
    """Begin a tick in a direction: numbers are what they were, and one has the slope 1, or all have those given."""
    place, first = direction, 0
    for array, slope, kept, length in zip(moved, slopes, before, lengths, strict=True):
        for i in range(length):
            array[i] = kept[i]
            slope[i] = 0.0
        if 0 <= place < length:
            slope[place] = 1.0
        if events.state[MATRICES] == SEEDED:
            for i in range(length):
                slope[i] = seeds[first + i]
        place -= length
        first += length
    events.lane[EVENT] = float(FIRST_EVENT - direction)
    events.lane[MOVED] = events.lane[UNKNOWN] = 0.0
    events.state[COUNT] = 0


def _keep(rows: Any, place: int, slopes: _Several, kept: Any, ends: Any, events: Any, most: int) -> None:
    """Keep the slopes of a tick, those at its events, and if matrices have, from a place on.

    None is known where a number that has a slope was taken apart.
    """
    known = events.lane[UNKNOWN] if events.state[MATRICES] != SEEDED else 0.0
    first = 0
    for k, slope in enumerate(slopes):
        for i in range(first, ends[k]):
            rows[place + i] = slope[kept[i]] + known
        first = ends[k]
    place += first
    for event in range(most):
        heard = events.heard[event]
        rows[place + event] = heard if event < events.state[COUNT] else 0.0
    rows[place + most] = events.lane[MOVED]


def _tell(tellings: Any, number: int, events: Any, most: int) -> None:
    """Keep how many events a tick of some number had, and what they tell."""
    entries = most * TOLD
    place = number * (entries + 1)
    tellings[place] = float(events.state[COUNT])
    for i in range(entries):
        tellings[place + 1 + i] = events.told[i]
