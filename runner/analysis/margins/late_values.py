"""Late values of a loop with several values of its wire in a period.

With the states x at the start of a period its values are C x and D of the earlier ones, and they
move the states on by B. If they come r values late, those from r on are of this period, and the
others of the last one:

    det(I + F exp(-j phi)) = 0,   F(z) = (C (z I - A)^-1 B + D) (P_now + P_before / z)

with a further factor exp(-j phi) at the wire. A pole exp(j theta) is on the circle where an
eigenvalue of F is of size one. As phi grows it goes out if that eigenvalue falls as theta grows,
and else in. Of q periods phi is q theta, which jumps at z = -1. There poles come from the lower
half plane, or go there, if an eigenvalue is larger than one: the turns of these count as if it
fell.

Where no value of a period depends on an earlier one of it, as behind a demodulator or an average, D
is 0. Then C = W V, where V has few rows, and V (z I - A)^-1 B (P_now + P_before / z) W has the
same eigenvalues but for zeros.
"""

import math
from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.frequencies import ABOUT_A_POLE, in_order
from proofmass.runner.host.arrays import AnyArray, Array, Complex

CircleCrossing = tuple[float, float, float]  # turn at the wire, angle of the pole in the upper half, and its way
_TURN = 2.0 * math.pi
_MOST_VALUES = 24  # in a period of any delay, where they depend on each other
_ANGLES = 256  # evenly spaced, and over all decades
_SMALL = 0.5  # size of F, up to which no eigenvalue of it is near one
_LOWEST = 1e-6  # part of the least angle of a pole
_MOST_NUMBERS = 4_000_000  # in matrices F of all delays at all angles
_RANK = 1e-13  # of the largest row
_HALF_TURN = -1.0 - 1e-12  # z, but not where a pole may lie on the circle
_HALVED = 44  # times that an angle between two of the grid is


class LateValues:
    """A loop of several values of the wire in a period, late by 0, 1, ... and less than a period."""

    def __init__(self, a: Array, b: Array, rows: Array, d: Array, weights: Array, grid: Array) -> None:
        """Take A, B, the rows of C or V, D, the weights I or W, and angles at which eigenvalues are looked at."""
        whole, count = np.vstack([b, d]), len(weights)
        self._now = np.array([whole[:, late:] @ weights[: count - late] for late in range(count)])
        self._before = np.array([whole[:, :late] @ weights[count - late :] for late in range(count)])
        self._a, self._rows, self._grid = a, rows, grid

    @classmethod
    def of(cls, system: OpenLoop) -> "LateValues | None":
        """Return those of a loop; None if values are too many, or many that depend on each other."""
        a, b, c, d = system.matrices
        rows, weights, few = c, np.eye(len(c)), len(c) <= _MOST_VALUES
        if d.any() and not few:
            return None
        if not d.any():
            _, sizes, turned = np.linalg.svd(c, full_matrices=False)
            rows = turned[sizes > _RANK * sizes.max(initial=0.0)]
            d, weights = np.zeros((len(rows), len(c))), c @ rows.T
        grid = _angles(np.concatenate([system.open_poles, system.poles]))
        if not few and len(c) * len(grid) * len(rows) ** 2 > _MOST_NUMBERS:
            return None
        return cls(a, b, rows, d, weights, grid)

    def sizes(self) -> Array:
        """Return the sizes of the slowest poles with values late by 1, 2, ... and less than a period, where D is 0."""
        n, count = len(self._a), len(self._now) - 1
        closed = np.zeros((count, 2 * n, 2 * n))
        closed[:, :n, :n] = self._a - self._now[1:, :n] @ self._rows
        closed[:, :n, n:] = -self._before[1:, :n] @ self._rows
        closed[:, n:, :n] = np.eye(n)
        return np.asarray(np.max(np.abs(np.linalg.eigvals(closed)), axis=1, initial=0.0))

    def on_circle(self) -> list[list[CircleCrossing]]:
        """Return turns at the wire that put a pole on the circle, of values late by 0, 1, ..."""
        z, every = np.exp(1j * self._grid), range(len(self._now))
        resolved = self._resolved(z)
        sizes = np.abs([self._eigenvalues(late, z, resolved) for late in every])
        late, place, order = np.nonzero(np.diff(sizes > 1.0, axis=1))
        low, high, falls = self._grid[place], self._grid[place + 1], sizes[late, place, order] > 1.0

        def values(angles: Array) -> Complex:
            z = np.exp(1j * angles)
            return self._eigenvalues(late, z, self._resolved(z))[np.arange(len(late)), order]

        for _ in range(_HALVED):
            middle = 0.5 * (low + high)
            before = (np.abs(values(middle)) > 1.0) == falls
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        turns = np.angle(-values(high)) % _TURN
        half = np.array([_HALF_TURN + 0j])
        at_half = (self._eigenvalues(number, half, self._resolved(half))[0] for number in every)
        larger = (np.angle(-each[np.abs(each) > 1.0]) % _TURN for each in at_half)
        pairs = [[(turn, math.pi, 1.0) for turn in each.tolist()] for each in larger]
        for number, turn, angle, out in zip(late.tolist(), turns.tolist(), high.tolist(), falls.tolist(), strict=True):
            pairs[number].append((turn, angle, 1.0 if out else -1.0))
        return pairs

    def _resolved(self, z: Complex) -> Complex:
        """Return C (z I - A)^-1 at some places, or that of V, and I beside it."""
        turned = z[:, None, None] * np.eye(len(self._a)) - self._a.T
        columns = np.broadcast_to(self._rows.T + 0j, (len(z), *self._rows.T.shape))
        eyes = np.broadcast_to(np.eye(len(self._rows)), (len(z), len(self._rows), len(self._rows)))
        both = np.concatenate([np.linalg.solve(turned, columns).swapaxes(1, 2), eyes], axis=2)
        return np.asarray(both, dtype=np.complex128)

    def _eigenvalues(self, late: Any, z: Complex, resolved: Complex) -> Complex:
        """Return the eigenvalues of F, the smallest first, of values late by some at some places.

        They count as 0 where all are small.
        """
        matrices: AnyArray = resolved @ (self._now[late] + self._before[late] / z[:, None, None])
        large, found = np.linalg.norm(matrices, axis=(1, 2)) >= _SMALL, np.zeros(matrices.shape[:2], dtype=complex)
        found[large] = np.linalg.eigvals(matrices[large])
        return np.asarray(np.take_along_axis(found, np.argsort(np.abs(found), axis=-1), axis=-1))


def _angles(poles: Complex) -> Array:
    """Return angles between 0 and pi, dense at poles."""
    logs: Complex = np.log(poles[np.abs(poles) > _LOWEST])
    apart = np.abs(logs)[np.abs(logs) > _LOWEST**2]
    lowest = _LOWEST * min(1.0, float(np.min(apart, initial=1.0)))
    near = [abs(log.imag) + max(abs(log.real), 1e-9 * abs(log)) * ABOUT_A_POLE for log in logs]
    points = [np.linspace(0.0, math.pi, _ANGLES), np.geomspace(lowest, math.pi, _ANGLES), *near]
    on_circle = np.abs(logs[np.abs(logs.real) < 1e-9 * np.abs(logs) + 1e-15].imag)
    return in_order(points, lowest, math.pi, on_circle)
