"""The numbers of a program that differ from lane to lane when several runs go through it side by side.

A number differs where it follows from one that does, and a variable also where some lanes set it
and others do not. Lanes diverge at an `If` whose condition differs, and at jumps inside it: from
there to the end of the region that was left, only some lanes are active. Each function is analysed
once for each way in which it is called.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from proofmass.runner.program import form

ALL = -1  # entries of an array, as bits of an integer


class ArrayOf(NamedTuple):
    """Passing of an array to a function: `rows` of lanes or one number for all; entries that differ, as bits."""

    rows: bool
    entries: int = 0
    apart: bool = False  # whether it begins at another place in each lane


class Way(NamedTuple):
    """Way of calling a function: whether lanes may be inactive, and what differs in parameters."""

    masked: bool
    parameters: tuple["bool | ArrayOf", ...]


class _Part(NamedTuple):
    """Place of an array: its parameter, its first entry (None: unknown), and whether that differs by lane."""

    root: form.Storage
    first: int | None
    apart: bool


@dataclass
class Varying:
    """The values that differ in a function called in one way."""

    function: form.Function
    way: Way
    numbers: set[form.Value | form.Variable] = field(default_factory=set)
    entries: dict[form.Storage, int] = field(default_factory=dict)  # of the parameters, as bits
    results: list[bool] = field(default_factory=list)
    calls: dict[int, Way] = field(default_factory=dict)  # by the identity of the statement
    loops: set[int] = field(default_factory=set)  # loops that lanes leave at different times
    parting: set[int] = field(default_factory=set)  # statements after which fewer lanes are active
    parts: dict[form.Storage, _Part] = field(default_factory=dict)

    def differs(self, operand: form.Operand) -> bool:
        """Return whether a number differs from lane to lane."""
        return operand in self.numbers if not isinstance(operand, form.Immediate) else False

    def given(self, array: form.Storage) -> ArrayOf:
        """Return how the parameter in which an array lies is passed."""
        way = self.way.parameters[self.function.parameters.index(self.parts[array].root)]
        assert isinstance(way, ArrayOf)
        return way

    def read_differs(self, array: form.Storage, index: form.Operand) -> bool:
        """Return whether a loaded entry differs."""
        part = self.parts[array]
        bits = self.bits(array, index, 1)
        return part.apart or self.differs(index) or bool(self.entries[part.root] & bits)

    def bits(self, array: form.Storage, index: form.Operand, count: int | None) -> int:
        """Entries of the parameter that an access may touch, as bits."""
        part = self.parts[array]
        if part.first is None or part.apart:
            return ALL
        if isinstance(index, form.Immediate) and count is not None:
            return ((1 << count) - 1) << (part.first + int(index.value))
        return ALL if array.length is None else ((1 << array.length) - 1) << part.first


class LaneAnalysis:
    """Analyses functions, each once for each way in which it is called."""

    def __init__(self) -> None:
        self._known: dict[tuple[form.Function, Way], Varying] = {}

    def of(self, function: form.Function, way: Way) -> Varying:
        """Return what differs in a function."""
        if (function, way) not in self._known:
            self._known[function, way] = _Reader(function, way, self).read()
        return self._known[function, way]

    def of_entry(
        self,
        function: form.Function,
        differing: frozenset[form.Value],
        shared: frozenset[form.Storage],
        entries: Mapping[form.Storage, int],
    ) -> Varying:
        """Return what differs in the program's entry, given the `differing` numbers and `entries`
        of arrays, as bits.

        All lanes read the same `shared` arrays.
        """
        parameters = tuple(
            p in differing if isinstance(p, form.Value) else ArrayOf(p not in shared, entries.get(p, 0))
            for p in function.parameters
        )
        while True:  # entries that differ after a call of the program differ before the next
            varying = self.of(function, Way(False, parameters))
            behind = tuple(
                given._replace(entries=varying.entries[p])
                if isinstance(given, ArrayOf) and isinstance(p, form.Storage)
                else given
                for given, p in zip(parameters, function.parameters, strict=True)
            )
            if behind == parameters:
                return varying
            parameters = behind


class _Left(NamedTuple):
    """Lanes that have left the innermost loop or the function apart from others."""

    loop: bool = False
    function: bool = False

    def __or__(self, other: "_Left") -> "_Left":
        return _Left(self.loop or other.loop, self.function or other.function)


_NONE = _Left()


class _Reader:
    """Analyses one function again and again until no further value is found to differ."""

    def __init__(self, function: form.Function, way: Way, lanes: LaneAnalysis) -> None:
        self.found, self.lanes = Varying(function, way), lanes
        self.found.results = [False] * len(function.results)
        for parameter, argument in zip(function.parameters, way.parameters, strict=True):
            if isinstance(parameter, form.Storage):
                assert isinstance(argument, ArrayOf)
                self.found.parts[parameter] = _Part(parameter, None if argument.apart else 0, argument.apart)
                self.found.entries[parameter] = ALL if argument.apart else argument.entries
            elif argument:
                self.found.numbers.add(parameter)

    def read(self) -> Varying:
        """Return all that differs."""
        before = None
        while before != (before := self._size()):
            self._region(self.found.function.body, False, False)
        return self.found

    def _size(self) -> tuple[object, ...]:
        found = self.found
        return len(found.numbers), tuple(found.entries.values()), tuple(found.results), len(found.loops)

    def _region(self, region: form.Region, apart: bool, apart_in_loop: bool) -> _Left:
        """Analyse statements; `apart` says whether lanes of the function, or of the loop's turn, may be inactive."""
        left = _NONE
        for statement in region:
            of_this = self._statement(statement, apart, apart_in_loop)
            if of_this.loop or of_this.function:
                self.found.parting.add(id(statement))
                apart = apart_in_loop = True
                left |= of_this
        return left

    def _statement(self, s: form.Statement, apart: bool, apart_in_loop: bool) -> _Left:
        varying = self.found
        match s:
            case form.Compute():
                for operand in s.operands:
                    if not isinstance(operand, form.Immediate) and operand in varying.numbers:
                        varying.numbers.add(s.result)
                        break
            case form.Get(result, variable):
                self._note(result, variable in varying.numbers)
            case form.Set(variable, value):
                self._note(variable, apart or varying.differs(value))
            case form.Load(result, array, index):
                self._note(result, varying.read_differs(array, index))
            case form.Store(array, index, value):
                if apart or varying.way.masked or varying.differs(value) or varying.differs(index):
                    self._spoil(array, varying.bits(array, index, 1))
                elif varying.parts[array].apart:
                    self._spoil(array, ALL)
            case form.View(part, whole, first):
                self._view(part, whole, first)
            case form.Call():
                self._call(s, apart)
            case form.If(condition, then, otherwise):
                differs = varying.differs(condition)
                regions = (then, otherwise)
                parted = [self._region(r, apart or differs, apart_in_loop or differs) for r in regions]
                return parted[0] | parted[1]
            case form.For():
                return self._for(s, apart)
            case form.While(test, condition, body):
                if varying.differs(condition):
                    varying.loops.add(id(s))
                self._region(test, apart or id(s) in varying.loops, False)
                return self._loop(s, body, apart)
            case form.Break() | form.Continue():
                return _Left(loop=apart_in_loop)
            case form.Return(values):
                varying.results = [
                    before or apart or varying.differs(value)
                    for before, value in zip(varying.results, values, strict=True)
                ]
                return _Left(function=apart)
        return _NONE

    def _note(self, item: form.Value | form.Variable, differs: bool) -> None:
        if differs:
            self.found.numbers.add(item)

    def _spoil(self, array: form.Storage, bits: int) -> None:
        self.found.entries[self.found.parts[array].root] |= bits

    def _view(self, part: form.Storage, whole: form.Storage, first: form.Operand) -> None:
        around = self.found.parts[whole]
        at = None
        if around.first is not None and isinstance(first, form.Immediate):
            at = around.first + int(first.value)
        self.found.parts[part] = _Part(around.root, at, around.apart or self.found.differs(first))

    def _for(self, s: form.For, apart: bool) -> _Left:
        if self.found.differs(s.first) or self.found.differs(s.last):
            self.found.numbers.add(s.counter)
            self.found.loops.add(id(s))
        return self._loop(s, s.body, apart)

    def _loop(self, s: form.For | form.While, body: form.Region, apart: bool) -> _Left:
        left = self._region(body, apart or id(s) in self.found.loops, False)
        if left.loop or left.function:
            self.found.loops.add(id(s))
        return _Left(function=left.function)

    def _call(self, s: form.Call, apart: bool) -> None:
        varying = self.found
        if isinstance(s.function, form.External):
            differ = any(varying.differs(a) for a in s.arguments if not isinstance(a, form.Storage))
            for result in s.results:
                self._note(result, differ or not s.function.pure)
            return
        masked = apart or varying.way.masked
        way = Way(masked, tuple(self._argument(a, p) for a, p in zip(s.arguments, s.function.parameters, strict=True)))
        varying.calls[id(s)] = way
        inside = self.lanes.of(s.function, way)
        for result, differs in zip(s.results, inside.results, strict=True):
            self._note(result, differs)
        for argument, parameter in zip(s.arguments, s.function.parameters, strict=True):
            if isinstance(argument, form.Storage) and isinstance(parameter, form.Storage) and parameter.writable:
                self._behind(argument, inside.entries[parameter])

    def _argument(self, argument: form.Operand | form.Storage, parameter: form.Value | form.Storage) -> bool | ArrayOf:
        varying = self.found
        if not isinstance(argument, form.Storage):
            return varying.differs(argument)
        part, rows = varying.parts[argument], varying.given(argument).rows
        if part.apart:
            return ArrayOf(rows, ALL, True)
        bits = varying.entries[part.root]
        if part.first is None or argument.length is None:
            whole = part.first == 0 and argument.length is None
            return ArrayOf(rows, bits if whole else (ALL if bits else 0))
        return ArrayOf(rows, bits >> part.first & ((1 << argument.length) - 1))

    def _behind(self, argument: form.Storage, bits: int) -> None:
        """Entries that differ after a function has written to an array."""
        part = self.found.parts[argument]
        if not bits:
            return
        if part.first is None or part.apart:
            self._spoil(argument, ALL)
        elif argument.length is None:
            self._spoil(argument, bits << part.first)
        else:
            self._spoil(argument, (bits & ((1 << argument.length) - 1)) << part.first)
