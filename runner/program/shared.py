"""Large functions that a program has once, in place of a copy wherever they are called.

A copy is faster where it always runs, and takes the compiler as long as it is large. So what is large is shared if it
is called in branches alone, or would be there too often.
"""

from collections import Counter
from collections.abc import Iterator

from proofmass.runner.program.form import Call, Function, If, Program, Region
from proofmass.runner.program.walk import regions

_LARGE = 250  # statements, with those of the inline functions that are called
_MOST = 1500  # statements of all copies


def shared(program: Program) -> frozenset[Function]:
    """Return the inline functions that are better shared."""
    calls = {function: list(_calls(function.body, False)) for function in program.functions.values()}
    always = {called for inner in calls.values() for called, rare in inner if not rare}
    sizes, together = dict[Function, int](), set[Function]()
    for function, inner in calls.items():  # those that are called come first
        inline = (called for called, _ in inner if called.inline and called not in together)
        sizes[function] = _size(function.body) + sum(sizes[called] for called in inline)
        if function.inline and function not in always and sizes[function] > _LARGE:
            together.add(function)
    copies = Counter[Function]()
    for function in reversed(calls):
        if function.inline and sizes[function] > _LARGE and copies[function] * sizes[function] > _MOST:
            together.add(function)
        for called, _ in calls[function]:
            copies[called] += copies[function] if function.inline and function not in together else 1
    return frozenset(together)


def _calls(region: Region, rare: bool) -> Iterator[tuple[Function, bool]]:
    """Functions that a region calls, and whether in a branch."""
    for statement in region:
        if isinstance(statement, Call) and isinstance(statement.function, Function):
            yield statement.function, rare
        for inner in regions(statement):
            yield from _calls(inner, rare or isinstance(statement, If))


def _size(region: Region) -> int:
    return sum(1 + sum(map(_size, regions(statement))) for statement in region)
