"""A loop over its period: what it does to the memory and to the values of its wire, in balls of 512 bits (lifting).

Where one quotient L = N / D decides, its truth is that of `polynomial_loops`. Else the poles of the period are followed
over a dense grid of factors and turns, and each crossing is solved for in 80 digits.
"""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import flint
import mpmath
import numpy as np
import numpy.typing as npt
import scipy.optimize

from proofmass.blocks.declaration.declare import Block
from tests.by_hand.polynomial_loops import DIGITS, Truth, roots_of, truth_of_quotient

BITS = 512
MOST_DELAYED = 200  # samples
_PLACES = 120  # of a decade of factors, and of a quarter of a turn
_LAST = 9.0  # decades
_FAR = 1e-12
_optimize: Any = scipy.optimize
Matrix = list[list[Any]]
Array = npt.NDArray[Any]


class Tick(NamedTuple):
    """x' = a x + b u, y = c x + d u in one tick."""

    a: Matrix
    b: list[Any]
    c: list[Any]
    d: Any


class Part(NamedTuple):
    """Blocks of a chain with the wires between them, where it begins and ends, and its ticks in base ticks."""

    blocks: dict[str, tuple[Block, int]]  # and after how many base ticks each ticks
    wires: list[str]
    entry: str
    exit: str
    ticks: list[Tick]


class Lifted:
    """L of a period: what it does to the memory and the values of the wire, and how often these come."""

    def __init__(self, whole: tuple[Array, Array, Array, Array], period: float) -> None:
        """Take A, B, C and D in balls."""
        self.whole, self.period = whole, period
        self.near = tuple(_doubles(part) for part in whole)
        self.values = len(whole[3])

    @classmethod
    def of(cls, parts: Sequence[Part], wire: int, rate: float) -> "Lifted":
        """Return the period of a chain in feedback, with a value of the wire in every so many ticks."""
        flint.ctx.prec = BITS
        ticks = math.lcm(wire, *(len(part.ticks) for part in parts))
        sizes = [len(part.ticks[0].b) for part in parts]
        n, values = sum(sizes), ticks // wire
        zero, one = flint.arb(0), flint.arb(1)
        rows = np.array([[one if i == j else zero for j in range(n + values)] for i in range(n)], dtype=object)
        rows = rows.reshape(n, n + values)
        read = []
        for t in range(ticks):
            signal = np.array([one if j == n + t // wire else zero for j in range(n + values)], dtype=object)
            first = 0
            for part, size in zip(parts, sizes, strict=True):
                tick, own = part.ticks[t % len(part.ticks)], rows[first : first + size]
                moved = [_sum(tick.a[i], own) + tick.b[i] * signal for i in range(size)]
                signal = _sum(tick.c, own) + tick.d * signal
                for i, row in enumerate(moved):
                    rows[first + i] = row
                first += size
            if t % wire == 0:
                read.append(signal)
        out = np.array(read, dtype=object)
        return cls((rows[:, :n], rows[:, n:], out[:, :n], out[:, n:]), ticks / rate)

    def truth(self) -> Truth:
        """Return everything."""
        quotient = self._quotient()
        if quotient is not None:
            with mpmath.workdps(DIGITS):
                found = truth_of_quotient(*quotient, 1.0 / self.period)
            if self.values > 1:  # S and T of one number, or of all values: the peaks of either are right
                found = found._replace(
                    delay_margin=self._delay_margin(), disk_margin=math.nan, sensitivity_peak=math.nan
                )
            return found
        outside = self._outside(1.0)
        gains = self._stable_gains()
        stable = outside < 0.0
        low, high = next(((a, b) for a, b in gains if a < 1.0 < b), (0.0, math.inf))
        return Truth(
            outside,
            high if stable and math.isfinite(high) else None,
            (low or None) if stable else None,
            self._turn() if stable else None,
            self._delay_margin() if stable else None,
            1.0 / self._peak(0.5) if stable else math.nan,
            self._peak(1.0) if stable else math.nan,
            gains,
        )

    def _quotient(self) -> tuple[list[Any], list[Any]] | None:
        """Return N and D of the L that decides if the values that are read or given count through one number alone."""
        a, b, c, d = self.whole
        answers = [d]
        for _ in a:
            answers.append(c @ b)
            b = a @ b
        b = self.whole[1]
        place = _one_number(np.vstack(answers))
        if place is not None:
            row, j = place
            into, out, direct = b[:, j] / row[j], row @ c, row @ d[:, j] / row[j]
        else:
            place = _one_number(np.hstack(answers).T)
            if place is None:
                return None
            row, j = place
            into, out, direct = b @ row, c[j] / row[j], d[j] @ row / row[j]
        open_poles, less = _characteristic(a), _characteristic(a - np.outer(into, out))
        top = [one - other for one, other in zip(less, open_poles, strict=True)]
        top = [value + direct * below for value, below in zip(top, open_poles, strict=True)]
        return [_number(value) for value in top], [_number(value) for value in open_poles]

    def _closed(self, factors: Array) -> Array:
        a, b, c, d = self.near
        gain = np.eye(self.values) + factors[:, None, None] * d
        back = np.linalg.solve(gain, np.broadcast_to(c, (len(gain), *c.shape)))
        return np.asarray(a - factors[:, None, None] * (b @ back))

    def _sizes(self, factors: Array) -> Array:
        return np.asarray(np.max(np.abs(np.linalg.eigvals(self._closed(factors))), axis=1) - 1.0)

    def _outside(self, factor: float) -> float:
        """Return by how much the slowest pole of the period lies outside, in many digits."""
        a, b, c, d = self.whole
        times = flint.arb(factor)
        gain = flint.arb_mat((np.eye(self.values, dtype=int) + times * d).tolist())
        back = gain.solve(flint.arb_mat(c.tolist()))
        closed = a - times * np.array((flint.arb_mat(b.tolist()) * back).tolist(), dtype=object)
        with mpmath.workdps(DIGITS):
            found = roots_of([_number(value) for value in _characteristic(closed)])
            return float(max((abs(root) - 1 for root in found), default=mpmath.mpf(-1)))

    def _turned(self, angle: float) -> Any:
        """Return the same for a turn at the wire: the characteristic polynomial times its conjugate is real."""
        a, b, c, d = self.whole
        turn = flint.acb(flint.arb(angle).cos(), -flint.arb(angle).sin())
        n = len(a)
        gain = flint.acb_mat((np.eye(self.values, dtype=int) + d * turn).tolist())
        back = gain.solve(flint.acb_mat(c.tolist()))
        closed = flint.acb_mat(a.tolist()) - flint.acb_mat((b * turn).tolist()) * back
        polynomial = closed.charpoly()
        with mpmath.workdps(DIGITS):
            real = [_number(polynomial[i].real) for i in range(n, -1, -1)]
            other = [_number(polynomial[i].imag) for i in range(n, -1, -1)]
            square = _convolved(real, real, 1) + _convolved(other, other, 1)
            found = roots_of(list(square))
            return max((abs(root) - 1 for root in found), default=mpmath.mpf(-1))

    def _stable_gains(self) -> list[tuple[float, float]]:
        places = np.linspace(-_LAST, _LAST, round(2 * _LAST * _PLACES) + 1)
        sizes = self._sizes(10.0**places)
        intervals, begin = [], 0.0 if sizes[0] < 0.0 else None
        for (low, high), (before, after) in zip(pairwise(places), pairwise(sizes), strict=True):
            if (before < 0.0) != (after < 0.0):
                edge = _zero(lambda x: self._outside(10.0**x), low, high)
                if edge is None:  # rounding
                    continue
                edge = 10.0**edge
                if begin is not None:
                    intervals.append((begin, edge))
                begin = edge if after < 0.0 else None
        return [*intervals, *([] if begin is None else [(begin, math.inf)])]

    def _turn(self) -> float | None:
        places = np.linspace(0.0, math.pi, 2 * _PLACES + 1)
        sizes = self._sizes(np.exp(-1j * places))
        for (low, high), after in zip(pairwise(places), sizes[1:], strict=True):
            if after >= 0.0 and high < math.pi and (turn := _zero(self._turned, low, high)) is not None:
                return turn
        return _zero(self._turned, places[-2], places[-1]) if sizes[-1] > _FAR else None

    def _delay_margin(self) -> float:
        """Return the time of whole values of the wire before the first with which the loop is unstable."""
        a, b, c, d = self.near
        n, m = len(a), self.values
        for late in range(1, MOST_DELAYED + 1):
            rows = np.eye(n + late)
            line = list(rows[n:])  # the values that are under way, the oldest first
            given = []
            for k in range(m):
                given.append(-line.pop(0))
                read = c[k] @ rows[:n] + sum((d[k, j] * given[j] for j in range(k)), np.zeros(n + late))
                line.append(read)
            moved = np.vstack([a @ rows[:n] + b @ np.array(given), *line])
            if np.max(np.abs(np.linalg.eigvals(moved))) >= 1.0 + _FAR:
                return (late - 1) * self.period / m
        return math.inf

    def _peak(self, offset: float) -> float:
        """Return the largest singular value of offset - T on the unit circle."""
        _, b, c, d = self.near
        inverse = np.linalg.inv(np.eye(self.values) + d)
        a, b, c, d = self._closed(np.ones(1))[0], b @ inverse, inverse @ c, offset * np.eye(self.values) - inverse @ d
        poles = np.linalg.eigvals(a)
        spread = np.concatenate([[0.0], np.geomspace(1e-2, 1e3, 60)])
        near = [
            np.angle(pole) + sign * max(1.0 - abs(pole), 1e-9) * spread
            for pole in poles
            for sign in (-1.0, 1.0)
            if abs(pole) > 1e-3
        ]
        angles = np.unique(np.concatenate([np.linspace(0.0, math.pi, 721), *near]))
        angles = angles[(angles >= 0.0) & (angles <= math.pi)]

        def size(angle: float) -> float:
            response = d - c @ np.linalg.solve(np.exp(1j * angle) * np.eye(len(a)) - a, b)
            return float(np.linalg.norm(response, 2))

        sizes = np.array([size(angle) for angle in angles])
        best = float(sizes.max())
        for i in np.flatnonzero(sizes >= 0.99 * best).tolist():
            low, high = angles[max(i - 1, 0)], angles[min(i + 1, len(angles) - 1)]
            found = _optimize.minimize_scalar(
                lambda x: -size(x), bounds=(low, high), method="bounded", options={"xatol": 1e-10 * max(high, 1e-6)}
            )
            best = max(best, -float(found.fun))
        return best


def _zero(curve: Callable[[float], float], low: float, high: float) -> float | None:
    """Return where a curve changes its sign, to rounding; None if it does not."""
    if (curve(low) < 0.0) == (curve(high) < 0.0):
        return None
    return float(_optimize.brentq(lambda x: float(curve(x)), low, high, xtol=1e-15, rtol=1e-14))


def _convolved(first: Sequence[Any], second: Sequence[Any], sign: int) -> Array:
    out = [mpmath.mpf(0)] * (len(first) + len(second) - 1)
    for i, one in enumerate(first):
        for j, other in enumerate(second):
            out[i + j] += sign * one * other
    return np.array(out, dtype=object)


def _sum(weights: Sequence[Any], rows: Array) -> Array:
    total = np.array([flint.arb(0)] * rows.shape[1], dtype=object)
    for weight, row in zip(weights, rows, strict=True):
        if weight != 0:
            total = total + (row if weight == 1 else weight * row)
    return total


def _one_number(matrix: Array) -> tuple[Array, int] | None:
    """Return a row, of which all rows of a matrix are multiples in all digits, and the place of its largest number."""
    near = np.abs(_doubles(matrix))
    i, j = (int(place) for place in np.unravel_index(int(np.argmax(near)), near.shape))
    if near[i, j] == 0.0:
        return None
    row = matrix[i]
    less = matrix - np.outer(matrix[:, j] / row[j], row)
    return (row, j) if all(abs(float(value.mid())) <= 1e-60 for value in less.ravel()) else None


def _characteristic(a: Array) -> list[Any]:
    """Return the characteristic polynomial, the highest power first."""
    if not len(a):
        return [flint.arb(1)]
    polynomial = flint.arb_mat(a.tolist()).charpoly()
    return [polynomial[i] for i in range(len(a), -1, -1)]


def _number(ball: Any) -> Any:
    """Return the middle of a ball; zero where it may be zero."""
    if ball.contains(0):
        return mpmath.mpf(0)
    mantissa, exponent = ball.mid().man_exp()
    return mpmath.ldexp(int(mantissa), int(exponent))


def _doubles(matrix: Array) -> Array:
    flat = [float(value.mid()) for value in matrix.ravel()]
    return np.array(flat).reshape(matrix.shape)
