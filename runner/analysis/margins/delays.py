"""The delay margin of a loop with several values of its wire in a period: whole values before the
first too many.

A delay of r values and q periods is a register of r values, and q periods are a factor z^-q at the
wire. So a pole exp(j theta) on the unit circle is one that a factor exp(-j phi) puts there, with q
theta = phi but for whole turns. All such pairs are found for each r. As q grows past phi / theta
the pole leaves the circle, to the side to which it leaves it as phi grows: the unstable poles of
each q are counted.

Where no value of a period depends on an earlier one of it, as behind a demodulator or an average,
no register is needed, and the pairs are those of `LateValues`. Of many values that depend on each
other, loops of many delays are followed (`followed_delays`).
"""

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps, others
from proofmass.runner.analysis.margins.followed_delays import NEAR, stable_delay
from proofmass.runner.analysis.margins.late_values import HALF_TURN, CircleCrossing, LateValues, at_half_turn
from proofmass.runner.host.arrays import Array, Complex

_MOST_VALUES = 24  # in a period of any delay, where they depend on each other
_COUNTED, _FOLLOWED = 64, 4_096  # values of longer periods, without crossovers or ticks known one by one, and with both
_TURNS = 180  # of half the circle
_HALVED = 48  # times that a step of it is
_OUTSIDE = 1.0 + 1e-12
_TRIED = 64  # turns of a pole
_ANY = 1.2345  # a turn at which no pole is on the circle but one that nothing moves
_STILL = 1e-9  # distance from the circle of such a pole
_Parts = tuple[Array, Array, Array, Array]


def delay_margin(system: OpenLoop, crossovers: Sequence[float]) -> float | None:
    """Seconds of whole values of the wire before the first that makes the loop unstable; None if none does.

    Take the gain crossovers in Hz.
    """
    parts, values, apart = system.matrices, system.per_period, LateValues.of(system)
    longest = longest_delay(system, crossovers, apart)
    if longest:
        return _nearest(parts, longest, system.map.ticks) * system.sample
    sizes = (_size(_delayed(parts, late)) for late in range(1, values)) if apart is None else apart.sizes()
    for before, size in enumerate(sizes):
        if size >= _OUTSIDE:
            return before * system.sample
    turned = (_on_circle(_delayed(parts, late)) for late in range(values))
    periods = map(_first_unstable, turned if apart is None else apart.on_circle())
    found = [late + values * number for late, number in enumerate(periods) if number is not None]
    return (min(found) - 1) * system.sample if found else None


def longest_delay(system: OpenLoop, crossovers: Sequence[float], apart: LateValues | None) -> int:
    """Return the longest delay that is looked at, in values; 0 if all are.

    A turn at the lowest crossover is more than any margin that the loop has there.
    """
    if apart is not None or system.per_period <= _MOST_VALUES:
        return 0
    if system.map.ticks is None or not crossovers:
        return _COUNTED
    return int(np.clip(1.0 / (min(crossovers) * system.sample), _COUNTED, _FOLLOWED))


def is_at_least(system: OpenLoop, crossovers: Sequence[float], delay: float) -> bool:
    """Return whether a delay margin is the longest delay that was looked at."""
    return delay == longest_delay(system, crossovers, LateValues.of(system)) * system.sample


def _nearest(parts: _Parts, longest: int, ticks: TickMaps | None) -> int:
    """Return the number of values before the first delay that makes the loop unstable, or the longest.

    It is the first from zero on, or from where loops that are followed become unstable: there poles
    of few registers tell it.
    """
    delay = 0 if ticks is None else stable_delay(ticks, longest)
    if delay >= NEAR:
        return delay
    while delay and _size(_delayed(parts, delay)) >= _OUTSIDE:
        delay -= 1
    while delay < longest and _size(_delayed(parts, delay + 1)) < _OUTSIDE:
        delay += 1
    return delay


def _delayed(parts: _Parts, late: int) -> _Parts:
    """Return a lifted loop with its wire late by some values, with a register for each."""
    a, b, c, d = parts
    n, p = len(a), len(d)
    if late > p:
        return _delayed(_delayed(parts, p), late - p)
    kept = p - late
    return (
        np.block([[a, np.zeros((n, late))], [c[kept:], np.zeros((late, late))]]),
        np.vstack([b, d[kept:]]),
        np.block([[np.zeros((late, n)), np.eye(late)], [c[:kept], np.zeros((kept, late))]]),
        np.vstack([np.zeros((late, p)), d[:kept]]),
    )


def _size(parts: _Parts) -> float:
    """Return the size of the slowest pole."""
    return float(np.max(np.abs(_poles(parts, np.zeros(1))), initial=0.0))


def _poles(parts: _Parts, turns: Array) -> Complex:
    """Return the poles of a period for each turn at the wire, with values of earlier ones."""
    a, b, c, d = parts
    factors = np.exp(-1j * turns)[:, None]
    values = np.zeros((len(turns), *c.shape), dtype=complex)
    for k, row in enumerate(c):
        values[:, k] = row - factors * (d[k, :k] @ values[:, :k])
    return np.asarray(np.linalg.eigvals(a - factors[:, :, None] * (b @ values)), dtype=complex)


def _first_unstable(pairs: Sequence[CircleCrossing]) -> int | None:
    """Return the least number of whole periods that makes a stable loop unstable."""
    turns, angles, ways = np.array(pairs).reshape(-1, 3).T / [[2.0 * math.pi], [2.0 * math.pi], [1.0]]
    out = np.flatnonzero(ways > 0.0)
    tried = np.ceil((turns[out, None] + np.arange(_TRIED)) / angles[out, None])
    for number in np.unique(np.maximum(tried, 1.0)):
        crossed = np.floor(number * angles - turns) + 1.0
        if np.sum(ways * np.maximum(crossed, 0.0)) > 0.0:
            return int(number)
    return None


def _on_circle(parts: _Parts) -> list[CircleCrossing]:
    """Return turns at the wire that put a pole on the circle.

    The turn back puts the conjugate pole there.
    """
    grid = np.linspace(0.0, math.pi, _TURNS + 1)
    (any_turn,) = _poles(parts, np.array([_ANY]))
    still = any_turn[np.abs(np.abs(any_turn) - 1.0) < _STILL].tolist()  # whatever the wire does
    counts = [_outside(poles, still) for poles in _poles(parts, grid)]
    a, b, c, d = parts
    pairs = at_half_turn(np.linalg.eigvals(c @ np.linalg.solve(HALF_TURN * np.eye(len(a)) - a, b) + d))
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
