"""The delay margin of a loop with several values of its wire in a period: whole values before the
first too many.

A delay of r values and q periods is a register of r values, and q periods are a factor z^-q at the
wire. So a pole exp(j theta) on the unit circle is one that a factor exp(-j phi) puts there, with q
theta = phi but for whole turns. All such pairs are found for each r. As q grows past phi / theta
the pole leaves the circle, to the side to which it leaves it as phi grows: the unstable poles of
each q are counted.

Where no value of a period depends on an earlier one of it, as behind a demodulator or a decimator,
no register is needed: the late values follow from the states of this period and of the last one.
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.tick_maps import others
from proofmass.runner.host.arrays import Array, Complex

_MOST_VALUES = 24  # in a period of any delay; beyond it, delays up to `_COUNTED` values
_MOST_ENTRIES = 20_000  # of matrices for a turn, where no value depends on an earlier one: a period of any delay too
_COUNTED = 64  # values
_TURNS = 180  # of half the circle
_HALVED = 48  # times that a step of it is
_OUTSIDE = 1.0 + 1e-12
_TRIED = 64  # turns of a pole
_ANY = 1.2345  # a turn at which no pole is on the circle but one that nothing moves
_STILL = 1e-9  # distance from the circle of such a pole
_Parts = tuple[Array, Array, Array, Array]


def delay_margin(system: OpenLoop) -> float | None:
    """Seconds of whole values of the wire before the first that makes the loop unstable; None if none does."""
    values, counted = system.per_period, _counted(system)
    for late in range(1, values if counted is None else counted + 1):
        poles = _poles(_delayed(system.matrices, late), np.zeros(1))
        if np.max(np.abs(poles), initial=0.0) >= _OUTSIDE:
            return (late - 1) * system.sample
    if counted is not None:
        return counted * system.sample
    periods = [_first_unstable(_delayed(system.matrices, late)) for late in range(values)]
    found = [late + values * number for late, number in enumerate(periods) if number is not None]
    return (min(found) - 1) * system.sample if found else None


def only_counted(system: OpenLoop, delay: float) -> bool:
    """Return whether a delay margin is where the counting ended."""
    counted = _counted(system)
    return counted is not None and delay == counted * system.sample


def _counted(system: OpenLoop) -> int | None:
    """Return the values to which delays are counted one by one; None where any delay is looked at."""
    entries = system.per_period * (2 * len(system.matrices[0])) ** 2
    few = entries <= _MOST_ENTRIES and not system.matrices[3].any()
    return None if few or system.per_period <= _MOST_VALUES else _COUNTED


def _delayed(parts: _Parts, late: int) -> _Parts:
    """Return a lifted loop with its wire late by some values."""
    a, b, c, d = parts
    n, p = len(a), len(d)
    if late > p:
        return _delayed(_delayed(parts, p), late - p)
    kept = p - late
    if n < late and not d.any():
        now, before = b[:, late:] @ c[:kept], b[:, :late] @ c[kept:]
        lasting = np.block([[a, np.zeros((n, n))], [np.eye(n), np.zeros((n, n))]])
        return lasting, np.eye(2 * n, n), np.hstack([now, before]), np.zeros((n, n))
    return (
        np.block([[a, np.zeros((n, late))], [c[kept:], np.zeros((late, late))]]),
        np.vstack([b, d[kept:]]),
        np.block([[np.zeros((late, n)), np.eye(late)], [c[:kept], np.zeros((kept, late))]]),
        np.vstack([np.zeros((late, p)), d[:kept]]),
    )


def _poles(parts: _Parts, turns: Array) -> Complex:
    """Return the poles of a period for each turn at the wire, with values of earlier ones."""
    a, b, c, d = parts
    factors = np.exp(-1j * turns)[:, None]
    values = np.zeros((len(turns), *c.shape), dtype=complex)
    for k, row in enumerate(c):
        values[:, k] = row - factors * (d[k, :k] @ values[:, :k])
    return np.asarray(np.linalg.eigvals(a - factors[:, :, None] * (b @ values)), dtype=complex)


def _first_unstable(parts: _Parts) -> int | None:
    """Return the least number of whole periods that makes a stable loop unstable."""
    pairs = _on_circle(parts)
    turns, angles, ways = np.array(pairs).reshape(-1, 3).T
    out = np.flatnonzero(ways > 0.0)
    tried = np.ceil((turns[out, None] + 2.0 * math.pi * np.arange(_TRIED)) / angles[out, None])
    for number in np.unique(np.maximum(tried, 1.0)):
        crossed = np.floor((number * angles - turns) / (2.0 * math.pi)) + 1.0
        if np.sum(ways * np.maximum(crossed, 0.0)) > 0.0:
            return int(number)
    return None


def _on_circle(parts: _Parts) -> list[tuple[float, float, float]]:
    """Return turns at the wire, the angle of the pole in the upper half that each puts on the circle, and its way.

    The turn back puts the conjugate pole there. All poles outside the circle count: a turn by pi
    takes real ones from one half to the other.
    """
    grid = np.linspace(0.0, math.pi, _TURNS + 1)
    (any_turn,) = _poles(parts, np.array([_ANY]))
    still = any_turn[np.abs(np.abs(any_turn) - 1.0) < _STILL].tolist()  # whatever the wire does
    counts = [_outside(poles, still) for poles in _poles(parts, grid)]
    pairs = list[tuple[float, float, float]]()
    for (turn, high), (count, last) in zip(pairwise(grid.tolist()), pairwise(counts), strict=True):
        while count != last and turn < high:
            before = count
            turn, pole, count = _crossing(parts, still, turn, high, before)
            angle, way = float(np.angle(pole)), math.copysign(1.0, count - before)
            pairs.append((turn, angle, way) if angle > 0.0 else (2.0 * math.pi - turn, -angle, -way))
    return pairs


def _outside(poles: Complex, still: Sequence[complex]) -> int:
    """Return how many poles lie outside the circle, without those that nothing moves."""
    return int(np.sum(np.abs(others(poles, still)) > 1.0))


def _crossing(
    parts: _Parts, still: Sequence[complex], low: float, high: float, before: int
) -> tuple[float, complex, int]:
    """Return the turn at which the number of poles outside changes first, the pole on the circle there, and
    the number."""
    for _ in range(_HALVED):
        middle = 0.5 * (low + high)
        outside = _outside(_poles(parts, np.array([middle]))[0], still)
        low, high = (middle, high) if outside == before else (low, middle)
    poles = others(_poles(parts, np.array([high]))[0], still)
    return high, complex(poles[np.argmin(np.abs(np.abs(poles) - 1.0))]), _outside(poles, ())
