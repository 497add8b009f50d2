"""Large functions that a program has once, in place of a copy wherever they are called.

A copy is faster where it always runs, and takes the compiler as long as it is large. So what is
large is shared if it is called in branches alone, or would be there too often.
"""

from collections import Counter
from typing import NamedTuple
from weakref import WeakKeyDictionary

from proofmass.runner.program.form import Call, For, Function, If, Program, Region, While

_LARGE = 250  # statements, with those of the inline functions that are called
_MOST = 1500  # statements of all copies
_known: "WeakKeyDictionary[Function, Outline]" = WeakKeyDictionary()


class Outline(NamedTuple):
    """The number of a function's statements, and what it calls, and whether in a branch."""

    size: int
    calls: tuple[tuple[Function, bool], ...]


def outline(function: Function) -> Outline:
    """Return the outline of a function that is written to its end, which is read once."""
    own = _known.get(function)
    if own is None:
        calls: list[tuple[Function, bool]] = []
        own = _known[function] = Outline(_read(function.body, False, calls), tuple(calls))
    return own


def _read(region: Region, rare: bool, calls: list[tuple[Function, bool]]) -> int:
    """Add what a region calls; returns its number of statements."""
    size = len(region)
    for statement in region:
        match statement:
            case Call(_, Function() as called):
                calls.append((called, rare))
            case If(_, then, otherwise):
                size += _read(then, True, calls) + _read(otherwise, True, calls)
            case For() | While():
                test = statement.test if isinstance(statement, While) else []
                size += _read(test, rare, calls) + _read(statement.body, rare, calls)
    return size


def shared(program: Program) -> frozenset[Function]:
    """Return the inline functions that are better shared."""
    outlines = {function: outline(function) for function in program.functions.values()}
    always = {called for each in outlines.values() for called, rare in each.calls if not rare}
    sizes, together = dict[Function, int](), set[Function]()
    for function, (size, calls) in outlines.items():  # those that are called come first
        sizes[function] = size + sum(sizes[called] for called, _ in calls if called.inline and called not in together)
        if function.inline and function not in always and sizes[function] > _LARGE:
            together.add(function)
    copies = Counter[Function]()
    for function in reversed(outlines):
        if function.inline and sizes[function] > _LARGE and copies[function] * sizes[function] > _MOST:
            together.add(function)
        for called, _ in outlines[function].calls:
            copies[called] += copies[function] if function.inline and function not in together else 1
    return frozenset(together)
