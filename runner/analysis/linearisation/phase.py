"""Phase of a response, counted on over frequency with all of its turns.

The angles at two frequencies tell the turn between them but for whole turns. The slopes of the
phase there tell it roughly, as those of a delay do however often it turns. Where both do not agree,
the middle is looked at too. A gain that goes there on a straight line, as about a zero, turns by
the angles alone.

At rest it is 0 or pi where the gain is finite there. Each integrator takes pi / 2 from that, and
each zero at rest adds as much: their number follows from the slope of the gain.
"""

import cmath
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array, Complex, Truths

_BESIDE = 1e-3  # part of the way to the next frequency over which a slope is taken
_SURE = 0.5  # rad by which turns by slopes and by angles differ at most
_STRAIGHT = 1e-2  # part of a gain by which it may miss the middle of a straight line
_LOWEST = -0.75 * math.pi  # of what is 0 or pi but for rounding
_Answer = Callable[[Array], Complex]


def counted_phase(answer: _Answer, frequencies: Array, gains: Complex) -> Array:
    """Return the phase in radians at frequencies in order, counted from rest.

    Where a gain is zero, or infinite, the phase is that at the frequency before.
    """
    known = np.flatnonzero(np.isfinite(gains) & (gains != 0.0))
    if not len(known):
        return np.zeros(len(frequencies))
    w, g = frequencies[known], gains[known]
    phase = np.cumsum([_first(answer, float(w[0]), complex(g[0])), *_turns(answer, w, g)])
    return np.asarray(phase[np.maximum(np.searchsorted(known, np.arange(len(frequencies)), side="right") - 1, 0)])


def _first(answer: _Answer, w: float, gain: complex) -> float:
    """Return the phase at the lowest frequency, whose slope leads to rest."""
    if w == 0.0:
        return math.pi * (gain.real < 0.0)
    own, ratio = cmath.phase(gain), complex(answer(np.array([w * (1.0 + _BESIDE)]))[0]) / gain
    if ratio == 0.0 or not cmath.isfinite(ratio):
        return own
    order = 0.5 * math.pi * round(math.log(abs(ratio)) / math.log1p(_BESIDE))
    later = cmath.phase(ratio) / _BESIDE
    sign = (own - later - order - _LOWEST) % (2.0 * math.pi) + _LOWEST
    return own + 2.0 * math.pi * round((order + sign + later - own) / (2.0 * math.pi))


class _Pieces(NamedTuple):
    """Parts of the axis between frequencies, with the number of the first one and the gains at both ends."""

    of: Indices
    low: Array
    high: Array
    before: Complex
    after: Complex

    def chosen(self, which: Truths) -> "_Pieces":
        """Return some of them."""
        return _Pieces(self.of[which], self.low[which], self.high[which], self.before[which], self.after[which])


def _turns(answer: _Answer, w: Array, g: Complex) -> Array:
    """Return by how much the phase turns from each frequency to the next."""
    turns = np.zeros(len(w) - 1)
    left = _Pieces(np.arange(len(turns)), w[:-1], w[1:], g[:-1], g[1:])
    while len(left.of):
        turn, rough = _turn(left.before, left.after), _by_slopes(answer, left)
        whole = turn + 2.0 * math.pi * np.round((rough - turn) / (2.0 * math.pi))
        told = np.abs(whole - rough) <= _SURE
        np.add.at(turns, left.of[told], whole[told])
        left, turn = left.chosen(~told), turn[~told]
        middle = 0.5 * (left.low + left.high)
        between = answer(middle)
        with np.errstate(invalid="ignore"):
            bent = np.abs(between - 0.5 * (left.before + left.after))
        straight = ~(bent > _STRAIGHT * np.maximum(np.abs(left.before), np.abs(left.after)))  # not a number at a pole
        straight |= (middle <= left.low) | (middle >= left.high)
        np.add.at(turns, left.of[straight], turn[straight])
        halves = left._replace(high=middle, after=between), left._replace(low=middle, before=between)
        left = _Pieces(*map(np.concatenate, zip(*(half.chosen(~straight) for half in halves), strict=True)))
    return turns


def _by_slopes(answer: _Answer, of: _Pieces) -> Array:
    """Return roughly how much the phase turns over pieces: by the slopes at both ends."""
    beside = _BESIDE * (of.high - of.low)
    both = _turn(of.before, answer(of.low + beside)) + _turn(answer(of.high - beside), of.after)
    return np.asarray(both / (2.0 * _BESIDE))


def _turn(before: Complex, after: Complex) -> Array:
    """Return the angle from one number to another, within half a turn."""
    return np.asarray((np.angle(after) - np.angle(before) + math.pi) % (2.0 * math.pi) - math.pi)
