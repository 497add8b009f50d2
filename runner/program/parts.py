"""A very long function split into parts, which it calls one after another; numbers between them stand in memory.

The time of a compiler grows with the square of a function's length and more. A value that one part
computes and another reads, and every variable that outlives a part, has a place in memory: its own,
or one in the scratch array, where integers and truth values are stored by their bits. A loop that
is long itself stays, and its body is split.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from proofmass.runner.program import form
from proofmass.runner.program.build import Builder, zero
from proofmass.runner.program.walk import operands, regions, results, statements

LONG = 8000  # statements from which on a function is split
PART = 1500  # statements of a part, about


Places: TypeAlias = Mapping[form.Variable, tuple[form.Storage, int]]


def in_parts(function: form.Function, places: Places, memory: form.Storage, first: int) -> int | None:
    """Split a function if it is long; return how many places of `memory` it then uses, from `first` on.

    `memory` is one of its parameters, as are the arrays of `places`, in which variables stand from
    call to call. A function that returns early stays whole.
    """
    if sum(1 for _ in statements(function.body)) < LONG or _jumps(function.body):
        return None
    division = _Division(function, places)
    if not division.possible:
        return None
    _Whole(function, division, memory, first).write()
    return len(division.shared)


def _jumps(region: form.Region) -> bool:
    """Return whether statements of a region, or of a loop that may be split, leave it."""
    left = [region]
    while left:
        for statement in left.pop():
            match statement:
                case form.Return() | form.Break() | form.Continue():
                    return True
                case form.If(_, then, otherwise):
                    left += [then, otherwise]
                case form.For(body=body):
                    left.append(body)
                case form.While(body=body) if any(isinstance(inner, form.Return) for inner in statements(body)):
                    return True
    return False


@dataclass
class _Part:
    """Statements that become a function."""

    body: form.Region = field(default_factory=list)


Piece: TypeAlias = _Part | form.For  # a piece of a region that is split


class _Division:
    """Division of statements among parts, and the values that need a place in memory for it."""

    def __init__(self, function: form.Function, places: Places) -> None:
        self.places = places
        self.parts: list[_Part] = []
        self.pieces: dict[int, list[Piece]] = {}  # of each region that is split, by its identity
        self.anywhere: dict[form.Storage | form.Value, form.View | form.Load] = {}  # what any part can compute itself
        self.possible = True  # whether each array is known in all parts that use it
        self._divide(function.body)
        self.homes: dict[form.Value | form.Storage, _Part] = {}
        self.shared: dict[form.Value | form.Variable, None] = {}  # what needs a place in memory
        self._find_homes()
        self._find_shared()

    def _divide(self, region: form.Region) -> None:
        pieces = self.pieces[id(region)] = []
        size = PART
        for statement in region:
            if isinstance(statement, form.View) and isinstance(statement.first, form.Immediate):
                self.anywhere[statement.part] = statement
                continue
            if (
                isinstance(statement, form.Load)
                and isinstance(statement.at, form.Immediate)
                and not statement.array.writable
            ):
                self.anywhere[statement.result] = statement
                continue
            inside = sum(1 for inner in regions(statement) for _ in statements(inner))
            if isinstance(statement, form.For) and inside > PART:
                pieces.append(statement)
                self._divide(statement.body)
                size = PART
                continue
            if size >= PART:
                self.parts.append(_Part())
                pieces.append(self.parts[-1])
                size = 0
            self.parts[-1].body.append(statement)
            size += 1 + inside

    def _find_homes(self) -> None:
        for part in self.parts:
            for statement in statements(part.body):
                self.homes |= dict.fromkeys(results(statement), part)
                if isinstance(statement, form.View):
                    self.homes[statement.part] = part

    def _find_shared(self) -> None:
        users: dict[form.Variable, _Part] = {}
        for part in self.parts:
            set_here = set(set_first(part.body))
            for statement in statements(part.body):
                for read in operands(statement):
                    if isinstance(read, form.Value) and self.homes.get(read, part) is not part:
                        self.shared[read] = None
                    if isinstance(read, form.Storage) and self.homes.get(read, part) is not part:
                        self.possible = False
                if isinstance(statement, form.Get | form.Set) and statement.variable not in self.places:
                    variable = statement.variable
                    if variable not in set_here or users.setdefault(variable, part) is not part:
                        self.shared[variable] = None
        for loop in self.loops():
            self.shared |= {
                read: None for read in operands(loop) if isinstance(read, form.Value) and read in self.homes
            }

    def loops(self) -> Iterator[form.For]:
        """Loops whose bodies are split."""
        return (piece for pieces in self.pieces.values() for piece in pieces if isinstance(piece, form.For))


def set_first(region: form.Region) -> Iterator[form.Variable]:
    """Variables that a region always sets before it reads them."""
    touched: dict[form.Variable, bool] = {}
    for statement in region:
        for inner in (s for region in regions(statement) for s in statements(region)):
            if isinstance(inner, form.Get | form.Set):
                touched.setdefault(inner.variable, False)
        if isinstance(statement, form.Get | form.Set):
            touched.setdefault(statement.variable, isinstance(statement, form.Set))
    return (variable for variable, first in touched.items() if first)


class _Whole:
    """Rewrites the function: calls of its parts, and the loops whose bodies are split."""

    def __init__(self, function: form.Function, division: _Division, memory: form.Storage, first: int) -> None:
        self.function, self.division, self.memory = function, division, memory
        self.places: dict[form.Value | form.Variable, tuple[form.Storage, int]] = {
            item: (memory, first + place) for place, item in enumerate(division.shared)
        }
        self.builder = Builder(function.name)
        self.parts = 0

    def write(self) -> None:
        """Replace the body of the function."""
        begun = next((part.body for part in self.division.parts), [])
        settled = set(set_first(begun))
        for item in self.places:
            if isinstance(item, form.Variable) and item not in settled:
                keep(self.builder, *self.places[item], zero(item.kind))
        for variable, place in self.division.places.items():
            self.places[variable] = place
        self._region(self.function.body)
        self.function.body, self.function.variables = self.builder.function().body, []

    def _region(self, region: form.Region) -> None:
        for piece in self.division.pieces[id(region)]:
            if isinstance(piece, _Part):
                part = _PartWriter(self, piece, f"{self.function.name}_part_{self.parts}")
                self.parts += 1
                self.builder.call(part.function(), *part.arguments)
                continue
            first, last = map(self._bound, (piece.first, piece.last))
            node = piece._replace(first=first, last=last, body=[])
            with self.builder.within(node.body):
                self._region(piece.body)
            self.builder.add(node)

    def _bound(self, value: form.Operand) -> form.Operand:
        if isinstance(value, form.Value) and value in self.places:
            return kept(self.builder, *self.places[value], value.kind)
        if isinstance(value, form.Value) and isinstance(load := self.division.anywhere.get(value), form.Load):
            return self.builder.load(self._array(load.array), load.at, value.name)
        return value

    def _array(self, array: form.Storage) -> form.Storage:
        view = self.division.anywhere.get(array)
        if not isinstance(view, form.View):
            return array
        return self.builder.view(self._array(view.whole), view.first, array.length, array.name)


class _PartWriter:
    """Writes the function of one part; `arguments` are those of its call."""

    def __init__(self, whole: _Whole, part: _Part, name: str) -> None:
        self.places, self.homes, self.anywhere = whole.places, whole.division.homes, whole.division.anywhere
        self.part = part
        self.builder = Builder(name, whole.function.name)
        self.arguments: list[form.Operand | form.Storage] = []
        self.known: dict[form.Value | form.Storage, Any] = {}  # by their values outside

    def function(self) -> form.Function:
        """Return the part as a function that targets do not inline."""
        for statement in self.part.body:
            self._read_before(statement)
            self._write(statement)
        function = self.builder.function()
        used = {s.variable: None for s in statements(function.body) if isinstance(s, form.Get | form.Set)}
        function.variables, function.apart = list(used), True
        return function

    def _read_before(self, statement: form.Statement) -> None:
        """Load what a statement reads of other parts, before the statement, so that all of it can use the values."""
        inner = (s for region in regions(statement) for s in statements(region))
        for read in (read for s in (statement, *inner) for read in operands(s)):
            if isinstance(read, form.Storage):
                self._array(read)
            elif isinstance(read, form.Value) and self.homes.get(read) is not self.part and read not in self.known:
                self.known[read] = self._outer(read)

    def _outer(self, value: form.Value) -> form.Operand:
        if value in self.places:
            return self._kept(value)
        if isinstance(load := self.anywhere.get(value), form.Load):
            return self.builder.load(self._array(load.array), load.at, value.name)
        self.arguments.append(value)
        return self.builder.parameter(value.kind, value.name)

    def _array(self, array: form.Storage) -> form.Storage:
        if self.homes.get(array) is self.part:
            return array
        if array not in self.known:
            self.known[array] = self._outer_array(array)
        here: form.Storage = self.known[array]
        return here

    def _outer_array(self, array: form.Storage) -> form.Storage:
        if isinstance(view := self.anywhere.get(array), form.View):
            return self.builder.view(self._array(view.whole), view.first, array.length, array.name)
        self.arguments.append(array)
        return self.builder.array(array.entry, array.length, array.name, array.writable)

    def _kept(self, item: form.Value | form.Variable) -> form.Operand:
        array, index = self.places[item]
        return kept(self.builder, self._array(array), index, item.kind)

    def _keep(self, item: form.Value | form.Variable, value: form.Operand) -> None:
        array, index = self.places[item]
        keep(self.builder, self._array(array), index, value)

    def _write(self, statement: form.Statement) -> None:
        self.builder.line = statement.line
        match statement:
            case form.Get(result, variable) if variable in self.places:
                self.known[result] = self._kept(variable)
            case form.Set(variable, value) if variable in self.places:
                self._keep(variable, self._operand(value))
            case _:
                self.builder.add(self._mapped(statement))
        for result in results(statement):
            if result in self.places and not isinstance(statement, form.For):
                self._keep(result, self._operand(result))

    def _operand(self, value: Any) -> Any:
        return self.known.get(value, value)

    def _mapped(self, statement: Any) -> form.Statement:
        """Copy a statement with the values of this function: fields in order, as a condition is a value of its test."""
        mapped: form.Statement = statement._make(map(self._field, statement))
        return mapped

    def _field(self, value: Any) -> Any:
        if isinstance(value, list):
            return self._region(value)
        return tuple(map(self._operand, value)) if isinstance(value, tuple) else self._operand(value)

    def _region(self, region: form.Region) -> form.Region:
        with self.builder.within([]) as written:
            for statement in region:
                self._write(statement)
        return written


def keep(builder: Builder, array: form.Storage, place: int, value: form.Operand) -> None:
    """Store a value of any kind in an array of numbers or of integers."""
    if value.kind is form.TRUTH:
        value = builder.compute("integer_of_truth", value)
    if value.kind is form.INTEGER and array.entry is form.FLOAT:
        value = builder.compute("float_of_bits", value)
    builder.store(array, place, value)


def kept(builder: Builder, array: form.Storage, place: int, kind: form.Kind) -> form.Operand:
    """Load a value that `keep` stored."""
    value: form.Operand = builder.load(array, place)
    if kind is not form.FLOAT and array.entry is form.FLOAT:
        value = builder.compute("bits_of_float", value)
    return builder.compute("not_equal_integers", value, 0) if kind is form.TRUTH else value
