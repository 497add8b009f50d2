"""Maps whose numbers are half a last digit off, by which figures tell how well they are known.

A mode that hardly decays, such as that of a resonator of high quality in a fast loop, is told from the boundary of
stability by the last digits of a map: of 1 - |p| = 3e-12 doubles carry four.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import inexact
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from proofmass.runner.host.arrays import Complex

NEAR = 1e-9  # distance of a mode from the unit circle, below which figures may lose digits that are shown
_AT_REST = 1e-7  # distance from one, within which a pole is an integrator or a slow mode of one number
_SHOWN = 5e-6  # part of a figure, of which five digits are shown
_TRIED = 8  # times that all numbers are moved
_HALF = 2.0**-53


def nearest_mode(poles: Complex) -> float:
    """Return how near to the unit circle a pole comes that is no integrator."""
    return float(np.min(np.abs(1.0 - np.abs(poles))[np.abs(poles - 1.0) > _AT_REST], initial=math.inf))


def moved_maps(of: PeriodMap) -> Iterator[PeriodMap]:
    """Yield a map again and again, with all its numbers half a last digit up or down at random, equal ones alike."""
    arrays = [of.matrix] if of.ticks is None else [of.ticks.a, of.ticks.b, of.ticks.c, of.ticks.d]
    numbers, places = np.unique(np.concatenate([array.ravel() for array in arrays]), return_inverse=True)
    half, ends = _HALF * numbers * inexact(numbers), np.cumsum([array.size for array in arrays])[:-1]
    random = np.random.default_rng(0)
    for _ in range(_TRIED):
        moved = np.split((numbers + half * random.choice([-1.0, 1.0], half.shape))[places], ends)
        first, *others = (part.reshape(array.shape) for part, array in zip(moved, arrays, strict=True))
        if of.ticks is None:
            yield replace(of, matrix=first)
        else:
            b, c, d = others
            yield replace(of, ticks=TickMaps(first, b, c, d, of.ticks.places))


def known_note(figures: Sequence[float | None], others: Iterator[Sequence[float | None]], apart: float) -> str:
    """Return a note on how well figures are known, by those of moved maps; "" where all digits that are shown are."""
    part = max(_differ(figures, other) for other in others)
    if part <= _SHOWN:
        return ""
    told = f"known to {100.0 * part:.1g} % only" if part < 1.0 else "not known"
    return f"figures are {told}: a mode is {apart:.1g} from the boundary of stability, and rounding moves it"


def _differ(first: Sequence[float | None], second: Sequence[float | None]) -> float:
    """Return by what part figures differ most; infinity where one has others."""
    if [one is None for one in first] != [one is None for one in second]:
        return math.inf
    pairs = ((one, two) for one, two in zip(first, second, strict=True) if one is not None and two is not None)
    return max((abs(one - two) / abs(one) for one, two in pairs if one and math.isfinite(one)), default=0.0)
