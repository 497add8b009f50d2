"""The figures of a loop with one L, from polynomials that are known exactly."""

import math
from itertools import accumulate, pairwise
from typing import NamedTuple

import flint

from proofmass.runner.analysis.linearisation.rational import Rational, Transfer, precise, roots
from proofmass.runner.analysis.margins.crossings import (
    Crossing,
    end,
    first_fall,
    gain_crossings,
    largest_ratio,
    phase_crossings,
    rest,
)
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, FactorInterval, Figures

_TURN = 2.0 * math.pi
_TANGENTIAL = 1e-6  # part of its speed with which a pole must cross the boundary for its direction to be certain


def figures_of(loop: Transfer, sampled: bool, period: float, stable: bool) -> Figures:
    """All figures of a loop; the margins only of a stable one. `period` counts for sampled loops, in seconds."""
    axis = loop.on_axis(sampled)
    time = period if sampled else 1.0  # frequencies of the axis are radians in this time
    hertz = 1.0 / (_TURN * time)
    gains, phases = gain_crossings(axis), phase_crossings(axis)
    limits = _limits(axis, phases)
    at_peak, peak = largest_ratio(axis, axis.denominator, axis.closed)
    every = Figures(
        distance=1.0 / peak,
        gain_crossovers=tuple(c.w * hertz for c in gains),
        gain_crossover_phases=tuple(c.lag for c in gains),
        phase_crossovers=tuple(c.w * hertz for c in phases),
        phase_crossover_gains=tuple(c.size for c in phases),
        stable_gains=_stable_gains(loop, sampled, limits),
    )
    if not stable:
        return every
    up = min((limit for limit in limits if limit.factor > 1.0), default=None)
    down = max((limit for limit in limits if limit.factor < 1.0), default=None)
    turn = min(gains, key=lambda c: abs(c.lag), default=None)
    late, delay = _delay_margin(axis, gains)
    fall = first_fall(axis, axis.numerator, axis.closed)
    return every.with_values(
        gain_margin=up and up.factor,
        gain_margin_frequency=up and up.w * hertz,
        gain_reduction=down and down.factor,
        phase_margin=turn and abs(turn.lag),
        phase_margin_frequency=turn and turn.w * hertz,
        delay_margin=delay * time if late else None,
        delay_margin_frequency=late and late.w * hertz,
        disk_margin=2.0 / largest_ratio(axis, axis.denominator - axis.numerator, axis.closed)[1],
        sensitivity_peak=peak,
        sensitivity_peak_frequency=at_peak * hertz,
        bandwidth=None if fall is None else fall * hertz,
    )


class _Limit(NamedTuple):
    """A factor at the wire that puts a pole on the boundary of stability, and where."""

    factor: float
    w: float


def _limits(axis: Rational, phases: list[Crossing]) -> list[_Limit]:
    """All of them, the smallest first."""
    ends = [at for at in (rest(axis), end(axis)) if at is not None and at.lag == 0.0]
    places = {(crossing.size, crossing.w) for crossing in [*ends, *phases]}
    return sorted(_Limit(1.0 / size, w) for size, w in places if 1.0 / LARGEST_FACTOR < size < LARGEST_FACTOR)


def _delay_margin(axis: Rational, gains: list[Crossing]) -> tuple[Crossing | None, float]:
    """Return the crossover that limits a delay, and the delay; no delay where |L| >= 1 at infinite frequency."""
    last = end(axis)
    if not axis.sampled and last is not None and last.size >= 1.0:
        return last, 0.0
    late = min(gains, key=lambda c: (c.lag % _TURN) / c.w, default=None)
    return late, (late.lag % _TURN) / late.w if late else math.inf


def _stable_gains(loop: Transfer, sampled: bool, limits: list[_Limit]) -> tuple[FactorInterval, ...]:
    """The intervals between critical factors in which all poles are inside.

    Poles outside are counted in the first interval, and on from there as they cross the boundary. Where that does not
    give the count of the last one, or a crossing does not tell its direction, each interval is counted.
    """
    edges = [0.0, *dict.fromkeys(limit.factor for limit in limits), math.inf]
    intervals = list(pairwise(edges))
    moved = [sum(_crossing(loop, sampled, limit) for limit in limits if limit.factor == edge) for edge in edges[1:-1]]
    counts = list(accumulate(moved, initial=_outside(loop, sampled, intervals[0])))
    if not math.isfinite(counts[-1]) or counts[-1] != _outside(loop, sampled, intervals[-1]):
        counts = [_outside(loop, sampled, interval) for interval in intervals]
    return tuple(interval for interval, count in zip(intervals, counts, strict=True) if count == 0)


def _outside(loop: Transfer, sampled: bool, factors: FactorInterval) -> float:
    """Return the number of closed-loop poles that are not inside, for a factor between two."""
    low, high = factors
    top, bottom = (2.0 * low + 1.0 if math.isinf(high) else 0.5 * (low + high)).as_integer_ratio()
    closed = top * loop.numerator + bottom * loop.denominator
    return sum(not (abs(root) < 1 if sampled else root.real < 0) for root in roots(closed))


def _crossing(loop: Transfer, sampled: bool, limit: _Limit) -> float:
    """Return how many more poles are outside beyond a critical factor; NaN where that is not certain.

    The pole z of f N + D moves by -N / (f N' + D') times the change of the factor f.
    """
    if math.isinf(limit.w):
        return math.nan
    precise()
    place = flint.acb.exp(flint.acb(0, limit.w)) if sampled else flint.acb(0, limit.w)
    slope = limit.factor * loop.numerator.derivative()(place) + loop.denominator.derivative()(place)
    if slope == 0:
        return math.nan
    speed = complex(-loop.numerator(place) / slope)
    outwards = (speed / complex(place)).real if sampled else speed.real
    if not abs(outwards) > _TANGENTIAL * abs(speed):
        return math.nan
    pair = 1.0 if limit.w == 0.0 or (sampled and limit.w == math.pi) else 2.0
    return math.copysign(pair, outwards)
