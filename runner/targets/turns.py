"""Loops of which the turns are written one behind the other."""

from collections.abc import Iterable

from proofmass.runner.program.form import Compute, For, Get, Immediate, Set, Statement, Value, Variable
from proofmass.runner.program.walk import statements

_MOST = 600  # statements of all turns of a loop that is written out


def written_out(loop: For) -> range | None:
    """Return the counters of a loop of a few known turns, each of which computes from the last;
    None for other loops.

    What follows from constants alone is then computed before the ticks. Turns that need nothing of
    each other stay a loop, of which LLVM makes vectors.
    """
    if not (isinstance(loop.first, Immediate) and isinstance(loop.last, Immediate)):
        return None
    first, last = int(loop.first.value), int(loop.last.value)
    inside = list(statements(loop.body))
    few = -(-(last - first) // loop.step) * len(inside) <= _MOST
    return range(first, last, loop.step) if few and _carries(inside) else None


def _carries(inside: Iterable[Statement]) -> bool:
    """Return whether a turn reads a variable that the turn before has computed."""
    computed, read, written = set[Value](), set[Variable](), set[Variable]()
    for statement in inside:
        match statement:
            case Compute(result):
                computed.add(result)
            case Get(_, variable) if variable not in written:
                read.add(variable)
            case Set(variable, value):
                written.add(variable)
                if variable in read and value in computed:
                    return True
    return False
