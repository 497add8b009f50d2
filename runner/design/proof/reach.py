"""Bounds of a sampled system for all time, whatever bounded numbers enter it.

    x[n+1] = A x[n] + B w[n],   y[n] = C x[n] + D w[n],   low <= w <= high
    max y[n] = C A^n x0 + sum over m of max(h[m] low, h[m] high),   h[m] = C A^m B

The powers of A are computed in doubles, each from the one before: P[m+1] = A P[m] + d[m], with d[m]
bounded as rounding is. So A^m is off by at most the sum of |A^(m-1-j)| |d[j]|, and all powers
together by S times the sum of |d|, S the sum of their norms. Beyond N powers the rest is that of a
geometric series, by |A^N| < 1: the sum of |C A^m B| over m >= N is at most the sum of |C A^m| over
m < N, times |A^N B| / (1 - |A^N|). Norms are those of largest entries, of states that are scaled by
powers of two.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.derivatives.ball import LEAST, UNIT, UP
from proofmass.runner.host.arrays import Array

MOST_POWERS, MOST_WORK = 1 << 17, 2e10  # and products of numbers to compute them
_SMALL, _LESS_THAN_ONE = 2.0**-40, 0.9  # norms of the last power: enough, and enough if there is no more time
_LARGE = 1e100  # norm of a power from which a map grows
_CHUNK, _NUMBERS = 64, 1 << 22  # powers of the first chunk, and entries of responses in the largest
_NEAR = 1e-7  # distance of a pole from the circle from which no power of few enough is small


ExactRows = Sequence[Sequence[Fraction]]


class Powers:
    """The powers of a matrix of exact numbers, with bounds of their errors and of those that are left out."""

    def __init__(self, a: ExactRows) -> None:
        self.order = len(a)
        middle = np.array([[float(value) for value in row] for row in a]).reshape(self.order, self.order)
        self._a, scale = balanced(middle)  # by powers of two: exact
        self.scale = [Fraction(float(size)) for size in scale]
        self.radius = float(max(abs(np.linalg.eigvals(self._a)), default=0.0))

    def chunks(self) -> Iterator[Array]:
        """Yield the powers from the first on, many at a time, until they are small, grow, or are too many."""
        power, size, count = np.eye(self.order), _CHUNK, 0
        most = min(MOST_POWERS, MOST_WORK / max(1, self.order) ** 3)
        while count < most:
            chunk = np.empty((size, self.order, self.order))
            with np.errstate(over="ignore", invalid="ignore"):
                for place in range(size):
                    chunk[place] = power
                    power = self._a @ power
                norms = np.abs(chunk).sum(axis=2).max(axis=1, initial=0.0)
            ends = (norms <= _SMALL) | ~(norms <= _LARGE)
            end = int(np.argmax(ends)) if ends.any() else size
            count += end
            if end < size:
                yield chunk[: end + bool(norms[end] <= _SMALL)]
                return
            yield chunk
            size = min(2 * size, max(_CHUNK, _NUMBERS // max(1, self.order**2)))

    @cached_property
    def sums(self) -> "PowerSums | None":
        """Bounds of all powers; None where no power is found that is small."""
        if self.order and not self.radius < 1.0 - _NEAR:
            return None
        total, errors, worst, count, last = 0.0, 0.0, 0.0, 0, np.eye(self.order)
        sizes = np.zeros((self.order, self.order))
        size_of_a = np.abs(self._a)
        for chunk in self.chunks():
            absolute = np.abs(chunk)
            norms = absolute.sum(axis=2).max(axis=1, initial=0.0)
            rounding = (self.order + 4) * UNIT * (size_of_a @ absolute) + LEAST  # and of A
            apart = rounding.sum(axis=2).max(axis=1, initial=0.0)
            total, errors = total + float(norms.sum()) * UP, errors + float(apart.sum()) * UP
            worst, count = max(worst, float(apart.max(initial=0.0))), count + len(chunk)
            sizes, last = (sizes + absolute.sum(axis=0)) * UP, chunk[-1] if len(chunk) else last
        if not errors < 0.5:
            return None
        total = total / (1.0 - errors) * UP
        norm = float(np.abs(last).sum(axis=1).max(initial=0.0)) + total * worst
        if not norm * UP < _LESS_THAN_ONE:
            return None
        return PowerSums(count - 1, last, norm * UP, total * errors * UP, total * worst * UP, sizes)


@dataclass(frozen=True)
class PowerSums:
    """Sums over all powers of a matrix."""

    count: int  # of powers that are summed one by one
    last: Array  # the power after these
    norm: float  # of the last, at most
    error: float  # norms of the errors of all powers together, at most
    error_of_last: float
    sizes: Array  # sums of the entries' absolute values


@dataclass(frozen=True)
class Entering:
    """Columns B, and the ends of the numbers that enter by each."""

    columns: ExactRows  # of the states, by rows
    ends: Sequence[tuple[Fraction, Fraction]]

    def sizes(self) -> Array:
        """Return the largest size of each number."""
        return np.array([float(max(-low, high)) for low, high in self.ends]) * UP


@dataclass(frozen=True)
class Extremes:
    """Bounds of each row over all times beside its value at time 0, and the times of the largest that were summed."""

    low: Array
    high: Array
    low_at: Array
    high_at: Array


def extremes(powers: Powers, entering: Entering, rows: ExactRows) -> Extremes | None:
    """Return bounds of what enters by m < n, added up, of the outputs `rows` for all n; None where there are none."""
    sums, nothing = powers.sums, np.zeros(len(rows))
    if not entering.ends:
        return Extremes(nothing, nothing, nothing.astype(int), nothing.astype(int))
    if sums is None:
        return None
    c, b = _scaled(powers, entering, rows)
    sizes = entering.sizes()
    lows, highs = np.array([[float(end) for end in ends] for ends in entering.ends]).reshape(-1, 2).T
    total = np.zeros((2, len(rows)))
    best, at, begin = np.zeros((2, len(rows))), np.zeros((2, len(rows)), dtype=int), 0
    for h in responses(powers, entering, rows, sums.count):
        ends = np.stack([(h * lows), (h * highs)])
        steps = np.stack([ends.min(axis=0).sum(axis=2), ends.max(axis=0).sum(axis=2)])
        added = total[:, None] + np.cumsum(steps, axis=1)
        for side, extreme in enumerate((added[0].min, added[1].max)):
            values, places = extreme(axis=0), (added[0].argmin, added[1].argmax)[side](axis=0)
            further = values < best[0] if side == 0 else values > best[1]
            best[side] = np.where(further, values, best[side])
            at[side] = np.where(further, begin + places + 1, at[side])
        total, begin = added[:, -1], begin + len(h)
    size_of_c, size_of_b = np.abs(c), np.abs(b) * sizes
    all_of_c, all_of_b = size_of_c.sum(axis=1), size_of_b.max(axis=0, initial=0.0)
    known = (size_of_c @ sums.sizes @ size_of_b).sum(axis=1)
    rounding = (sums.count + len(sizes) + 2 * powers.order + 16) * UNIT * known + LEAST
    rounding += all_of_c * sums.error * float(all_of_b.sum())
    after = np.abs(sums.last) @ size_of_b
    rest = float((after.max(axis=0, initial=0.0) + sums.error_of_last * all_of_b).sum())
    tail = (size_of_c @ sums.sizes).sum(axis=1) + all_of_c * sums.error
    beyond = (rounding + tail * rest / (1.0 - sums.norm)) * UP
    return Extremes(best[0] * UP - beyond, best[1] * UP + beyond, at[0], at[1])


def responses(powers: Powers, entering: Entering, rows: ExactRows, most: int) -> Iterator[Array]:
    """Yield C A^m B for m from 0 to `most` - 1, many at a time: (powers, rows, columns)."""
    c, b = _scaled(powers, entering, rows)
    part, begin = max(1, _NUMBERS // max(1, c.shape[0] * b.shape[1])), 0
    for chunk in powers.chunks():
        for first in range(0, min(len(chunk), most - begin), part):
            yield c @ chunk[first : min(first + part, most - begin)] @ b
        begin += len(chunk)
        if begin >= most:
            return


def _scaled(powers: Powers, entering: Entering, rows: ExactRows) -> tuple[Array, Array]:
    """Return C and B in the scaled states."""
    c = [[float(value * size) for value, size in zip(row, powers.scale, strict=True)] for row in rows]
    b = [[float(value / size) for value in row] for row, size in zip(entering.columns, powers.scale, strict=True)]
    shape = (len(rows), powers.order), (powers.order, len(entering.ends))
    return np.array(c).reshape(shape[0]), np.array(b).reshape(shape[1])
