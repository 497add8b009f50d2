"""Digits of the figures of a loop that are known where rounding of its numbers moves them.

A mode that hardly decays, such as that of a resonator of high quality in a fast loop, is told from the boundary of
stability by the last digits of a map: of 1 - |p| = 3e-12 doubles carry four. Its figures are taken again with each
number of the map moved by half its last digit, up or down at random.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import chain

import numpy as np

from proofmass.runner.analysis.linearisation.poles import inexact
from proofmass.runner.analysis.margins.margins import Margins, margins_at

_NEAR = 1e-9  # distance from the boundary, below which figures may lose digits that are shown
_AT_REST = 1e-7  # distance from one, within which a pole is an integrator or a slow mode of one number
_SHOWN = 5e-6  # part of a figure, of which five digits are shown
_TRIED = 8  # times that all numbers are moved
_LARGEST = 64  # states
_HALF = 2.0**-53


def with_rounding(found: Margins) -> Margins:
    """Return the margins of a loop, with a note on how well they are known where that is less than what is shown."""
    system = found.system
    if system.continuous or system.map.ticks is not None or len(system.map.states) > _LARGEST:
        return found
    poles = np.concatenate([system.poles, np.linalg.eigvals(system.matrices[0])])
    apart = np.abs(1.0 - np.abs(poles))[np.abs(poles - 1.0) > _AT_REST]
    if not (apart < _NEAR).any():
        return found
    matrix, random = system.map.matrix, np.random.default_rng(0)
    moved = _HALF * matrix * inexact(matrix)
    maps = (
        replace(system.map, matrix=matrix + random.choice([-1.0, 1.0], matrix.shape) * moved) for _ in range(_TRIED)
    )
    others = [margins_at(replace(system, map=other), found.loop, found.open_at) for other in maps]
    part = max(_differs(found, other) for other in others)
    if part <= _SHOWN:
        return found
    told = f"known to {100.0 * part:.1g} % only" if part < 1.0 else "not known"
    note = f"figures are {told}: a mode is {apart.min():.1g} from the boundary of stability, and rounding moves it"
    return replace(found, system=replace(system, map=replace(system.map, notes=(*system.map.notes, note))))


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
