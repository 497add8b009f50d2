"""A tick of a plan with its slopes: what each number that lasts, and an input at a wire, do to all numbers that last.

The wire is chosen when the program runs, and is cut there: its value goes on, its slope is that of the input alone.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.build import Builder, operand
from proofmass.runner.program.form import (
    FLOAT,
    INTEGER,
    TRUTH,
    Function,
    Kind,
    Operand,
    Program,
    Storage,
    Value,
    Variable,
)
from proofmass.runner.program.lower import program
from proofmass.runner.program.tangents import Tangents, TangentStep
from proofmass.runner.program.tick import TickWriter
from proofmass.runner.program.tick_loop import TickLoop

INPUT = -1  # stands for the input among the directions
READ, VALUED, VALUE, SLOPE = range(4)  # at the wire: of the value read, whether it exists, and which; the input's
MOVED = 4  # whether numbers that matrices follow from have slopes
AT_THE_WIRE = 5
WIRE, MATRICES = range(2)  # of what is cut: the wire, and what becomes of matrices that follow from numbers
AS_BEFORE, RENEWED, AT_REST = range(3)  # they are made anew with their slopes, or their slopes become zero
_WIRE, _STILL, _FOLLOWED = "wire that may be cut", "number without slope", "number that a matrix follows from"


@dataclass(frozen=True)
class SlopeTick:
    """The program of ticks in some directions, one for each lane, and what it is called with."""

    written: TickLoop  # of the tick alone: places of its numbers
    program: Program
    shared: frozenset[Storage]  # what all lanes read
    apart: frozenset[Storage]  # what is another in each lane: directions, and all slopes
    wires: dict[Endpoint, int]  # by which a wire is chosen


def write_slopes(plan: Plan) -> SlopeTick:
    """Return the program of a plan without probes. Its algebraic loops and inexact groups are those of `can_be_cut`."""
    writer = _CutWriter(replace(plan, probes=()))
    loop = writer.written()
    entry = loop.program.entry
    scratch = writer.numbers.scratch_array
    moved = [p for p in entry.parameters if isinstance(p, Storage) and p.writable and p not in writer.at_the_wire]
    sloped = Tangents({_WIRE: _cut, _STILL: _nothing, _FOLLOWED: _told}).of(
        entry, tuple(p in moved for p in entry.parameters)
    )
    moved.remove(scratch)
    directions = _Directions(entry, moved, scratch)
    whole = program(directions.written(sloped))
    return SlopeTick(loop, whole, directions.shared, directions.apart, writer.wires)


class _CutWriter(TickWriter):
    """Writes a tick in which each wire of one number may be cut."""

    def __init__(self, plan: Plan) -> None:
        super().__init__(plan)
        self.wires: dict[Endpoint, int] = {}
        self.at_the_wire = (
            self.builder.array(INTEGER, 2, "cut", True),
            self.builder.array(FLOAT, AT_THE_WIRE, "at_the_wire", True),
        )
        self._marks = {kind: _mark(self.builder, kind) for kind in (FLOAT, INTEGER)}
        self._still = _marked(self.builder, _STILL)
        self._followed = _marked(self.builder, _FOLLOWED, AT_THE_WIRE)

    def renewing(self, matrix: Storage, followed: Sequence[Operand]) -> Operand:
        builder = self.builder
        for value in followed:
            builder.call(self._followed, value, self.at_the_wire[1])
        what = builder.load(self.at_the_wire[0], MATRICES)
        assert matrix.length is not None
        with (
            builder.when(builder.compute("equal_integers", what, AT_REST)),
            builder.counted(0, matrix.length, 1, "entry") as i,
        ):
            builder.store(matrix, i, *builder.call(self._still, builder.load(matrix, i)))
        return builder.compute("equal_integers", what, RENEWED)

    def output(self, name: str, port: str) -> None:
        super().output(name, port)
        wire = self.frame.wires[name, port]
        if isinstance(wire, Variable) and wire.kind is not TRUTH:
            number = self.wires.setdefault((name, port), len(self.wires))
            (value,) = self.builder.call(self._marks[wire.kind], self.builder.get(wire), number, *self.at_the_wire)
            self.builder.set(wire, value)


def _mark(builder: Builder, kind: Kind) -> Function:
    """Return a function that gives the value of a wire back, and that has slopes of its own."""
    inner = builder.beside(f"wire_of_{kind.name.lower()}", inline=True)
    inner.origin = _WIRE
    value = inner.parameter(kind, "value")
    inner.parameter(INTEGER, "number")
    inner.array(INTEGER, 2, "cut", True)
    inner.array(FLOAT, AT_THE_WIRE, "at_the_wire", True)
    inner.give(value)
    return inner.function()


def _marked(builder: Builder, origin: str, length: int = 0) -> Function:
    """Return a function that gives a number back, and that has slopes of its own; an array may come with it."""
    inner = builder.beside(origin.replace(" ", "_"), inline=True)
    inner.origin = origin
    value = inner.parameter(FLOAT, "value")
    if length:
        inner.array(FLOAT, length, "at_the_wire", True)
    inner.give(value)
    return inner.function()


def _nothing(s: TangentStep) -> Operand:
    return operand(0.0)


def _told(s: TangentStep) -> Operand:
    builder, (_, at_the_wire), slope = s.writer.builder, s.x, s.dx[0]
    apart = builder.compute("not_equal", slope, 0.0)
    builder.store(at_the_wire, MOVED, builder.compute("select", apart, 1.0, builder.load(at_the_wire, MOVED)))
    return slope


def _cut(s: TangentStep) -> Operand:
    builder, (_, number, cut, at_the_wire) = s.writer.builder, s.x
    here = builder.compute("equal_integers", builder.load(cut, WIRE), number)
    with builder.when(here):
        builder.store(at_the_wire, READ, s.dx[0])
        builder.store(at_the_wire, VALUED, 1.0)
        builder.store(at_the_wire, VALUE, s.writer.number(s.y))
    return builder.compute("select", here, builder.load(at_the_wire, SLOPE), s.dx[0])


class _Directions:
    """Writes the function of some ticks, each in several directions from one memory: a row of slopes for each.

    Its parameters are those of the tick and the slopes of scratch; for the arrays that move, in their order, their
    slopes and what they are before a tick, and their lengths; the places of entries whose slopes are kept, of one array
    after the other, and where those of each end; the directions, what becomes of matrices in each row of them, their
    number, and the rows: the slopes that are kept, then what stands at the wire. What is kept in scratch holds for all
    directions, and slopes of matrices for the following rows. Lanes have a direction each: all but the slopes is shared
    by them.
    """

    def __init__(self, entry: Function, moved: Sequence[Storage], scratch: Storage) -> None:
        self.entry = entry
        builder = self.builder = Builder("in_directions", entry.origin)
        self.copies = {parameter: _copied(builder, parameter) for parameter in entry.parameters}
        self.slopes: dict[Value | Storage, Storage] = {scratch: builder.array(FLOAT, None, "scratch_slopes", True)}
        self.moved = [self._array(array) for array in moved]
        self.slopes |= {a: builder.array(FLOAT, a.length, f"{a.name}_slopes", True) for a in moved}
        self.before = [builder.array(array.entry, None, f"{array.name}_before", True) for array in moved]
        lengths = builder.array(INTEGER, len(moved), "lengths")
        self.kept = builder.array(INTEGER, None, "kept")
        self.ends = builder.array(INTEGER, len(moved), "ends")
        self.directions = builder.array(INTEGER, None, "directions")
        self.matrices = builder.array(INTEGER, None, "matrices")
        self.number = builder.parameter(INTEGER, "number")
        self.rows = builder.array(FLOAT, None, "rows", True)
        self.lengths = [builder.load(lengths, k) for k, _ in enumerate(moved)]
        self.own = [self.slopes[array] for array in moved]
        self.apart = frozenset([self.directions, self.rows, *self.slopes.values(), self._array(entry.parameters[-1])])
        arrays = [*self.copies.values(), *self.before, lengths, self.kept, self.ends, self.matrices]
        self.shared = frozenset(a for a in arrays if isinstance(a, Storage)) - self.apart

    def written(self, sloped: Function) -> Function:
        """Return the function, by that of the tick with slopes."""
        builder, entry = self.builder, self.entry
        width = builder.compute("add_integers", builder.load(self.ends, len(self.moved) - 1), AT_THE_WIRE)
        first, last = (self.copies[p] for p in entry.parameters[:2])
        assert isinstance(first, Value)
        assert isinstance(last, Value)
        others = entry.parameters[2:]
        given = [each for p in others for each in (self.copies[p], *filter(None, [self.slopes.get(p)]))]
        with builder.counted(first, last, 1, "tick") as tick:
            following = builder.compute("add_integers", tick, 1)
            done = builder.compute("multiply_integers", builder.compute("subtract_integers", tick, first), self.number)
            self._save()
            with builder.counted(0, self.number, 1, "row") as row:
                builder.store(self._array(entry.parameters[-2]), MATRICES, builder.load(self.matrices, row))
                self._begin(builder.load(self.directions, row))
                builder.call(sloped, tick, following, *given)
                self._keep(builder.compute("multiply_integers", builder.compute("add_integers", done, row), width))
        return builder.function()

    def _array(self, parameter: Value | Storage) -> Storage:
        copy = self.copies[parameter]
        assert isinstance(copy, Storage)
        return copy

    def _save(self) -> None:
        builder = self.builder
        for array, before, length in zip(self.moved, self.before, self.lengths, strict=True):
            with builder.counted(0, length, 1, "entry") as i:
                builder.store(before, i, builder.load(array, i))

    def _begin(self, direction: Operand) -> None:
        builder, at_the_wire = self.builder, self._array(self.entry.parameters[-1])
        place = direction
        for array, slope, before, length in zip(self.moved, self.own, self.before, self.lengths, strict=True):
            with builder.counted(0, length, 1, "entry") as i:
                builder.store(array, i, builder.load(before, i))
                builder.store(slope, i, 0.0)
            within = builder.compute("less_integers", place, length)
            with builder.when(builder.compute("both", builder.compute("less_equal_integers", 0, place), within)):
                builder.store(slope, place, 1.0)
            place = builder.compute("subtract_integers", place, length)
        entered = builder.compute("equal_integers", direction, INPUT)
        builder.store(at_the_wire, SLOPE, builder.compute("float_of_truth", entered))
        builder.store(at_the_wire, VALUED, 0.0)
        builder.store(at_the_wire, MOVED, 0.0)

    def _keep(self, place: Operand) -> None:
        builder, at_the_wire = self.builder, self._array(self.entry.parameters[-1])
        first: Operand = operand(0)
        for k, array in enumerate(self.own):
            last = builder.load(self.ends, k)
            with builder.counted(first, last, 1, "entry") as i:
                slope = builder.load(array, builder.load(self.kept, i))
                builder.store(self.rows, builder.compute("add_integers", place, i), slope)
            first = last
        place = builder.compute("add_integers", place, first)
        for number in range(AT_THE_WIRE):
            builder.store(self.rows, builder.compute("add_integers", place, number), builder.load(at_the_wire, number))


def _copied(builder: Builder, parameter: Value | Storage) -> Value | Storage:
    if isinstance(parameter, Storage):
        return builder.array(parameter.entry, parameter.length, parameter.name, parameter.writable)
    return builder.parameter(parameter.kind, parameter.name)
