"""Delays of a wire with many values in a period that depend on each other: loops of many delays are
followed side by side, value by value.

    x[k+1] = a[k] x[k] + b[k] u[k],   y[k] = c[k] x[k] + d[k] u[k],   u[k] = y[k - r]

After a while the slowest pole, or the pair of it, is nearly all that is left of any start. What the
wire holds then obeys s[m+2] = e s[m+1] + f s[m], from a turn of some periods to the next, and the
larger root of z^2 = e z + f is about its size.
"""

import math
from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.tick_maps import TickMaps
from proofmass.runner.analysis.linearisation.tick_products import CONSTANT, MOVED, PLACES, move, run
from proofmass.runner.host.arrays import Array, Integers

_FIRST, _MORE = 64, 4  # values up to which delays are followed at once, and how many times as many in the next stage
NEAR = 256  # values from which on all delays between two are followed
_APART = 1.03  # factor between two of them
_LEAST, _MOST, _COMPARED = 8, 32, 6  # turns that are followed, and the last that are compared
_TOLD = 10.0  # times that a size may be wrong, by which it has to differ from one
_NOTHING = 1e-25  # of what there was a turn before: a loop is stable that leaves less
_ALIKE = 1e-12  # of turns that are alike but for a factor
_KINDS = PLACES, (CONSTANT,) * 4, MOVED, MOVED, (MOVED, MOVED)


def stable_delay(maps: TickMaps, longest: int) -> int:
    """Return the number of values before the first delay that makes a stable loop unstable, or the longest.

    Delays are some hundredths apart: up to `NEAR` it is about the number.
    """
    low = 0
    while low < longest:
        high = min(_MORE * low or _FIRST, longest)
        steps = 2 + int(math.log(high / (low + 1)) / math.log(_APART))
        late = np.unique(np.round(np.geomspace(low + 1, high, steps)).astype(np.int64))
        place = _first_unstable(maps, late)
        if place is None:
            low = high
            continue
        low = int(late[place - 1]) if place else low
        between = _first_unstable(maps, np.arange(low + 1, int(late[place]) + 1)) if low >= NEAR else 0
        return int(late[place]) - 1 if between is None else low + between
    return low


def _first_unstable(maps: TickMaps, late: Integers) -> int | None:
    with np.errstate(over="ignore", invalid="ignore"):  # of loops that grow beyond all numbers, or end
        unstable = np.flatnonzero(~(_sizes(maps, late) <= 1.0))
    return int(unstable[0]) if len(unstable) else None


def _sizes(maps: TickMaps, late: Integers) -> Array:
    """Return the size of the slowest pole for each delay, over some periods."""
    most, values, count, n = int(late[-1]), len(maps.d), len(late), maps.b.shape[1]
    turn = values * math.ceil(most / values)
    wire, x = np.random.default_rng(0).standard_normal((most, count)), np.zeros((n, count))
    given, room = [late, maps.a, maps.b, maps.c, maps.d], [np.empty(count), np.empty((n, count))]
    shown: list[Array] = []
    sizes, gone = np.ones(count), np.zeros(count, dtype=bool)
    for first in range(0, _MOST * turn, turn):
        run(_follow, (first, first + turn, values, most, count, n), [*given, wire, x, *room], _KINDS)
        scale = np.max(np.abs(wire), axis=0)
        gone |= scale < _NOTHING
        scale[gone] = 1.0
        x, wire = x / scale, wire / scale
        shown = [
            *(before / scale for before in shown[1 - _COMPARED :]),
            np.roll(wire, -((first + turn) % most), axis=0),
        ]
        if first >= _LEAST * turn:
            sizes, wrong = _slowest(np.array(shown))
            if not np.any(~gone & (np.abs(sizes - 1.0) <= _TOLD * wrong)):
                break
    return np.where(gone, 0.0, sizes)


def _slowest(turns: Array) -> tuple[Array, Array]:
    """Return the larger root of z^2 = e z + f for each delay, and by how much it may be wrong."""
    lags = np.array([turns[lag : len(turns) - 2 + lag].reshape(-1, turns.shape[-1]) for lag in range(3)])
    before, once, twice = lags
    gram = np.einsum("ikr,jkr->ijr", lags, lags)
    apart = gram[0, 0] * gram[1, 1] - gram[0, 1] ** 2
    alike = apart / (gram[0, 0] * gram[1, 1])  # the square of the sine between one turn and the next
    pair = alike > _ALIKE
    divisor = np.where(pair, apart, 1.0)
    f = np.where(pair, (gram[0, 2] * gram[1, 1] - gram[1, 2] * gram[0, 1]) / divisor, 0.0)
    e = np.where(pair, (gram[1, 2] * gram[0, 0] - gram[0, 2] * gram[0, 1]) / divisor, gram[1, 2] / gram[1, 1])
    root = np.sqrt(e * e + 4.0 * f + 0.0j)
    rest = np.linalg.norm(twice - e * once - f * before, axis=0) / np.sqrt(gram[2, 2])
    wrong = rest / np.sqrt(np.where(pair, alike, 1.0))
    return 0.5 * np.maximum(np.abs(e + root), np.abs(e - root)), np.asarray(wrong)


def _follow(
    first: int,
    last: int,
    values: int,
    most: int,
    count: int,
    n: int,
    late: Any,
    maps: Any,
    wire: Any,
    x: Any,
    room: Any,
) -> None:
    """Go on by some values of the wire with each delay, as machine code."""
    (a, b, c, d), (given, after) = maps, room
    for k in range(first, last):
        place, now = k % values, k % most * count
        for r in range(count):
            given[r] = wire[(k + most - late[r]) % most * count + r]
        for r in range(count):
            wire[now + r] = d[place] * given[r]
        for i in range(n):
            shown = c[place * n + i]
            if shown != 0.0:
                for r in range(count):
                    wire[now + r] += shown * x[i * count + r]
        move(place, n, count, a, b, given, x, after)
