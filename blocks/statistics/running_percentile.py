"""Percentile by the P2 algorithm: five markers, q[i] of rank n[i] = 1 + (n - 1) {0, p/2, p, (1+p)/2, 1} of n samples.

Jain and Chlamtac, Communications of the ACM 28 (1985), box 1. A marker whose rank is off by one or more moves by one
along the parabola through its neighbours, or the straight line. The error has no bound: it is large for few values.
"""

import math
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block, Input, param

_KEPT = "the samples before are kept for one part alone: take a RunningPercentile for each"


class RunningPercentile(Block):
    """Estimate of a percentile of all samples before the tick, without keeping them; exact up to five samples."""

    percent: float = param("%", "Part of the samples below.", default=50.0, above=0.0, below=100.0, not_driven=_KEPT)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to sort.")


class State(NamedTuple):
    samples: int
    lowest: float
    below: float
    middle: float
    above: float
    highest: float
    rank_below: float
    rank_middle: float
    rank_above: float


@RunningPercentile.start
def start(p: RunningPercentile) -> State:
    return State(0, math.inf, math.inf, math.inf, math.inf, math.inf, 2.0, 3.0, 4.0)


@RunningPercentile.output("{unit}")
def percentile(p: RunningPercentile, x: State) -> float:
    """The estimate; of up to five samples the straight line between the two of nearest rank, zero of none."""
    if x.samples > 5:
        return x.middle
    place = p.percent / 100.0 * float(x.samples - 1)
    if x.samples < 2:
        return x.lowest if x.samples == 1 else 0.0
    if place < 1.0:
        return x.lowest + place * (x.below - x.lowest)
    if place < 2.0:
        return x.below + (place - 1.0) * (x.middle - x.below)
    if place < 3.0:
        return x.middle + (place - 2.0) * (x.above - x.middle)
    return x.above + (place - 3.0) * (x.highest - x.above)


@RunningPercentile.update
def update(p: RunningPercentile, x: State, tick: int, input: float) -> State:
    if tick < p.skip or 0 < p.until <= tick:
        return x
    u = 1.0 * input  # measures read codes and bits too
    if x.samples < 5:  # sorted in; the places that are still free hold infinity
        lowest, u = (u, x.lowest) if u < x.lowest else (x.lowest, u)
        below, u = (u, x.below) if u < x.below else (x.below, u)
        middle, u = (u, x.middle) if u < x.middle else (x.middle, u)
        above, u = (u, x.above) if u < x.above else (x.above, u)
        highest = u if u < x.highest else x.highest
        return State(x.samples + 1, lowest, below, middle, above, highest, 2.0, 3.0, 4.0)
    last, part = float(x.samples), p.percent / 100.0  # samples before this one
    n2 = x.rank_below + 1.0 if u < x.below else x.rank_below
    n3 = x.rank_middle + 1.0 if u < x.middle else x.rank_middle
    n4 = x.rank_above + 1.0 if u < x.above else x.rank_above
    q1 = u if u < x.lowest else x.lowest
    q5 = u if u > x.highest else x.highest
    q2, n2 = _moved(q1, x.below, x.middle, 1.0, n2, n3, 1.0 + last * 0.5 * part)
    q3, n3 = _moved(q2, x.middle, x.above, n2, n3, n4, 1.0 + last * part)
    q4, n4 = _moved(q3, x.above, q5, n3, n4, last + 1.0, 1.0 + last * 0.5 * (1.0 + part))
    return State(x.samples + 1, q1, q2, q3, q4, q5, n2, n3, n4)


def _moved(
    left: float, height: float, right: float, rank_left: float, rank: float, rank_right: float, wanted: float
) -> tuple[float, float]:
    """Height and rank of a marker, one nearer to the rank that is wanted where there is room."""
    up = wanted - rank >= 1.0 and rank_right - rank > 1.0
    down = wanted - rank <= -1.0 and rank_left - rank < -1.0
    if not up and not down:
        return height, rank
    step = 1.0 if up else -1.0
    to_right = (rank - rank_left + step) * (right - height) / (rank_right - rank)
    to_left = (rank_right - rank - step) * (height - left) / (rank - rank_left)
    moved = height + step / (rank_right - rank_left) * (to_right + to_left)
    if not left < moved < right and up:
        moved = height + (right - height) / (rank_right - rank)
    elif not left < moved < right:
        moved = height - (left - height) / (rank_left - rank)
    return moved, rank + step
