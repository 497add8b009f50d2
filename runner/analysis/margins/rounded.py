"""Digits of the figures of a loop that are known where rounding of its numbers moves them."""

import math
from dataclasses import replace
from itertools import chain

import numpy as np

from proofmass.runner.analysis.linearisation.rounded import NEAR, known_note, moved_maps, nearest_mode
from proofmass.runner.analysis.margins.margins import Margins, margins_at

_LARGEST = 64  # states of which the open loop's poles are looked at


def with_rounding(found: Margins) -> Margins:
    """Return the margins of a loop, with a note on how well they are known where that is less than what is shown."""
    system, apart = found.system, math.inf if found.system.continuous else _apart(found)
    if not apart < NEAR:
        return found
    others = (replace(system, map=other) for other in moved_maps(system.map))
    moved = (_figures(margins_at(other, found.loop, found.open_at)) for other in others)
    note = known_note(_figures(found), moved, apart)
    return replace(found, system=system.noted(note)) if note else found


def _apart(found: Margins) -> float:
    """Return how near to the unit circle a mode comes, with the loop open or closed."""
    system, small = found.system, len(found.system.map.states) <= _LARGEST
    opened = np.linalg.eigvals(system.matrices[0]) if small and system.map.ticks is None else ()
    return nearest_mode(np.array([*found.poles, *opened], dtype=complex))


def _figures(of: Margins) -> list[float | None]:
    figures = of.gain_margin, of.gain_reduction, of.phase_margin, of.delay_margin
    return list(chain([of.slowest[0].distance], figures, *of.stable_gains))
