"""Loops of which the turns are written one behind the other."""

from collections.abc import Iterable

from proofmass.runner.program.form import Compute, Constant, For, Get, Set, Statement, Value, Variable
from proofmass.runner.program.walk import statements

_MOST = 600  # statements of all turns of a loop that is written out


def written_out(loop: For) -> bool:
    """Return whether a loop has a few known turns, each of which computes from the last.

    What follows from constants alone is then computed before the ticks. Turns that need nothing of each other stay a
    loop, of which LLVM makes vectors.
    """
    if not (isinstance(loop.first, Constant) and isinstance(loop.last, Constant)):
        return False
    inside = list(statements(loop.body))
    turns = -(-(int(loop.last.value) - int(loop.first.value)) // loop.step)
    return turns * len(inside) <= _MOST and _carries(inside)


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
