"""Two studies compared, point by point and age by age: which means and yields moved by more than
their sensors scatter.

The unit that is independent is the sensor: it is at every point of a sweep and at every age, so
that runs of several points are no larger a sample. A group of Saltelli's design counts as one
sensor, with the mean of its runs. Where both studies drew the same sensors (equal seed, design and spread
parameters), each sensor is compared with itself; otherwise two independent samples are. The
probabilities of all comparisons are those of Holm (Scandinavian Journal of Statistics 6 (1979) 65):
the chance of even one false "moved" is at most five per cent.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from proofmass.graphs.model.differences import GraphDifference, changed_entries, differences
from proofmass.graphs.studies.study import Study
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.intervals import LEVEL, Bounds, mean_interval
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.points import by_point, point_text, same_sensors

ALL = "all limits"


@dataclass(frozen=True)
class MeanChange:
    """The mean of a measure at a point and age before and after, their difference, its interval."""

    point: str  # in words; "" where there is one
    measure: str
    unit: str
    age: float
    runs: tuple[int, int]
    before: float
    after: float
    difference: float
    interval: Bounds
    pairing: float  # how many times wider the interval of independent samples is; 1 where they are
    probability: float  # of a difference as large by chance, among all that are compared
    moved: bool = False


@dataclass(frozen=True)
class YieldChange:
    """The part of good sensors at a point before and after, or of those whose measure has a value."""

    point: str  # in words; "" where there is one
    limit: str
    age: float | None  # None: at all ages
    before: float
    after: float
    probability: float
    moved: bool = False


@dataclass(frozen=True)
class StudyComparison:
    """Two studies: differences of what was asked, of means and of yields."""

    differences: tuple[GraphDifference, ...]
    paired: bool
    means: tuple[MeanChange, ...]
    yields: tuple[YieldChange, ...]
    units: tuple[GraphDifference, ...] = ()  # of measures whose values are not compared
    alone: tuple[str, ...] = ()  # measures that differ, of too few sensors to tell what moved

    @property
    def same(self) -> bool:
        """Return whether nothing moved, and no measure is in another unit, or of one sensor alone and another value."""
        return not (
            self.units
            or self.alone
            or any(mean.moved for mean in self.means)
            or any(part.moved for part in self.yields)
        )

    def as_data(self) -> dict[str, Any]:
        """Return the comparison as plain data."""
        return {
            "same": self.same,
            "paired": self.paired,
            "differences": [difference.as_data() for difference in self.differences],
            "means": [_finite(asdict(change)) for change in self.means],
            "yields": [asdict(change) for change in self.yields],
            "alone": list(self.alone),
        }


def compare_studies(before: StudyResult, after: StudyResult) -> StudyComparison:
    """Compare two studies, ended or under way."""
    changes = [*differences(before.study.graph, after.study.graph), *study_differences(before.study, after.study)]
    units = tuple(changed_entries("unit of ", *({m.name: m.unit for m in each.measures} for each in (before, after))))
    units = tuple(unit for unit in units if unit.before and unit.after)
    paired = _same_sensors(before.study, after.study)
    means, yields, alone = list[MeanChange](), list[YieldChange](), list[str]()
    for point, first, second in _points(before, after):
        if paired:
            first, second = same_sensors(first, second)
        for name, unit, age, values in _columns(first, second, paired=paired):
            if min(map(len, values)) > 1:
                means.append(_mean_change((point, name, unit, age), *values, paired=paired))
            elif min(map(len, values)) == 1 and not np.array_equal(values[0], values[1]):
                alone.append(" ".join(filter(None, (name, point))))
        yields += _yields(point, first, second, paired=paired)
        yields += _with_values(point, first, second, paired=paired)
    adjusted = iter(_holm([*(mean.probability for mean in means), *(part.probability for part in yields)]))
    return StudyComparison(
        (*changes, *units),
        paired,
        tuple(replace(mean, probability=(p := next(adjusted)), moved=p < 1.0 - LEVEL) for mean in means),
        tuple(replace(part, probability=(p := next(adjusted)), moved=p < 1.0 - LEVEL) for part in yields),
        units,
        tuple(dict.fromkeys(alone)),
    )


def study_differences(before: Study, after: Study) -> Iterator[GraphDifference]:
    """Return what two studies ask otherwise."""
    return changed_entries("study.", _asked(before), _asked(after))


def _asked(study: Study) -> dict[str, str]:
    lines = dict(line.split(" = ", 1) for line in study.text().splitlines())
    lines |= {"runs": str(study.runs)} | {f"limits.{n}": str(limit) for n, limit in study.limits.items()}
    return lines | {f"stop.{name}": repr(half) for name, half in study.stop.items()}


def _same_sensors(before: Study, after: Study) -> bool:
    """Return whether run k of one study is the sensor of run k of the other."""
    if "latin_hypercube" in (before.design, after.design) and before.runs != after.runs:
        return False
    drawn = [(study.seed, study.design, sorted(study.spread)) for study in (before, after)]
    return drawn[0] == drawn[1]


def _points(before: StudyResult, after: StudyResult) -> list[tuple[str, StudyResult, StudyResult]]:
    """Return the points that both studies have; without any, the points in their order, or all against a single one."""
    parts = [by_point(result) for result in (before, after)]
    keys = [[_key(result.study, point) for point in range(result.study.points)] for result in (before, after)]
    pairs = [(first, keys[1].index(key)) for first, key in enumerate(keys[0]) if key in keys[1]]
    if not pairs:
        most = min if min(map(len, keys)) > 1 else max
        pairs = [(min(n, len(keys[0]) - 1), min(n, len(keys[1]) - 1)) for n in range(most(map(len, keys)))]
    several = len(keys[1]) > 1
    study = after.study if several else before.study
    return [
        (point_text(study, second if several else first), parts[0][first], parts[1][second]) for first, second in pairs
    ]


def _key(study: Study, point: int) -> tuple[Any, ...]:
    return (*sorted(study.point(point).items()), study.recalibrated_every(point))


def _columns(
    before: StudyResult, after: StudyResult, *, paired: bool
) -> Iterator[tuple[str, str, float, list[AnyArray]]]:
    """Yield each measure at each age that both studies have, with its unit and its values of both."""
    units, units_after = ({measure.name: measure.unit for measure in part.measures} for part in (before, after))
    ages = [age for age in before.study.epochs if age in after.study.epochs]
    for name in (name for name in before.values if units_after.get(name) == units[name]):
        for age in ages:
            values = [result[name][:, result.study.epochs.index(age)] for result in (before, after)]
            if paired:
                known = np.logical_and(*map(np.isfinite, values))
                values = [np.where(known, column, np.nan) for column in values]
            values = [result.of_draws(column) for result, column in zip((before, after), values, strict=True)]
            yield name, units[name], age, [column[np.isfinite(column)] for column in values]


def _mean_change(place: tuple[str, str, str, float], first: AnyArray, second: AnyArray, *, paired: bool) -> MeanChange:
    (interval, probability), gain = _independent(first, second), 1.0
    if paired:  # Student's test of differences
        width, apart = interval[1] - interval[0], second - first
        scatter = float(apart.var(ddof=1)) / len(apart)
        interval, probability = mean_interval(apart), _probability(float(apart.mean()), scatter, len(apart) - 1.0)
        gain = width / (interval[1] - interval[0]) if interval[1] > interval[0] else math.inf
    means = float(first.mean()), float(second.mean())
    difference = float((second - first).mean()) if paired else means[1] - means[0]
    return MeanChange(*place, (len(first), len(second)), *means, difference, interval, gain, probability)


def _independent(first: AnyArray, second: AnyArray) -> tuple[Bounds, float]:
    """Interval of the difference of two means and the probability of Welch's test."""
    # for start-up time: graphs and runs are compared without it
    from scipy.special import stdtrit

    difference = float(second.mean() - first.mean())
    squares = [float(column.var(ddof=1)) / len(column) for column in (first, second)]
    if not sum(squares):
        return (difference, difference), _probability(difference, 0.0, 1.0)
    pairs = zip(squares, (first, second), strict=True)
    freedom = sum(squares) ** 2 / sum(square**2 / (len(column) - 1.0) for square, column in pairs)
    half = float(stdtrit(freedom, 0.5 + 0.5 * LEVEL)) * math.sqrt(sum(squares))
    return (difference - half, difference + half), _probability(difference, sum(squares), freedom)


def _probability(difference: float, variance: float, freedom: float) -> float:
    """Probability that Student's deviate is as large as a difference; without scatter any difference is certain."""
    # for start-up time: graphs and runs are compared without it
    from scipy.special import stdtr

    if variance == 0.0:
        return float(difference == 0.0)
    return 2.0 * float(stdtr(freedom, -abs(difference) / math.sqrt(variance)))


def _yields(point: str, before: StudyResult, after: StudyResult, *, paired: bool) -> Iterator[YieldChange]:
    """Yield the changes of each limit at all ages together, and at each age that both have, if there are several."""
    shared = [name for name in before.study.limits if name in after.study.limits]
    ages = [age for age in before.study.epochs if age in after.study.epochs]
    for name in [*shared, *([ALL] if shared else [])]:
        if min(len(before.numbers), len(after.numbers)):
            for age in (None, *(ages if len(ages) > 1 else ())):
                one, other = (part.of_draws(_at(_within(part, name), part.study, age)) for part in (before, after))
                probability = _yield_probability(one, other, paired=paired)
                yield YieldChange(point, name, age, float(one.mean()), float(other.mean()), probability)


def _with_values(point: str, before: StudyResult, after: StudyResult, *, paired: bool) -> Iterator[YieldChange]:
    """Yield the changes of the part whose measure has a value, for measures and ages at which some have none."""
    for name in (name for name in before.values if name in after.values):
        for age in (age for age in before.study.epochs if age in after.study.epochs):
            one, other = (
                part.of_draws(np.isfinite(part[name][:, part.study.epochs.index(age)])) for part in (before, after)
            )
            if len(one) and len(other) and 0.0 < np.concatenate((one, other)).mean() < 1.0:
                probability = _yield_probability(one, other, paired=paired)
                yield YieldChange(
                    point, f"{name} has a value", age, float(one.mean()), float(other.mean()), probability
                )


def _within(result: StudyResult, name: str) -> AnyArray:
    """Return by run and epoch whether a limit is kept, or all of them."""
    names = result.study.limits if name == ALL else [name]
    return np.asarray(np.logical_and.reduce([result.within(limit) for limit in names]))


def _at(within: AnyArray, study: Study, age: float | None) -> AnyArray:
    return np.asarray(within.all(axis=1) if age is None else within[:, study.epochs.index(age)])


def _yield_probability(first: AnyArray, second: AnyArray, *, paired: bool) -> float:
    """McNemar's exact test of sensors that changed sides, or Fisher's of two samples.

    Of a group of Saltelli's design the part of its runs counts: which way it moved, or as so much of a sensor.
    """
    # for start-up time: graphs and runs are compared without it
    from scipy.stats import binomtest, fisher_exact

    if paired:
        lost, won = int((second < first).sum()), int((second > first).sum())
        return float(binomtest(won, lost + won).pvalue) if lost + won else 1.0
    good = [round(float(column.sum())) for column in (first, second)]
    table = [[sound, len(column) - sound] for sound, column in zip(good, (first, second), strict=True)]
    test: Any = fisher_exact(table)
    return float(test.pvalue)


def _holm(probabilities: Sequence[float]) -> list[float]:
    """Adjusted probabilities, in the order given.

    >>> _holm([0.01, 0.04, 0.03])
    [0.03, 0.06, 0.06]
    """
    adjusted, largest = [0.0] * len(probabilities), 0.0
    for rank, place in enumerate(sorted(range(len(probabilities)), key=lambda i: probabilities[i])):
        largest = max(largest, min(1.0, (len(probabilities) - rank) * probabilities[place]))
        adjusted[place] = largest
    return adjusted


def _finite(row: dict[str, Any]) -> dict[str, Any]:
    """A row for JSON, which has no infinity."""
    interval = [end if math.isfinite(end) else None for end in row["interval"]]
    return row | {"interval": interval, "pairing": row["pairing"] if math.isfinite(row["pairing"]) else None}
