"""The figures of a loop with one L, from polynomials that are known exactly."""

import math
from typing import NamedTuple

from proofmass.runner.analysis.linearisation.rational import Rational, Transfer, roots
from proofmass.runner.analysis.margins.crossings import (
    Crossing,
    end,
    first_fall,
    gain_crossings,
    largest_ratio,
    phase_crossings,
    rest,
)
from proofmass.runner.analysis.margins.figures import LARGEST_FACTOR, Figures, Interval

_TURN = 2.0 * math.pi


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
        stable_gains=_stable_gains(loop, sampled, [limit.factor for limit in limits]),
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
    places = {crossing.size: crossing.w for crossing in [*ends, *phases]}
    return sorted(_Limit(1.0 / size, w) for size, w in places.items() if 1.0 / LARGEST_FACTOR < size < LARGEST_FACTOR)


def _delay_margin(axis: Rational, gains: list[Crossing]) -> tuple[Crossing | None, float]:
    """Return the crossover that limits a delay, and the delay; no delay where |L| >= 1 at infinite frequency."""
    last = end(axis)
    if not axis.sampled and last is not None and last.size >= 1.0:
        return last, 0.0
    late = min(gains, key=lambda c: (c.lag % _TURN) / c.w, default=None)
    return late, (late.lag % _TURN) / late.w if late else math.inf


def _stable_gains(loop: Transfer, sampled: bool, factors: list[float]) -> tuple[Interval, ...]:
    """The intervals between critical factors in which all poles are inside."""
    intervals: list[Interval] = []
    edges = [0.0, *factors]
    for low, high in zip(edges, [*factors, math.inf], strict=True):
        inner = 2.0 * low + 1.0 if math.isinf(high) else 0.5 * (low + high)
        top, bottom = inner.as_integer_ratio()
        closed = top * loop.numerator + bottom * loop.denominator
        if all((abs(root) < 1) if sampled else (root.real < 0) for root in roots(closed)):
            intervals.append((low, high))
    return tuple(intervals)
