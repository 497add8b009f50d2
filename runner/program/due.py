"""Ticks of a function that is not computed in every tick of the loop."""

from collections.abc import Callable, Iterable
from itertools import groupby
from operator import itemgetter

from proofmass.runner.program.form import Operand
from proofmass.runner.program.frame import Frame

Step = Callable[[], object]


def due(frame: Frame, stride: int) -> Operand:
    """Return whether a tick is one of every so many."""
    left = frame.builder.compute("modulo", frame.tick, stride)
    return frame.builder.compute("equal_integers", left, 0)


def when_due(frame: Frame, steps: Iterable[tuple[int, Step]]) -> None:
    """Write steps, each with the ticks from one time to the next, under the conditions that they are due."""
    for stride, together in groupby(steps, key=itemgetter(0)):
        if stride == 1:
            for _, step in together:
                step()
            continue
        with frame.builder.when(due(frame, stride)):
            for _, step in together:
                step()
