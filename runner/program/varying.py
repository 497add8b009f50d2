"""What differs between runs side by side, of all that a function computes.

A value differs where anything that it follows from does: an operand, the entry that it is loaded from, or the condition
under which it is set. A function that is called may pass on all that it is given to all that it returns or writes.
"""

from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from typing import Any

from proofmass.runner.program.form import (
    Array,
    Call,
    Compute,
    Constant,
    External,
    For,
    Function,
    Get,
    If,
    Load,
    Region,
    Return,
    Set,
    Store,
    Value,
    Variable,
    View,
    While,
)

Entry = tuple[Array, int]  # of an array of many numbers that are told apart


@dataclass
class Varying:
    """Values, variables and arrays that differ from run to run, and entries of arrays whose entries are told apart."""

    things: set[Value | Variable | Array] = field(default_factory=set)
    entries: set[Entry] = field(default_factory=set)

    def __contains__(self, thing: object) -> bool:
        return thing in self.things or thing in self.entries


def varying(function: Function, apart: Collection[Array], sources: Collection[Value | Array | Entry]) -> Varying:
    """What differs in a function, where the sources do: parameters, arrays, entries of arrays that stand `apart`.

    These are read and written at constant places only, in this function and not in those that it calls.
    """
    found = Varying()
    for source in sources:
        (found.entries if isinstance(source, tuple) else found.things).add(source)  # type: ignore[arg-type]
    closure = _Closure(found, frozenset(apart))
    while closure.grows:
        closure.grows = False
        closure.region(function.body, False)
    return found


class _Closure:
    """One pass over a function after the other, until nothing new is found to differ."""

    def __init__(self, found: Varying, apart: frozenset[Array]) -> None:
        self.found, self.apart = found, apart
        self.wholes: dict[Array, Array] = {}  # what views are parts of
        self.grows = True

    def region(self, region: Region, under: bool) -> None:
        """Statements, executed under a condition that differs or not."""
        for statement in region:
            match statement:
                case Compute(result, _, operands):
                    self.note(result, under or any(map(self.differs, operands)))
                case Get(result, variable):
                    self.note(result, self.differs(variable))
                case Set(variable, value):
                    self.note(variable, under or self.differs(value))
                case Load(result, array, index):
                    self.note(result, self.differs(index) or self.loaded(array, index))
                case Store(array, index, value):
                    self.store(array, index, under or self.differs(value) or self.differs(index))
                case View(part, whole, first):
                    self.wholes[part] = whole
                    self.note(part, self.differs(first) or self.viewed(part, whole, first))
                case Call():
                    self.call(statement, under)
                case If(condition, then, otherwise):
                    apart = under or self.differs(condition)
                    self.region(then, apart)
                    self.region(otherwise, apart)
                case For(counter, first, last, _, body):
                    apart = under or self.differs(first) or self.differs(last) or self.leaves(body)
                    self.note(counter, apart)
                    self.region(body, apart)
                case While(test, condition, body):
                    apart = under or self.differs(condition) or self.leaves(body)
                    self.region(test, apart)
                    self.region(body, apart)

    def leaves(self, body: Region) -> bool:
        """Whether a loop may be left in one run and not in another."""
        return any(self._leaves(body, False))

    def _leaves(self, body: Region, under: bool) -> Iterator[bool]:
        for statement in body:
            match statement:
                case If(condition, then, otherwise):
                    apart = under or self.differs(condition)
                    yield from self._leaves(then, apart)
                    yield from self._leaves(otherwise, apart)
                case For() | While():
                    pass
                case Compute() | Get() | Set() | Load() | Store() | View() | Call():
                    pass
                case _:
                    yield under or isinstance(statement, Return)

    def call(self, statement: Call, under: bool) -> None:
        """A call: all that it returns or writes follows from all that it is given."""
        apart = under or any(map(self.differs, statement.arguments))
        if isinstance(statement.function, External):
            apart = apart or not statement.function.pure
        for result in statement.results:
            self.note(result, apart)
        if isinstance(statement.function, Function) and apart:
            for parameter, given in zip(statement.function.parameters, statement.arguments, strict=True):
                if isinstance(parameter, Array) and parameter.writable and isinstance(given, Array):
                    self.spread(given)

    def differs(self, thing: Any) -> bool:
        """Whether something is known to differ."""
        return not isinstance(thing, Constant) and thing in self.found.things

    def loaded(self, array: Array, index: Any) -> bool:
        """Whether what is loaded differs."""
        if array in self.apart and isinstance(index, Constant):
            return (array, int(index.value)) in self.found.entries
        return array in self.found.things

    def viewed(self, part: Array, whole: Array, first: Any) -> bool:
        """Whether a part of an array differs."""
        if whole in self.apart and isinstance(first, Constant) and part.length is not None:
            begin = int(first.value)
            return any((whole, place) in self.found.entries for place in range(begin, begin + part.length))
        return whole in self.found.things and whole not in self.apart

    def store(self, array: Array, index: Any, differs: bool) -> None:
        """What is written into an array."""
        if array in self.apart and isinstance(index, Constant):
            if differs and (array, int(index.value)) not in self.found.entries:
                self.found.entries.add((array, int(index.value)))
                self.grows = True
        elif differs:
            self.spread(array)

    def spread(self, array: Array) -> None:
        """An array differs; of what it is a part of, only the part does where parts never overlap."""
        self.note(array, True)
        whole = self.wholes.get(array)
        if whole is not None and whole not in self.apart:
            self.spread(whole)

    def note(self, thing: Any, differs: bool) -> None:
        """Something is found to differ or not."""
        if differs and thing not in self.found.things:
            self.found.things.add(thing)
            self.grows = True
