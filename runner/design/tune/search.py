"""The search for parameters: samples over the box, then sequential quadratic programming from the best of them.

Hard goals come first: as long as one is missed, the worst slack is raised. Once all are met, the
worst objective is lowered while they stay met. Loops that are unstable are made stable before.
Every point that is tried counts: the best is the answer, also after an interruption.
"""

import threading
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.optimize
import scipy.stats

from proofmass.runner.design.quantities.stopping import InterruptedSearch, go_on
from proofmass.runner.design.tune.goals_at import UNDEFINED, GoalRow, GoalsAt, TriedPoint
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.progress import Progress

KEPT = 0.0  # violation up to which a point counts as feasible
_AIM = 1e-6  # slack that the search keeps, so that rounding of the written values misses no goal
_ROUNDS = 40
_ACCURACY = 1e-8

_minimize: Any = scipy.optimize.minimize


class Search:
    """Looks for the best point and remembers it."""

    def __init__(self, goals: GoalsAt, progress: Progress | None, stop: threading.Event | None) -> None:
        self.goals, self._progress, self.stop = goals, progress, stop
        self.best: TriedPoint | None = None
        self.count = 0
        self.seen: list[Array] = []  # points to begin with, beside the graph's and the samples
        self.interrupted = False
        self._latest: TriedPoint | None = None
        self.first: TriedPoint
        tuning = goals.tuning
        self._expected = tuning.samples + tuning.starts * _ROUNDS // 2
        goals.note = self._noted

    def _noted(self, at: TriedPoint) -> None:
        self.count += 1
        if at.inside and (self.best is None or _order(at) < _order(self.best)):
            self.best = at
        if self._progress:
            self._progress(self.count, max(self._expected, self.count + 1))
        go_on(self.stop)

    def run(self) -> TriedPoint:
        """Return the best point."""
        try:
            self._all()
        except InterruptedSearch:
            self.interrupted = True
        return self.best or self.first

    def _all(self) -> None:
        self.first = self.goals.nominal()
        points = [
            self.first,
            *(self.goals.at(parts, slopes=False) for parts in self.seen),
            *(self.goals.at(parts, slopes=False) for parts in self._samples()),
        ]
        points.sort(key=_order)
        for start in _apart(points, self.goals.tuning.starts):
            self._from(start.parts)
        if self.best is not None:  # once more from the best of all
            self._from(self.best.parts)

    def _samples(self) -> Array:
        tuning = self.goals.tuning
        sobol = scipy.stats.qmc.Sobol(len(tuning.free), rng=np.random.default_rng(tuning.seed))
        points: Array = np.asarray(sobol.random(1 << (tuning.samples - 1).bit_length()), dtype=np.float64)
        first: Array = np.asarray(points[: tuning.samples], dtype=np.float64)
        return first

    def _from(self, parts: Array) -> None:
        at = self._full(parts)
        if not at.defined:
            at = self._stabilised(at)
        if not at.defined:
            return
        if at.violation > -_AIM and at.slacks:
            at = self._feasible(at)
        if at.violation <= KEPT and at.objectives:
            self._improved(at)

    def _full(self, parts: Array) -> TriedPoint:
        if self._latest is None or not np.array_equal(self._latest.parts, np.clip(parts, 0.0, 1.0)):
            self._latest = self.goals.at(parts)
        return self._latest

    def _stabilised(self, at: TriedPoint) -> TriedPoint:
        if at.growth is None:
            return at

        def growth(parts: Array) -> tuple[float, Array]:
            row = self._full(parts).growth
            return (row.value, row.gradient) if row is not None else (1.0, np.zeros(len(parts)))

        scale = max(abs(at.growth.value), 1e-6)
        optimum = _minimize(
            lambda parts: tuple(entry / scale for entry in growth(parts)),
            at.parts,
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(at.parts),
            options={"maxiter": _ROUNDS, "ftol": 1e-3},
        )
        return self._full(optimum.x)

    def _feasible(self, at: TriedPoint) -> TriedPoint:
        """Raise the worst slack until all goals are met, as far as it goes."""
        size = len(at.parts)

        def slacks(x: Array) -> Array:
            return np.asarray(_values(self._full(x[:size]).slacks, at.slacks) - x[size])

        def gradients(x: Array) -> Array:
            now = _gradients(self._full(x[:size]).slacks, at.slacks, size)
            return np.hstack([now, -np.ones((len(at.slacks), 1))])

        return self._solved(at, -max(at.violation, 0.0), -1.0, (2.0 * UNDEFINED, 0.05), slacks, gradients)

    def _improved(self, at: TriedPoint) -> TriedPoint:
        """Lower the worst objective while all hard goals stay met."""
        size, rows = len(at.parts), len(at.objectives)
        aims = np.array([min(_AIM, 0.25 * row.room) for row in at.slacks])

        def constraints(x: Array) -> Array:
            now = self._full(x[:size])
            return np.append(
                _values(now.slacks, at.slacks) - aims, x[size] - _values(now.objectives, at.objectives, 10.0)
            )

        def gradients(x: Array) -> Array:
            now = self._full(x[:size])
            above = np.hstack([_gradients(now.slacks, at.slacks, size), np.zeros((len(at.slacks), 1))])
            below = np.hstack([-_gradients(now.objectives, at.objectives, size), np.ones((rows, 1))])
            return np.vstack([above, below])

        return self._solved(at, at.objective, 1.0, (-1e4, 1e4), constraints, gradients)

    def _solved(
        self, at: TriedPoint, last: float, sign: float, ends: tuple[float, float], constraints: Any, gradients: Any
    ) -> TriedPoint:
        """Return the point at which a last number, times a sign, is least, from some value."""
        size = len(at.parts)
        optimum = _minimize(
            lambda x: (sign * x[size], np.append(np.zeros(size), sign)),
            np.append(at.parts, last),
            jac=True,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * size + [ends],
            constraints=[{"type": "ineq", "fun": constraints, "jac": gradients}],
            options={"maxiter": _ROUNDS, "ftol": _ACCURACY},
        )
        return self._full(optimum.x[:size])


def _order(at: TriedPoint) -> tuple[float, float]:
    """Return what is less of a better point: hard goals first, then the objective."""
    return 0.0 if at.violation <= KEPT else at.violation, at.objective


def _apart(points: Sequence[TriedPoint], count: int) -> list[TriedPoint]:
    """Return the best points that are not next to each other."""
    chosen: list[TriedPoint] = []
    least = 0.5 * len(points) ** (-1.0 / max(1, len(points[0].parts)))
    for at in points:
        if len(chosen) == count:
            break
        if all(float(np.max(np.abs(at.parts - other.parts))) > least for other in chosen):
            chosen.append(at)
    return chosen


def _values(rows: Sequence[GoalRow], like: Sequence[GoalRow], undefined: float = UNDEFINED) -> Array:
    """Return the values in the order of other rows; `undefined` where a quantity has none."""
    known = {(row.goal, row.case, row.sign): row.value for row in rows}
    return np.array([known.get((row.goal, row.case, row.sign), undefined) for row in like])


def _gradients(rows: Sequence[GoalRow], like: Sequence[GoalRow], size: int) -> Array:
    known = {(row.goal, row.case, row.sign): row.gradient for row in rows}
    nothing = np.zeros(size)
    return np.array([known.get((row.goal, row.case, row.sign), nothing) for row in like]).reshape(len(like), size)
