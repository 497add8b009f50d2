"""The delay margin of a loop with several values of its wire in a period: whole values before the
first too many.

A delay of r values and q periods is a register of r values, and q periods are a factor z^-q at the
wire. So a pole exp(j theta) on the unit circle is one that a factor exp(-j phi) puts there, with q
theta = phi but for whole turns. All such pairs are found for each r. As q grows past phi / theta
the pole leaves the circle, to the side to which it leaves it as phi grows: the unstable poles of
each q are counted.

The pairs are those of `LateValues`. Of many values that depend on each other, loops of many delays
are followed (`followed_delays`).
"""

import math
from collections.abc import Sequence

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from proofmass.runner.analysis.margins.followed_delays import NEAR, stable_delay
from proofmass.runner.analysis.margins.late_values import CircleCrossing, LateValues
from proofmass.runner.host.arrays import Array

_COUNTED, _FOLLOWED = 64, 4_096  # values of longer periods, without crossovers or ticks known one by one, and with both
_OUTSIDE = 1.0 + 1e-12
_TRIED = 64  # turns of a pole
_Parts = tuple[Array, Array, Array, Array]


def delay_margin(system: OpenLoop, crossovers: Sequence[float]) -> float | None:
    """Seconds of whole values of the wire before the first that makes the loop unstable; None if none does.

    Take the gain crossovers in Hz.
    """
    parts, values, late = system.matrices, system.per_period, LateValues.of(system)
    if late is None:
        return _nearest(parts, longest_delay(system, crossovers), system.map.ticks) * system.sample
    sizes = (_size(_delayed(parts, number)) for number in range(1, values)) if parts[3].any() else late.sizes()
    for before, size in enumerate(sizes):
        if size >= _OUTSIDE:
            return before * system.sample
    periods = map(_first_unstable, late.on_circle())
    found = [first + values * number for first, number in enumerate(periods) if number is not None]
    return (min(found) - 1) * system.sample if found else None


def longest_delay(system: OpenLoop, crossovers: Sequence[float]) -> int:
    """Return the longest delay that is looked at where not all are, in values.

    A turn at the lowest crossover is more than any margin that the loop has there.
    """
    if system.map.ticks is None or not crossovers:
        return _COUNTED
    return int(np.clip(1.0 / (min(crossovers) * system.sample), _COUNTED, _FOLLOWED))


def is_at_least(system: OpenLoop, crossovers: Sequence[float], delay: float) -> bool:
    """Return whether a delay margin is the longest delay that was looked at."""
    return LateValues.of(system) is None and delay == longest_delay(system, crossovers) * system.sample


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
    """Return the size of the slowest pole. Values depend on earlier ones of their period."""
    a, b, c, d = parts
    values = scipy.linalg.solve_triangular(np.eye(len(d)) + d, c, lower=True, unit_diagonal=True)
    return float(np.max(np.abs(np.linalg.eigvals(a - b @ values)), initial=0.0))


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
