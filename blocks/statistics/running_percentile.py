"""Percentile of all samples: on the straight line between the two of nearest rank, as numpy.percentile.

Up to 1,024 different values stand in a table with their counts; beyond that neighbours are joined
to their mean. `join_neighbours` says which.
"""

from typing import NamedTuple

from proofmass.blocks.arithmetic.ordered_counts import join_neighbours, place_of, take_in
from proofmass.blocks.declaration.declare import Block, Buffer, Input, param

_KEPT = "the samples before are joined for one part alone: take a RunningPercentile for each"
_VALUES = 1024
_FRESH = 64  # values that wait, in order, until they go into the table together
_GROWTH = 1.25  # of the samples that may be joined, until a quarter of the table is free


class RunningPercentile(Block):
    """Percentile of all samples before the tick: exact up to 1,024 different values, beyond that an estimate."""

    percent: float = param("%", "Part of the samples below.", default=50.0, above=0.0, below=100.0, not_driven=_KEPT)
    skip: int = param("1", "Ticks left out at the start, while a loop settles.", default=0, at_least=0)
    until: int = param("1", "Tick from which on nothing counts; 0 for no end.", default=0, at_least=0)
    unit: str = param("", "Unit of the input.", default="1")

    input = Input("{unit}", "Signal to sort.")

    value = Buffer("Different values, or means of joined ones, in order.", float, (_VALUES + _FRESH,))
    count = Buffer("Samples of each of them; negative where they are joined.", int, (_VALUES + _FRESH,))
    fresh = Buffer("Values that are not in the table yet, in order.", float, (_FRESH,))
    fresh_count = Buffer("Samples of each of these.", int, (_FRESH,))


class State(NamedTuple):
    samples: int
    values: int
    fresh: int
    limit: float  # samples that may be joined at the wanted rank


@RunningPercentile.start
def start(p: RunningPercentile) -> State:
    return State(0, 0, 0, 1.0)


@RunningPercentile.output("{unit}")
def percentile(
    p: RunningPercentile, x: State, value: list[float], count: list[int], fresh: list[float], fresh_count: list[int]
) -> float:
    """The percentile, on the line between the two samples of nearest rank; zero of none."""
    place = p.percent / 100.0 * float(x.samples - 1)
    i, k, below, low, low_place = 0, 0, 0, 0.0, 0.0
    while i < x.values or k < x.fresh:
        if k < x.fresh and (i == x.values or fresh[k] < value[i]):
            high, samples = fresh[k], fresh_count[k]
            k += 1
        else:
            high, samples = value[i], count[i]
            i += 1
        joined = 0.5 * float(-samples - 1) if samples < 0 else 0.0  # samples of a mean lie about it
        samples = abs(samples)
        first, last = float(below) + joined, float(below + samples - 1) - joined
        if low_place < place < first:
            return low + (place - low_place) / (first - low_place) * (high - low)
        if place <= last:
            return high
        below, low, low_place = below + samples, high, last
    return low


@RunningPercentile.update
def update(
    p: RunningPercentile, x: State, tick: int, value: list[float], count: list[int], fresh: list[float],
    fresh_count: list[int], input: float,
) -> State:  # fmt: skip
    if tick < p.skip or 0 < p.until <= tick:
        return x
    u = 1.0 * input  # measures read codes and bits too
    samples, i = x.samples + 1, place_of(value, x.values, u)
    if i < x.values and value[i] == u:
        count[i] += 1 if count[i] > 0 else -1
        return x._replace(samples=samples)
    i = place_of(fresh, x.fresh, u)
    if i < x.fresh and fresh[i] == u:
        fresh_count[i] += 1
        return x._replace(samples=samples)
    for k in range(x.fresh, i, -1):
        fresh[k], fresh_count[k] = fresh[k - 1], fresh_count[k - 1]
    fresh[i], fresh_count[i] = u, 1
    if x.fresh + 1 < len(fresh):
        return x._replace(samples=samples, fresh=x.fresh + 1)
    take_in(x.values, value, count, fresh, fresh_count)
    values, limit = x.values + len(fresh), x.limit
    while values > _VALUES:
        values = join_neighbours(values, value, count, limit, p.percent / 100.0, float(samples))
        limit *= 1.0 if 4 * values <= 3 * _VALUES else _GROWTH
    return State(samples, values, 0, limit)
