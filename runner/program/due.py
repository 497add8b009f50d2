"""Ticks of a function that is not computed in every tick of the loop."""

from collections.abc import Callable, Iterable
from itertools import groupby
from operator import itemgetter

from proofmass.graphs.checks.schedule import Beat
from proofmass.runner.program.form import Operand
from proofmass.runner.program.frame import Frame

DueStep = Callable[[], object]


def due(frame: Frame, beat: Beat) -> Operand:
    """Return whether a tick is one of a beat."""
    left = frame.builder.compute("modulo", frame.tick, beat.stride)
    return frame.builder.compute("equal_integers", left, beat.phase)


def when_due(frame: Frame, steps: Iterable[tuple[Beat, DueStep]]) -> None:
    """Write steps, each with its beat, under the conditions that they are due."""
    for beat, together in groupby(steps, key=itemgetter(0)):
        if beat.stride == 1:
            for _, step in together:
                step()
            continue
        with frame.builder.when(due(frame, beat)):
            for _, step in together:
                step()
