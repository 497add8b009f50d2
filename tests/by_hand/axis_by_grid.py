"""Crossovers, peaks and counts of L = N / D by a dense grid and scipy's bisection, apart from the product."""

import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import optimize

Numbers = npt.NDArray[np.float64]
Places = npt.NDArray[np.complex128]


@dataclass(frozen=True)
class ByGrid:
    """Integer coefficients of N and D, lowest power first, in z or s."""

    above: list[int]
    below: list[int]
    sampled: bool

    def at(self, w: Numbers) -> Places:
        """L at angles of a period, or at angular frequencies."""
        place = np.exp(1j * w) if self.sampled else 1j * w
        return np.asarray(np.polyval(self.above[::-1], place) / np.polyval(self.below[::-1], place))

    @property
    def grid(self) -> Numbers:
        if not self.sampled:
            return np.geomspace(1e-7, 1e7, 60_001)
        near = np.geomspace(1e-6, 0.1, 8001)
        return np.concatenate([near, np.linspace(0.1, math.pi, 30_001)[1:-1], math.pi - near[::-1] * 1e-3])

    def roots_of(self, measure: Callable[[Places], Numbers]) -> list[float]:
        """Where a measure of L changes its sign, and has no pole."""
        w, values = self.grid, measure(self.at(self.grid))
        places = np.flatnonzero(values[:-1] * values[1:] < 0.0)
        found = [
            optimize.brentq(lambda v: float(measure(self.at(np.array(v)))), w[i], w[i + 1], xtol=1e-300, rtol=1e-14)
            for i in places.tolist()
        ]
        return [v for v in found if abs(complex(self.at(np.array(v)))) < 1e5]

    def largest(self, measure: Callable[[Places], Numbers]) -> float:
        """The largest value on the open axis; the ends of the grid are next to its ends."""
        w, values = self.grid, measure(self.at(self.grid))
        best = int(np.argmax(values))
        low, high = w[max(best - 1, 0)], w[min(best + 1, len(w) - 1)]
        found = optimize.minimize_scalar(
            lambda v: -float(measure(self.at(np.array(v)))),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-12},
        )
        return max(float(values[best]), -float(found.fun))

    def closed_poles(self, factor: float = 1.0) -> Places:
        """The roots of f N + D."""
        size = max(len(self.above), len(self.below))
        both = [np.pad(np.array(p, dtype=float), (0, size - len(p))) for p in (self.above, self.below)]
        return np.asarray(np.roots((factor * both[0] + both[1])[::-1]), dtype=complex)

    def outside(self, factor: float) -> int:
        """How many of them are not inside."""
        poles = self.closed_poles(factor)
        return int(np.sum(np.abs(poles) >= 1.0 if self.sampled else poles.real >= 0.0))


def random_loops(sampled: bool, count: int) -> Iterator[ByGrid]:
    """Loops of one to four poles, with zeros and delays, integrators, resonances, and poles outside."""
    dice = random.Random(10 + sampled)
    for _ in range(count):
        above, below = np.poly1d([dice.choice((-37, -13, 11, 23, 59, 413))]), np.poly1d([dice.choice((10, 43, 307))])
        for _ in range(dice.randint(1, 2)):
            below *= np.poly1d(_factor(dice, sampled))
        if dice.random() < 0.6:
            above *= np.poly1d(_factor(dice, sampled)[-2 if dice.random() < 0.7 else 0 :])
        if sampled and dice.random() < 0.5:
            below *= np.poly1d([1] + [0] * dice.randint(1, 3))
        if above.order > below.order:
            above, below = below, above
        if any(abs(zero - pole) < 1e-6 for zero in above.roots for pole in below.roots):
            continue  # what cancels is taken out before a loop comes to its axis
        yield ByGrid([int(v) for v in above.coeffs[::-1]], [int(v) for v in below.coeffs[::-1]], sampled)


def _factor(dice: random.Random, sampled: bool) -> list[int]:
    """Coefficients of one pole or a pair, highest power first."""
    if sampled:
        choices = [[10, -dice.randint(-9, 9)], [1, -1], [100, -160, dice.randint(66, 99)], [5, -7], [10, -2, 9]]
    else:
        choices = [[1, dice.randint(1, 30)], [1, 0], [1, 1, dice.randint(1, 99)], [1, -3], [10, 1, 40]]
    return dice.choice(choices)
