"""The box of a worst case: a place in it, -1 to 1 along each coordinate, as parameters of the graph.

A coordinate is a tolerance, what a study spreads, a law of drift that differs between sensors, its
age, or a list of choices. Parameters are moved as in a run of a study: each from what its formula
says where others have moved, spread about that, then aged. Normal deviates go up to three standard
deviations.

Correlated deviates: places p of a group of m go to z = max|p| t d with d = R p, R the matrix of
correlations. t is the largest with |z_i| <= 3 for each and z' R^-1 z <= 9 m: nothing less likely
than the corner of m independent ones counts. Alone, a parameter takes the others along to their
expected values, and opposite ends of two that are fully correlated do not exist.
"""

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.ageing import LAWS, WALK, Drift
from proofmass.graphs.studies.distributions import NORMAL, Spread
from proofmass.graphs.studies.study import Study
from proofmass.runner.design.worst.ranges import MIDDLE, SIGMAS, Range, Tolerance, read_tolerances
from proofmass.runner.host.arrays import AnyArray

_STEP = 1e-6  # of a place, for derivatives of the box itself
BOTH_WAYS, UP, DOWN = (-1.0, 1.0), (0.0, 1.0), (-1.0, 0.0)  # of derivatives by a place
_TOWARDS = 0.5  # the place of all others where a coordinate is tried too: about 0 a relative spread leaves no room
AGE = "age"
_PER = {"ramp": "/s", "arrhenius": "/s", WALK: "/sqrt(s)"}

_minimise: Any = scipy.optimize.minimize

Move = Callable[[float, Sequence[float]], float]  # a value before, and the deviates of the place: the value after


def box_of(source: Graph | Study, tolerances: Mapping[str, Any]) -> "ToleranceBox":
    """Return the box of tolerances, in place of the spread of a study that names the same, or of a study alone.

    Raises `ModelError` where nothing varies, or a block does not take all of a range.
    """
    study = source if isinstance(source, Study) else None
    graph = source.graph if isinstance(source, Study) else source
    read = read_tolerances(graph, tolerances)
    box = ToleranceBox(study.adjustable if study else Adjustable(flatten(graph)), study, read)
    problems = list(box.refused())
    if not box.ranges:
        why = "; ".join(f"{name}: {reason}" for name, reason in box.left_out.items())
        hint = 'say --tolerance "torquer.gain=5 %", or name a study with [spread]'
        problems.append(Problem(message="nothing varies", got=why, hint=hint, path=("tolerances",)))
    if problems:
        raise ModelError([graph.placed(problem) for problem in problems])
    return box


def varied(source: Graph | Study, tolerances: Mapping[str, Any]) -> "ToleranceBox | None":
    """Return the box of what tolerances and a study let vary; none where they say nothing."""
    of_study = isinstance(source, Study) and (source.spread or source.sweep or source.drift)
    return box_of(source, tolerances) if tolerances or of_study else None


class ToleranceBox:
    """The coordinates of a study or of tolerances, and the parameters at any place."""

    def __init__(self, adjustable: Adjustable, study: Study | None, tolerances: Mapping[str, Tolerance]) -> None:
        self._adjustable = adjustable
        self.ranges: list[Range] = []
        self.left_out: dict[str, str] = {}  # why something that varies does not count
        self._scales: list[float] = []  # of the deviate of each coordinate; negative where it lowers the parameter
        self._chosen: dict[str, list[Move]] = {}
        self._own: dict[str, list[int]] = {}  # coordinates of each parameter, and the age where it drifts
        self.ageing: frozenset[str] = frozenset(map(study.name_of, study.drift)) if study else frozenset()
        if study is not None:
            for name, values in study.sweep.items():
                twice = name in study.spread or name in study.drift
                written = f"sweep.{study.name_of(name)}" if twice else study.name_of(name)
                self._chosen[name] = [self._choice(name, written, study.unit_of(name), values, study.nominal(name))]
                self._own[name] = [len(self.ranges) - 1]
            self._age = self._ages(study)
        ages = [place for place, wanted in enumerate(self.ranges) if wanted.name == AGE]
        for name in dict.fromkeys([*(study.spread if study else ()), *(study.drift if study else ()), *tolerances]):
            moves, first = self._chosen.setdefault(name, []), len(self.ranges)
            if name in tolerances:
                moves.append(self._tolerance(name, tolerances[name]))
            elif study is not None and name in study.spread:
                moves.append(self._spread(study, name, study.spread[name]))
            if study is not None and name in study.drift:
                moves.append(self._drift(study, name, study.drift[name]))
                self._own[name] = [*self._own.get(name, ()), *ages]
            self._own[name] = [*self._own.get(name, ()), *range(first, len(self.ranges))]
        self._every = tuple(self.ranges)
        self._written = dict(study.written if study else {}) | {name: one.written for name, one in tolerances.items()}
        self._groups = list(self._correlated(study, tolerances)) if study else []
        self._order = sorted(self._chosen, key=lambda name: adjustable.dependence.places.get(name, -1))
        if study is not None:
            self.left_out |= {
                study.name_of(n): "calibrations set it, and here are none" for n in study.recalibration.carried
            }
        self._count()

    def values(self, place: Sequence[float] | AnyArray) -> dict[str, float]:
        """Return the parameters and values at a place."""
        whole = np.zeros(len(self._scales))
        whole[self._counted] = place
        return self._values(whole)

    def slopes(self, place: Sequence[float], ways: tuple[float, float] = BOTH_WAYS) -> list[dict[str, float]]:
        """Return the derivatives of the parameters by each coordinate, both ways or one; those by
        choices are zero.

        The two ways differ at the nominal place, where the ends of a range may be apart by
        different widths.
        """
        rows = []
        for number, wanted in enumerate(self.ranges):
            ends = np.array([place, place], dtype=float)
            ends[:, number] = np.clip(ends[:, number] + _STEP * np.array(ways), -1.0, 1.0)
            apart = 0.0 if wanted.choices else ends[1, number] - ends[0, number]
            low, high = (self.values(end) for end in ends)
            rows.append({name: (high[name] - low[name]) / apart if apart else 0.0 for name in low})
        return rows

    def largest_change(self, up: AnyArray, down: AnyArray) -> float:
        """Return the most by which something grows within the box, from its derivatives by each place, up and down."""
        number_of = {place: number for number, place in enumerate(self._counted)}
        alone, together = set(number_of.values()), 0.0
        for members, matrix in self._groups:
            numbers = [number_of[place] for place in members if place in number_of]
            inner = np.array([place in number_of for place in members])
            slopes = np.zeros(len(members))
            slopes[inner] = 0.5 * (up + down)[numbers]
            together += _farthest(matrix, slopes * np.sign([self._scales[place] for place in members]))
            alone -= set(numbers)
        return together + sum(max(float(up[number]), -float(down[number])) for number in alone)

    def widths(self) -> dict[str, float]:
        """Return how far each parameter moves with each coordinate alone, wherever the others are; none that stays."""
        rows = np.eye(len(self.ranges))
        ends = [np.where(row, sign, others) for row in rows for sign in (-1.0, 1.0) for others in (0.0, _TOWARDS)]
        alone = [self.values(end) for end in ends]
        widths = {name: max(at[name] for at in alone) - min(at[name] for at in alone) for name in self._order}
        return {name: width for name, width in widths.items() if width > 0.0}

    def hulls(self) -> list[Range]:
        """Return the parameters that vary, each with all that it is at any age while those it follows from are nominal.

        The value of the graph is in it.
        """
        hulls = list[Range]()
        for name in sorted(self._own):
            nominal = self._adjustable.nominal(name)
            values = [nominal, *self._alone(name)]
            if min(values) < max(values):
                written, unit = self._written.get(name, name), self._adjustable.unit_of(name)
                hulls.append(Range(name, written, unit, nominal, min(values), max(values)))
        return hulls

    def _alone(self, name: str) -> Iterator[float]:
        """Yield a parameter at the ends of its own coordinates, in which it is monotone, at all ages and choices."""
        ends = [self._ends(place) for place in self._own[name]]
        for corner in itertools.product(*ends):
            deviates, value = [0.0] * len(self._scales), self._adjustable.nominal(name)
            for place, deviate in zip(self._own[name], corner, strict=True):
                deviates[place] = deviate
            for move in self._chosen[name]:
                value = move(value, deviates)
            yield value

    def _ends(self, place: int) -> Sequence[float]:
        last = len(self._every[place].choices) - 1
        if last < 0:
            return [-self._scales[place], self._scales[place]]
        return [(2.0 * number - last) / last or MIDDLE for number in range(last + 1)] if last else [0.0]

    def refused(self) -> Iterator[Problem]:
        """Yield the coordinates with ends that a block does not take, all others nominal."""
        for row, wanted in zip(np.eye(len(self.ranges)), self.ranges, strict=True):
            ends = self.values(-row), self.values(row)
            if not all(self._adjustable.takes(name, value) for end in ends for name, value in end.items()):
                got, path = f"{wanted.low:g} to {wanted.high:g}", ("tolerances", wanted.written)
                yield Problem(message="the block does not take all of its range", got=got, path=path)

    def _values(self, place: AnyArray) -> dict[str, float]:
        deviates, values = self._deviates(place), dict[str, float]()
        for name in self._order:
            value = self._adjustable.dependence.followed(values).get(name, self._adjustable.nominal(name))
            for move in self._chosen[name]:
                value = move(value, deviates)
            values[name] = value
        return values

    def _deviates(self, place: AnyArray) -> list[float]:
        deviates = place * self._scales
        for members, matrix in self._groups:
            parts = deviates[members] / SIGMAS
            along = matrix @ parts
            size, square = float(np.max(np.abs(parts))), float(parts @ along)
            if square <= 1e-12 * size * size:
                deviates[members] = 0.0
                continue
            largest = min(SIGMAS / float(np.max(np.abs(along))), SIGMAS * math.sqrt(len(members) / square))
            deviates[members] = size * largest * along
        return [float(deviate) for deviate in deviates]

    def _add(self, wanted: Range, scale: float = 1.0) -> int:
        self.ranges.append(wanted)
        self._scales.append(scale)
        return len(self.ranges) - 1

    def _choice(self, name: str, written: str, unit: str, values: Sequence[float], nominal: float) -> Move:
        """Add a list of values, of which the one next to that of the graph is the nominal one."""
        ordered = tuple(sorted(set(values)))
        nearest = min(ordered, key=lambda value: abs(value - nominal))
        choices = Range(name, written, unit, nearest, ordered[0], ordered[-1], ordered)
        place = self._add(choices)
        return lambda _, at: choices.at(at[place])

    def _ages(self, study: Study) -> Callable[[Sequence[float]], float]:
        if not study.drift or len(study.epochs) == 1:
            return lambda _: study.epochs[0]
        chosen = self._choice(AGE, AGE, "s", study.epochs, study.epochs[0])
        return lambda at: chosen(0.0, at)

    def _tolerance(self, name: str, tolerance: Tolerance) -> Move:
        nominal = self._adjustable.nominal(name)
        low, high = (tolerance.about(nominal, nominal, end) for end in (-1.0, 1.0))
        place = self._add(Range(name, tolerance.written, tolerance.unit, nominal, low, high))
        return lambda base, at: tolerance.about(base, nominal, at[place])

    def _spread(self, study: Study, name: str, spread: Spread) -> Move:
        nominal, unit, written = study.nominal(name), study.unit_of(name), study.name_of(name)
        if spread.shape == "values":
            return self._choice(name, written, unit, spread.values, nominal)
        scale = min(spread.truncated, SIGMAS) if spread.shape in NORMAL else 1.0
        ends = spread.of_normal(nominal, -scale), spread.of_normal(nominal, scale)
        wanted = Range(name, written, unit, nominal, min(ends), max(ends))
        place = self._add(wanted, math.copysign(scale, ends[1] - ends[0]))
        return lambda base, at: spread.of_normal(base, at[place])

    def _drift(self, study: Study, name: str, drift: Drift) -> Move:
        """Add the laws that differ between sensors: pace, and how far a walk is at the age."""
        unit, places = "1" if drift.relative else study.unit_of(name), dict[int, int]()
        for sample, law in enumerate(sorted(LAWS, key=lambda law: law == WALK)):  # as `Drift.aged` numbers its deviates
            mean = 0.0 if law == WALK else getattr(drift, law)
            width = SIGMAS * (drift.random_walk if law == WALK else getattr(drift, f"{law}_spread"))
            if width:
                written, per = f"drift.{study.name_of(name)}.{law}", _PER.get(law, "")
                wanted = Range(f"drift.{name}.{law}", written, f"{unit}{per}", mean, mean - width, mean + width)
                places[sample] = self._add(wanted, SIGMAS)

        def aged(base: float, at: Sequence[float]) -> float:
            def deviate(_seed: int, _run: int, _stream: int, sample: int) -> float:
                return at[places[sample]] if sample in places else 0.0

            return drift.aged(base, [self._age(at)], 0, 0, 0, deviate)[0]

        return aged

    def _correlated(self, study: Study, tolerances: Mapping[str, Tolerance]) -> Iterator[tuple[list[int], AnyArray]]:
        """Yield coordinates of each correlated group, and the matrix of its correlations."""
        pairs = {(a, b): r for a, b, r in study.correlation.pairs if r and not {a, b} & tolerances.keys()}
        places = {wanted.name: place for place, wanted in enumerate(self.ranges) if wanted.name in study.spread}
        left = dict.fromkeys(name for pair in pairs for name in pair)
        while left:
            group, size = [next(iter(left))], 0
            while size < len(group):
                size = len(group)
                group += [n for n in left if n not in group and any(n in pair and {*pair} & {*group} for pair in pairs)]
            left = {name: None for name in left if name not in group}
            matrix = [[1.0 if a == b else pairs.get((a, b), pairs.get((b, a), 0.0)) for b in group] for a in group]
            yield [places[name] for name in group], np.array(matrix)

    def _count(self) -> None:
        """Leave out coordinates that move nothing, wherever the others are."""
        size = len(self.ranges)
        counted = list[int]()
        for place, wanted in sorted(enumerate(self.ranges), key=lambda pair: pair[1].name):
            others = (np.full(size, towards) for towards in (0.0, _TOWARDS, 1.0))
            if any(self._moves(at, place) for at in others):
                counted.append(place)
            elif len(wanted.choices) != 1:
                self.left_out[wanted.written] = "its range moves nothing"
        self._counted, self.ranges = counted, [self.ranges[place] for place in counted]

    def _moves(self, others: AnyArray, place: int) -> bool:
        ends = np.array([others, others])
        ends[:, place] = -1.0, 1.0
        return self._values(ends[0]) != self._values(ends[1])


def _farthest(matrix: AnyArray, slopes: AnyArray) -> float:
    """Return the most that correlated deviates reach: slopes y, as y' R y <= m and |R y| <= 1 with z = 3 R y."""
    size = float(np.max(np.abs(slopes)))
    if size == 0.0:
        return 0.0
    bounds = [
        {"type": "ineq", "fun": lambda y: len(y) - y @ matrix @ y, "jac": lambda y: -2.0 * matrix @ y},
        {"type": "ineq", "fun": lambda y: 1.0 - matrix @ y, "jac": lambda _: -matrix},
        {"type": "ineq", "fun": lambda y: 1.0 + matrix @ y, "jac": lambda _: matrix},
    ]
    aim = slopes / size
    found = _minimise(lambda y: (-(aim @ y), -aim), 0.1 * aim, jac=True, method="SLSQP", constraints=bounds)
    return size * float(aim @ found.x)
