"""Late values of a loop in which no value of a period depends on an earlier one of it, as behind a
demodulator or an average.

With the states x at the start of a period its values are C x, and they move the states on by B. If
they come r values late, those from r on are of this period, and the others of the last one:

    det(I + F exp(-j phi)) = 0,   F(z) = V (z I - A)^-1 (B_now W_now + B_before W_before / z),   C = W V

with a further factor exp(-j phi) at the wire. V has few rows, so F is small. A pole exp(j theta) is
on the circle where an eigenvalue of F is of size one. As phi grows it goes out if that eigenvalue
falls as theta grows, and else in. Of q periods phi is q theta, which jumps at z = -1. There poles come
from the lower half plane, or go there, if an eigenvalue is larger than one: the turns of these count
as if it fell.
"""

import math

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.frequencies import ABOUT_A_POLE, in_order
from proofmass.runner.host.arrays import AnyArray, Array, Complex

CircleCrossing = tuple[float, float, float]  # turn at the wire, angle of the pole in the upper half, and its way
_ANGLES = 256  # evenly spaced, and over all decades
_LOWEST = 1e-6  # part of the least angle of a pole
_MOST_NUMBERS = 4_000_000  # in matrices F of all delays at all angles
_RANK = 1e-13  # of the largest row
HALF_TURN = -1.0 - 1e-12  # z, but not where a pole may lie on the circle
_HALVED = 44  # times that an angle between two of the grid is


class LateValues:
    """A loop of several values of the wire in a period, of which none depends on another one."""

    def __init__(self, a: Array, b: Array, weights: Array, rows: Array, grid: Array) -> None:
        """Take A, B, W and V, and angles at which eigenvalues are looked at."""
        count = len(weights)
        moved = [
            (b[:, late:] @ weights[: count - late], b[:, :late] @ weights[count - late :]) for late in range(count)
        ]
        self._now, self._before = (np.array(parts) for parts in zip(*moved, strict=True))
        self._a, self._rows, self._grid = a, rows, grid

    @classmethod
    def of(cls, system: OpenLoop) -> "LateValues | None":
        """Return those of a loop; None if values of a period depend on each other, or are too many."""
        a, b, c, d = system.matrices
        if d.any():
            return None
        _, sizes, rows = np.linalg.svd(c, full_matrices=False)
        rows = rows[sizes > _RANK * sizes.max(initial=0.0)]
        grid = _angles(np.concatenate([system.open_poles, system.poles]))
        if len(c) * len(grid) * len(rows) ** 2 > _MOST_NUMBERS:
            return None
        return cls(a, b, c @ rows.T, rows, grid)

    def sizes(self) -> Array:
        """Return the sizes of the slowest poles with values late by 1, 2, ... and less than a period."""
        n, count = len(self._a), len(self._now) - 1
        closed = np.zeros((count, 2 * n, 2 * n))
        closed[:, :n, :n], closed[:, :n, n:] = self._a - self._now[1:] @ self._rows, -self._before[1:] @ self._rows
        closed[:, n:, :n] = np.eye(n)
        return np.asarray(np.max(np.abs(np.linalg.eigvals(closed)), axis=1, initial=0.0))

    def on_circle(self) -> list[list[CircleCrossing]]:
        """Return turns at the wire that put a pole on the circle, of values late by 0, 1, ..."""
        sizes = np.abs(self._eigenvalues(np.arange(len(self._now))[:, None], self._grid))
        late, place, order = np.nonzero(np.diff(sizes > 1.0, axis=1))
        low, high, falls = self._grid[place], self._grid[place + 1], sizes[late, place, order] > 1.0
        each = np.arange(len(late))
        for _ in range(_HALVED):
            middle = 0.5 * (low + high)
            before = (np.abs(self._eigenvalues(late, middle)[each, order]) > 1.0) == falls
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        turns = np.angle(-self._eigenvalues(late, high)[each, order]) % (2.0 * math.pi)
        pairs = [at_half_turn(of_half) for of_half in self._at_half_turn()]
        for number, *pair in zip(late.tolist(), turns.tolist(), high.tolist(), falls.tolist(), strict=True):
            pairs[number].append((pair[0], pair[1], 1.0 if pair[2] else -1.0))
        return pairs

    def _at_half_turn(self) -> AnyArray:
        """Return the eigenvalues of F at z = -1 for all delays."""
        resolved = np.linalg.solve(HALF_TURN * np.eye(len(self._a)) - self._a.T, self._rows.T).T
        return np.asarray(np.linalg.eigvals(resolved @ (self._now + self._before / HALF_TURN)))

    def _eigenvalues(self, late: AnyArray, angles: Array) -> Complex:
        """Return the eigenvalues of F, the smallest first, of values late by some at some angles."""
        back = np.exp(-1j * angles)[:, None, None]
        turned = np.eye(len(self._a)) / back - self._a.T
        columns = np.broadcast_to(self._rows.T + 0j, (len(angles), *self._rows.T.shape))
        resolved = np.linalg.solve(turned, columns).swapaxes(1, 2)
        found: AnyArray = np.linalg.eigvals(resolved @ (self._now[late] + self._before[late] * back))
        return np.asarray(np.take_along_axis(found, np.argsort(np.abs(found), axis=-1), axis=-1))


def at_half_turn(values: AnyArray) -> list[CircleCrossing]:
    """Return the turns at which eigenvalues of a late loop at z = -1 count."""
    return [(float(turn), math.pi, 1.0) for turn in np.angle(-values[np.abs(values) > 1.0]) % (2.0 * math.pi)]


def _angles(poles: Complex) -> Array:
    """Return angles between 0 and pi, dense at poles."""
    logs: Complex = np.log(poles[np.abs(poles) > _LOWEST])
    apart = np.abs(logs)[np.abs(logs) > _LOWEST**2]
    lowest = _LOWEST * min(1.0, float(np.min(apart, initial=1.0)))
    near = [abs(log.imag) + max(abs(log.real), 1e-9 * abs(log)) * ABOUT_A_POLE for log in logs]
    points = [np.linspace(0.0, math.pi, _ANGLES), np.geomspace(lowest, math.pi, _ANGLES), *near]
    on_circle = np.abs(logs[np.abs(logs.real) < 1e-9 * np.abs(logs) + 1e-15].imag)
    return in_order(points, lowest, math.pi, on_circle)
