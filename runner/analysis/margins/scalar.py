"""The figures of a loop with one L, from polynomials that are known exactly."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import accumulate, pairwise
from typing import NamedTuple

from proofmass.runner.analysis.linearisation.rational import LARGEST_CERTIFIED, Transfer
from proofmass.runner.analysis.margins.axis import TANGENTIAL, CertifiedAxis, Crossing
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, FactorInterval, Figures
from proofmass.runner.analysis.margins.swept import SweptAxis

_TURN = 2.0 * math.pi
Axis = CertifiedAxis | SweptAxis


def axis_of(loop: Transfer, sampled: bool, poles: Sequence[complex] = ()) -> Axis:
    """Return L on its axis: of a sampled loop of many states with these poles, over a grid."""
    many = sampled and loop.degree > LARGEST_CERTIFIED
    return SweptAxis(loop, poles) if many else CertifiedAxis(loop, sampled)


def figures_of(axis: Axis, period: float, stable: bool) -> Figures:
    """All figures of a loop; the margins only of a stable one. `period` counts for sampled loops, in seconds."""
    sampled = axis.sampled
    time = period if sampled else 1.0  # frequencies of the axis are radians in this time
    hertz = 1.0 / (_TURN * time)
    gains, phases = axis.gain_crossings(), axis.phase_crossings()
    limits = _limits(axis, phases)
    at_peak, peak = axis.largest(0)
    every = Figures(
        distance=1.0 / peak,
        gain_crossovers=tuple(c.w * hertz for c in gains),
        gain_crossover_phases=tuple(c.lag for c in gains),
        phase_crossovers=tuple(c.w * hertz for c in phases),
        phase_crossover_gains=tuple(c.size for c in phases),
        stable_gains=_stable_gains(axis, limits),
    )
    if not stable:
        return every
    up = min((limit for limit in limits if limit.factor > 1.0), default=None)
    down = max((limit for limit in limits if limit.factor < 1.0), default=None)
    turn = min(gains, key=lambda c: abs(c.lag), default=None)
    late = _delay_margin(axis, gains)
    fall = axis.fall()
    return replace(
        every,
        gain_margin=up and up.factor,
        gain_margin_frequency=up and up.w * hertz,
        gain_reduction=down and down.factor,
        phase_margin=abs(turn.lag) if turn else None,
        phase_margin_frequency=turn.w * hertz if turn else None,
        delay_margin=late[0] * time if late else None,
        delay_margin_frequency=late[1] * hertz if late else None,
        disk_margin=2.0 / axis.largest(1)[1],
        sensitivity_peak=peak,
        sensitivity_peak_frequency=at_peak * hertz,
        bandwidth=None if fall is None else fall * hertz,
    )


class _Limit(NamedTuple):
    """A factor at the wire that puts a pole on the boundary of stability, and where."""

    factor: float
    w: float


def _limits(axis: Axis, phases: list[Crossing]) -> list[_Limit]:
    """All of them, the smallest first."""
    ends = [at for at in (axis.rest(), axis.end()) if at is not None and at.lag == 0.0]
    places = {(crossing.size, crossing.w) for crossing in [*ends, *phases]}
    return sorted(_Limit(1.0 / size, w) for size, w in places if 1.0 / LARGEST_FACTOR < size < LARGEST_FACTOR)


def _delay_margin(axis: Axis, gains: list[Crossing]) -> tuple[float, float] | None:
    """Return the delay that puts a pole on the boundary of stability, and where; None if none does.

    There is no time where |L| >= 1 at infinite frequency. A sampled loop with |L| >= 1 at half its
    rate has a pole beyond -1 more or less with one sample more.
    """
    last = axis.end()
    delays = [((crossing.lag % _TURN) / crossing.w, crossing.w) for crossing in gains]
    if axis.sampled and (last is None or last.size >= 1.0):
        delays.append((1.0, math.pi))
    if not axis.sampled and last is not None and last.size >= 1.0:
        delays.append((0.0, last.w))
    return min(delays, default=None)


def _stable_gains(axis: Axis, limits: list[_Limit]) -> tuple[FactorInterval, ...]:
    """The intervals between critical factors in which all poles are inside.

    Poles outside are counted in the first interval, and on from there as they cross the boundary.
    Where that does not give the count of the last one, or a crossing does not tell its direction,
    each interval is counted.
    """
    edges = [0.0, *dict.fromkeys(limit.factor for limit in limits), math.inf]
    intervals = list(pairwise(edges))
    moved = dict.fromkeys(edges[1:-1], 0.0)
    for limit in limits:
        moved[limit.factor] += _crossing(axis, limit)
    counts = list(accumulate(moved.values(), initial=float(_outside(axis, intervals[0]))))
    if not math.isfinite(counts[-1]) or counts[-1] != _outside(axis, intervals[-1]):
        counts = [_outside(axis, interval) for interval in intervals]
    return tuple(interval for interval, count in zip(intervals, counts, strict=True) if count == 0)


def _outside(axis: Axis, factors: FactorInterval) -> int:
    """Return the number of closed-loop poles that are not inside, for a factor between two."""
    low, high = factors
    return axis.outside(2.0 * low + 1.0 if math.isinf(high) else 0.5 * (low + high))


def _crossing(axis: Axis, limit: _Limit) -> float:
    """Return how many more poles are outside beyond a critical factor; NaN if uncertain."""
    outwards = math.nan if math.isinf(limit.w) else axis.outwards(limit.factor, limit.w)
    if not abs(outwards) > TANGENTIAL:
        return math.nan
    return math.copysign(1.0 if limit.w == 0.0 or (axis.sampled and limit.w == math.pi) else 2.0, outwards)
