"""Goals at a point of the search: slacks of hard goals, objectives, and their gradients.

A slack is the distance into the allowed side, relative to the limit; it is negative where a hard
goal is missed. An objective is how far a value v that is to be small has come from its size s, or
how far a soft limit is missed. Both have gradients by the parts of the way of each free parameter
from its lower to its upper bound.

    objective = asinh(v / (2 e s)) - asinh(1 / (2 e)), e = 1e-3

This is log(v / s) while v is more than a few e s, and falls with v through zero to any negative value.
"""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from proofmass.graphs.tuning.tuning import Goal, Tuning
from proofmass.runner.design.quantities.evaluator import STABLE, Evaluator, QuantityReadings, Reasons
from proofmass.runner.design.quantities.loop_figures import Reading
from proofmass.runner.host.arrays import Array

MET = 1e-9  # slack of a goal that rounding may hide
LARGEST_SLACK = 2.0  # a margin without limit counts as this
UNDEFINED = -4.0  # slack of everything where a loop is unstable
_SMALL = 2e-3  # 2 e: part of the size at which the objective turns from a logarithm to a straight line
_LARGEST_OBJECTIVE = 1e3  # what has no limit counts as this


class GoalRow(NamedTuple):
    """A slack or an objective: which goal it is of, in which case, and its gradient."""

    goal: str
    case: str
    value: float
    gradient: Array
    sign: float = 0.0  # of the limit that it is of: 1 of the least, -1 of the largest value
    room: float = math.inf  # between both limits of its goal


@dataclass(frozen=True)
class TriedPoint:
    """The goals at one point of the search."""

    parts: Array
    values: Mapping[str, float]  # of the free parameters
    readings: Mapping[str, QuantityReadings]  # by case
    slacks: tuple[GoalRow, ...]
    objectives: tuple[GoalRow, ...]
    growth: GoalRow | None  # of the least stable loop
    inside: bool  # the bounds
    why: Mapping[str, Reasons] = field(default_factory=dict)  # of readings that are None, by case

    @property
    def defined(self) -> bool:
        """True if every quantity has a value."""
        return all(reading is not None for readings in self.readings.values() for reading in readings.values())

    @property
    def violation(self) -> float:
        """Distance by which the worst hard goal is missed; negative if all are met."""
        if not self.defined:
            return -UNDEFINED + (max(self.growth.value, 0.0) if self.growth else 1.0)
        return max((-row.value for row in self.slacks), default=0.0)

    @property
    def objective(self) -> float:
        """The worst of the objectives."""
        return max((row.value for row in self.objectives), default=0.0) if self.defined else math.inf


class GoalsAt:
    """Evaluates the goals of a tuning."""

    def __init__(self, tuning: Tuning) -> None:
        self.tuning, self.names = tuning, list(tuning.free)
        widths = {name: free.at_most - free.at_least for name, free in tuning.free.items()}
        quantities = {name: goal.quantity for name, goal in tuning.goals.items()}
        self.evaluator = Evaluator(tuning.graph, quantities, tuning.at, widths, tuning.study)
        self._sizes = dict[str, float]()  # of quantities where they are first finite and not zero
        self.note: Callable[[TriedPoint], None] = lambda at: None

    def nominal(self) -> TriedPoint:
        """Return the goals at the parameters of the graph."""
        return self.at_values(self.tuning.nominal)

    def size(self, goal: str) -> float:
        """Return the size of a quantity: how far it is beyond a limit of zero is a part of that."""
        return self._sizes.get(goal, 1.0)

    def _measure_sizes(self, readings: Iterable[QuantityReadings]) -> None:
        for name in self.tuning.goals.keys() - self._sizes.keys():
            sound = (found for found in readings if None not in found.values())  # what grows with a loop has no size
            known = [abs(reading.value) for found in sound if (reading := found[name]) is not None]
            if sizes := [size for size in known if 0.0 < size < math.inf]:
                self._sizes[name] = max(sizes)

    def at(self, parts: Array, slopes: bool = True) -> TriedPoint:
        """Return the goals at parts of the way between the bounds."""
        inside = np.clip(parts, 0.0, 1.0)
        frees = self.tuning.free.items()
        values = {name: free.value(float(part)) for (name, free), part in zip(frees, inside, strict=True)}
        return self._at(values, np.asarray(inside), slopes)

    def at_values(self, values: Mapping[str, float]) -> TriedPoint:
        """Return the goals and their derivatives at values of the free parameters."""
        parts = np.array([free.part(values[name]) for name, free in self.tuning.free.items()])
        return self._at(values, parts, True)

    def _at(self, values: Mapping[str, float], parts: Array, slopes: bool) -> TriedPoint:
        readings, factors_of, why = {}, {}, {}
        for case, (points, factors, age) in self.tuning.aged_cases().items():
            numbers = {**values, **points}
            fixed = dict.fromkeys(points, 0.0)  # what is free elsewhere moves nothing here
            now = {**numbers, **self.tuning.adjustable.dependence.followed(numbers)}
            numbers |= {n: now.get(n, self.tuning.value(n)) * factor for n, factor in factors.items()}
            moves = dict(factors)
            if age is not None:
                numbers, drifts = self.tuning.aged(numbers, age)
                moves |= {name: factors.get(name, 1.0) * slope for name, slope in drifts.items()}
            readings[case], factors_of[case] = self.evaluator.readings(numbers, slopes), moves | fixed
            why[case] = self.evaluator.why
        self._measure_sizes(readings.values())
        slacks, objectives, growths = list[GoalRow](), list[GoalRow](), list[GoalRow]()
        for case, found in readings.items():
            slopes_of_parts = {name: self.tuning.free[name].slope(values[name]) for name in self.names}
            chain = np.array([slope * factors_of[case].get(name, 1.0) for name, slope in slopes_of_parts.items()])
            for name, reading in found.items():
                if reading is None:
                    continue
                gradient = np.array([reading.slopes.get(p, 0.0) for p in self.names]) * chain
                if name.startswith(STABLE):
                    growths.append(GoalRow(name, case, reading.value, gradient))
                else:
                    self._rows(
                        self.tuning.goals[name], GoalRow(name, case, reading.value, gradient), slacks, objectives
                    )
        worst = max(growths, key=lambda row: row.value, default=None)
        inside = all(free.at_least <= values[name] <= free.at_most for name, free in self.tuning.free.items())
        at = TriedPoint(parts, dict(values), readings, tuple(slacks), tuple(objectives), worst, inside, why)
        self.note(at)
        return at

    def _rows(self, goal: Goal, row: GoalRow, slacks: list[GoalRow], objectives: list[GoalRow]) -> None:
        for sign, limit in goal.limits:
            scale = abs(limit) or self.size(row.goal)
            room = (goal.at_most - goal.at_least) / scale
            slack = sign * (row.value - limit) / scale + (0.0 if room else MET)
            gradient = sign * row.gradient / scale
            if not slack < LARGEST_SLACK:
                slack, gradient = LARGEST_SLACK, np.zeros_like(gradient)
            slack = slack if math.isfinite(slack) else UNDEFINED
            moved = row._replace(value=slack, gradient=gradient, sign=sign, room=room)
            if goal.soft:
                objectives.append(moved._replace(value=-slack, gradient=-gradient))
            else:
                slacks.append(moved)
        if goal.minimise or goal.maximise:
            objectives.append(self._objective(goal, row))

    def _objective(self, goal: Goal, row: GoalRow) -> GoalRow:
        sign, small = (1.0 if goal.minimise else -1.0), _SMALL * self.size(row.goal)
        value = sign * (math.asinh(row.value / small) - math.asinh(1.0 / _SMALL))
        if not abs(value) < _LARGEST_OBJECTIVE:
            return row._replace(value=math.copysign(_LARGEST_OBJECTIVE, value), gradient=np.zeros_like(row.gradient))
        return row._replace(value=value, gradient=sign * row.gradient / math.hypot(row.value, small))


def worst_reading(at: TriedPoint, name: str, goal: Goal) -> tuple[str, Reading | None]:
    """Return the case in which a goal is missed by most, or has no value, and its reading there."""
    by_case = {case: readings[name] for case, readings in at.readings.items()}
    case = max(by_case, key=lambda case: math.inf if (of := by_case[case]) is None else goal.shortfall(of.value))
    return case, by_case[case]
