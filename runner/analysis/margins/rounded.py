"""Digits of the figures of a loop that are known where rounding of its numbers moves them.

A mode that hardly decays, such as that of a resonator of high quality in a fast loop, is told from the boundary of
stability by the last digits of a map: of 1 - |p| = 3e-12 doubles carry four. Its figures are taken again with each
number of the map moved by half its last digit, up or down at random, and equal ones alike.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.poles import inexact
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from proofmass.runner.analysis.margins.margins import Margins, margins_at

_NEAR = 1e-9  # distance from the boundary, below which figures may lose digits that are shown
_AT_REST = 1e-7  # distance from one, within which a pole is an integrator or a slow mode of one number
_SHOWN = 5e-6  # part of a figure, of which five digits are shown
_TRIED = 8  # times that all numbers are moved
_LARGEST = 64  # states of which the open loop's poles are looked at
_HALF = 2.0**-53


def with_rounding(found: Margins) -> Margins:
    """Return the margins of a loop, with a note on how well they are known where that is less than what is shown."""
    system, apart = found.system, math.inf if found.system.continuous else _apart(found)
    if not apart < _NEAR:
        return found
    random = np.random.default_rng(0)
    others = (replace(system, map=_moved(system.map, random)) for _ in range(_TRIED))
    part = max(_differs(found, margins_at(other, found.loop, found.open_at)) for other in others)
    if part <= _SHOWN:
        return found
    told = f"known to {100.0 * part:.1g} % only" if part < 1.0 else "not known"
    note = f"figures are {told}: a mode is {apart:.1g} from the boundary of stability, and rounding moves it"
    return replace(found, system=replace(system, map=replace(system.map, notes=(*system.map.notes, note))))


def _apart(found: Margins) -> float:
    """Return how near to the unit circle a mode comes, with the loop open or closed, that is no integrator."""
    system, small = found.system, len(found.system.map.states) <= _LARGEST
    opened = np.linalg.eigvals(system.matrices[0]) if small and system.map.ticks is None else found.poles
    poles = np.concatenate([found.poles, opened])
    return float(np.min(np.abs(1.0 - np.abs(poles))[np.abs(poles - 1.0) > _AT_REST], initial=math.inf))


def _moved(of: PeriodMap, random: np.random.Generator) -> PeriodMap:
    """Return a map with all its numbers half a last digit off, equal ones alike."""
    arrays = [of.matrix] if of.ticks is None else [of.ticks.a, of.ticks.b, of.ticks.c, of.ticks.d]
    numbers, places = np.unique(np.concatenate([array.ravel() for array in arrays]), return_inverse=True)
    numbers = numbers + _HALF * numbers * inexact(numbers) * random.choice([-1.0, 1.0], numbers.shape)
    parts = np.split(numbers[places], np.cumsum([array.size for array in arrays])[:-1])
    first, *others = (part.reshape(array.shape) for part, array in zip(parts, arrays, strict=True))
    if of.ticks is None:
        return replace(of, matrix=first)
    b, c, d = others
    return replace(of, ticks=TickMaps(first, b, c, d, of.ticks.places))


def _differs(found: Margins, other: Margins) -> float:
    """Return by what part the figures of two loops differ most; infinity where one has others."""
    first, second = list(_figures(found)), list(_figures(other))
    if [one is None for one in first] != [one is None for one in second]:
        return math.inf
    pairs = ((one, two) for one, two in zip(first, second, strict=True) if one is not None and two is not None)
    return max((abs(one - two) / abs(one) for one, two in pairs if one and math.isfinite(one)), default=0.0)


def _figures(of: Margins) -> Iterator[float | None]:
    return chain(
        [of.slowest[0].distance, of.gain_margin, of.gain_reduction, of.phase_margin, of.delay_margin], *of.stable_gains
    )
