"""Phase of a response, counted on over frequency with all of its turns.

The angles at two frequencies tell the turn between them but for whole turns. The slopes of the
phase there tell it roughly, as those of a delay do however often it turns. Where both do not agree,
the middle is looked at too. A gain that goes there on a straight line, as about a zero, turns by
the angles alone.
"""

import math
from collections.abc import Callable

import numpy as np

from proofmass.runner.host.arrays import Array, Complex

_BESIDE = 1e-3  # part of the way to the next frequency over which a slope is taken
_SURE = 0.5  # rad by which turns by slopes and by angles differ at most
_STRAIGHT = 1e-2  # part of a gain by which it may miss the middle of a straight line
_Answer = Callable[[Array], Complex]


def counted_phase(answer: _Answer, frequencies: Array, gains: Complex) -> Array:
    """Return the phase in radians at frequencies in order; the first one is that of its gain, at rest 0 or pi.

    Where a gain is zero the phase is that at the frequency before.
    """
    known = np.flatnonzero(gains)
    if not len(known):
        return np.zeros(len(frequencies))
    w, g = frequencies[known], gains[known]
    first = math.pi * (g[0].real < 0.0) if w[0] == 0.0 else float(np.angle(g[0]))
    phase = np.cumsum([first, *_turns(answer, w, g)])
    return np.asarray(phase[np.maximum(np.searchsorted(known, np.arange(len(frequencies)), side="right") - 1, 0)])


def _turns(answer: _Answer, w: Array, g: Complex) -> Array:
    """Return by how much the phase turns from each frequency to the next."""
    turns, of = np.zeros(len(w) - 1), np.arange(len(w) - 1)
    low, high, before, after = w[:-1], w[1:], g[:-1], g[1:]
    while len(of):
        beside, middle = _BESIDE * (high - low), 0.5 * (low + high)
        turn = _turn(before, after)
        rough = (_turn(before, answer(low + beside)) + _turn(answer(high - beside), after)) / (2.0 * _BESIDE)
        whole = 2.0 * math.pi * np.round((rough - turn) / (2.0 * math.pi))
        told = np.abs(turn + whole - rough) <= _SURE
        np.add.at(turns, of[told], (turn + whole)[told])
        of, low, middle, high, before, after, turn = (
            each[~told] for each in (of, low, middle, high, before, after, turn)
        )
        between = answer(middle)
        bent = np.abs(between - 0.5 * (before + after))
        straight = bent <= _STRAIGHT * np.maximum(np.abs(before), np.abs(after))
        np.add.at(turns, of[straight], turn[straight])
        of, low, middle, high, before, between, after = (
            each[~straight] for each in (of, low, middle, high, before, between, after)
        )
        of, low, high = np.append(of, of), np.append(low, middle), np.append(middle, high)
        before, after = np.append(before, between), np.append(between, after)
    return turns


def _turn(before: Complex, after: Complex) -> Array:
    """Return the angle from one number to another, within half a turn."""
    return np.asarray(np.angle(after * before.conj()))
