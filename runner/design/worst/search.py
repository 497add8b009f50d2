"""The search for the worst case in a box of parameters.

Derivatives name a corner: each parameter goes where the derivative says that it gets worse. At that
corner they name the next, until it is its own. From the worst corners each parameter is tried at
its other end. If there are few corners all are tried. Random points look for what the corners miss,
and from the worst points a bounded descent looks inside. Nothing of this proves that there is no
worse case, so it counts what was tried.
"""

import itertools
import math
import threading
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize

from proofmass.runner.design.quantities.evaluator import STABLE, Evaluator, QuantityReadings, Reasons
from proofmass.runner.design.quantities.stopping import go_on
from proofmass.runner.design.worst.box import BOTH_WAYS, ToleranceBox
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.progress import Progress

_UNDEFINED = 1e6  # value of an unstable loop, as a multiple of that at the start of a descent; its growth is added
_LARGEST = 5e5  # largest finite value, as such a multiple
_DESCENTS = 2  # bounded descents of each quantity
_TURNS = 20  # corners that derivatives may name in a row
_SWEEPS = 4  # rounds in which every parameter is tried at its other end

_minimise: Any = scipy.optimize.minimize


class Side(NamedTuple):
    """A quantity and the side on which it is bad: 1 if low values are, -1 if high ones are."""

    quantity: str
    sign: float


class Badness(NamedTuple):
    """Order of badness: undefined, its loop's growth counts, elsewhere its value."""

    undefined: bool
    value: float


class SearchedPlace(NamedTuple):
    """A point of the box and what the quantities are there."""

    place: tuple[float, ...]
    readings: QuantityReadings
    slopes: bool
    why: Reasons  # of readings that are None

    @property
    def corner(self) -> bool:
        """True if every parameter is at an end."""
        return all(abs(part) == 1.0 for part in self.place)


class BoxSearch:
    """Evaluates points of a box and remembers all of them."""

    def __init__(
        self,
        evaluator: Evaluator,
        box: ToleranceBox,
        expected: int,
        progress: Progress | None,
        stop: threading.Event | None,
    ) -> None:
        self.evaluator, self.box = evaluator, box
        self.cases: dict[tuple[float, ...], SearchedPlace] = {}
        self.random: list[tuple[float, ...]] = []
        self._expected, self._progress, self._stop = expected, progress, stop

    def at(self, place: Sequence[float], slopes: bool = False) -> SearchedPlace:
        """Return the case at a place, known already or evaluated now."""
        key = tuple(float(part) for part in place)
        known = self.cases.get(key)
        if known is not None and (known.slopes or not slopes):
            return known
        go_on(self._stop)
        readings = self.evaluator.readings(self.box.values(key), slopes)
        self.cases[key] = SearchedPlace(key, readings, slopes, self.evaluator.why)
        if self._progress:
            self._progress(len(self.cases), max(self._expected, len(self.cases) + 1))
        return self.cases[key]

    def badness(self, case: SearchedPlace, side: Side) -> Badness:
        """Return what grows as the quantity gets worse, and is beyond all values where a loop is unstable."""
        reading = case.readings[side.quantity]
        if reading is None:
            grown = [r for name, r in case.readings.items() if name.startswith(STABLE)]
            return Badness(True, max((r.value for r in grown if r is not None), default=0.0))
        return Badness(False, -side.sign * reading.value)

    def gradient(self, case: SearchedPlace, side: Side, ways: tuple[float, float] = BOTH_WAYS) -> Array:
        """Return the derivatives of the badness by the places, both ways or one."""
        reading, sign = case.readings[side.quantity], -side.sign
        if reading is None:
            grown = [r for name, r in case.readings.items() if name.startswith(STABLE) and r is not None]
            reading, sign = max(grown, key=lambda r: r.value, default=None), 1.0
        slopes: Mapping[str, float] = reading.slopes if reading is not None else {}
        rows = self.box.slopes(case.place, ways)
        return np.array([sign * sum(slopes.get(name, 0.0) * by for name, by in row.items()) for row in rows])

    def worst(self, side: Side) -> SearchedPlace:
        """Return the worst case so far."""
        return max(self.cases.values(), key=lambda case: self.badness(case, side))

    def search(self, sides: Sequence[Side], corners: int, samples: int, seed: int) -> None:
        """Try everything, for each of some quantities and sides."""
        size = len(self.box.ranges)
        nominal = (0.0,) * size
        self.at(nominal, slopes=True)
        for number, sign in itertools.product(range(size), (-1.0, 1.0)):  # one at a time
            self.at([sign if i == number else 0.0 for i in range(size)])
        for side in sides:
            self._named(side, nominal)
        if 2**size <= corners:
            for corner in itertools.product((-1.0, 1.0), repeat=size):
                self.at(corner)
        for place in np.random.default_rng(seed).uniform(-1.0, 1.0, (samples, size)):
            self.random.append(self.at(place).place)
        for side in sides:
            self._others(side)
            starts = sorted(self.cases.values(), key=lambda case: self.badness(case, side), reverse=True)[:_DESCENTS]
            drawn = sorted((self.cases[place] for place in self.random), key=lambda c: self.badness(c, side))
            starts += drawn[-1:]
            for case in starts:
                self._inside(side, case)
            self._others(side)

    def _named(self, side: Side, place: tuple[float, ...]) -> None:
        """Follow the corners that derivatives name."""
        for _ in range(_TURNS):
            case = self.at(place, slopes=True)
            gradient = self.gradient(case, side)
            signs = (float(np.sign(g)) or part or 1.0 for g, part in zip(gradient, place, strict=True))
            following = tuple(1.0 if sign > 0.0 else -1.0 for sign in signs)
            if following in self.cases and self.cases[following].slopes:
                break
            place = following

    def _others(self, side: Side) -> None:
        """Try every parameter at its other end, or its other choices, from the worst corner, until none is worse."""
        corners = [case for case in self.cases.values() if case.corner]
        if not corners:
            return
        best = max(corners, key=lambda case: self.badness(case, side))
        for _ in range(_SWEEPS):
            tried = [
                self.at([other if i == number else part for i, part in enumerate(best.place)])
                for number, wanted in enumerate(self.box.ranges)
                for other in wanted.others(best.place[number])
            ]
            worse = max(tried, key=lambda case: self.badness(case, side))
            if self.badness(worse, side) <= self.badness(best, side):
                break
            best = worse

    def _inside(self, side: Side, case: SearchedPlace) -> None:
        """Descend from a case within the bounds, if it has a value."""
        undefined, badness = self.badness(case, side)
        if undefined or not math.isfinite(badness):
            return
        size = abs(badness) or 1.0

        def objective(place: Array) -> tuple[float, Array]:
            there = self.at(place.tolist(), slopes=True)
            lost, value = self.badness(there, side)
            if lost:
                return -(_UNDEFINED + value), -self.gradient(there, side)
            return float(np.clip(-value / size, -_LARGEST, _LARGEST)), -self.gradient(there, side) / size

        _minimise(
            objective,
            np.array(case.place),
            jac=True,
            method="L-BFGS-B",
            bounds=[(-1.0, 1.0)] * len(self.box.ranges),
            options={"maxiter": 15, "ftol": 1e-9},
        )
