"""Two studies compared: which means and yields moved by more than their sensors scatter.

Where both studies drew the same sensors (equal seed, design and spread parameters), each sensor is compared with
itself; otherwise two independent samples are. The probabilities of all comparisons are those of Holm (Scandinavian
Journal of Statistics 6 (1979) 65): the chance of even one false "moved" is at most five per cent.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.libraries import need
from proofmass.graphs.model.differences import Difference, differences
from proofmass.graphs.studies.study import Study
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.intervals import LEVEL, Interval, mean_interval
from proofmass.runner.studies.outcome.result import StudyResult

ALL = "all limits"


@dataclass(frozen=True)
class MeanChange:
    """The mean of a measure at an age before and after, their difference with its interval."""

    measure: str
    unit: str
    age: float
    runs: tuple[int, int]
    before: float
    after: float
    difference: float
    interval: Interval
    probability: float  # of a difference as large by chance, among all that are compared
    moved: bool = False


@dataclass(frozen=True)
class YieldChange:
    """The part of good sensors before and after."""

    limit: str
    before: float
    after: float
    probability: float
    moved: bool = False


@dataclass(frozen=True)
class StudyComparison:
    """Two studies: differences of what was asked, of means and of yields."""

    differences: tuple[Difference, ...]
    paired: bool
    means: tuple[MeanChange, ...]
    yields: tuple[YieldChange, ...]

    @property
    def same(self) -> bool:
        """Return whether nothing moved."""
        return not any(mean.moved for mean in self.means) and not any(part.moved for part in self.yields)

    def as_data(self) -> dict[str, Any]:
        """Return the comparison as plain data."""
        return {
            "same": self.same,
            "paired": self.paired,
            "differences": [difference.as_data() for difference in self.differences],
            "means": [_finite(asdict(change)) for change in self.means],
            "yields": [asdict(change) for change in self.yields],
        }


def compare_studies(before: StudyResult, after: StudyResult) -> StudyComparison:
    """Compare two studies, ended or under way."""
    changes = [*differences(before.study.graph, after.study.graph), *study_differences(before.study, after.study)]
    paired = _same_sensors(before.study, after.study)
    places: tuple[Any, Any] = (slice(None), slice(None))
    if paired:
        _, *places = np.intersect1d(before.numbers, after.numbers, assume_unique=True, return_indices=True)  # type: ignore[assignment]
    means = list(_means(before, after, places, paired=paired))
    yields = list(_yields(before, after, places, paired=paired))
    adjusted = iter(_holm([*(mean.probability for mean in means), *(part.probability for part in yields)]))
    return StudyComparison(
        tuple(changes),
        paired,
        tuple(replace(mean, probability=(p := next(adjusted)), moved=p < 1.0 - LEVEL) for mean in means),
        tuple(replace(part, probability=(p := next(adjusted)), moved=p < 1.0 - LEVEL) for part in yields),
    )


def study_differences(before: Study, after: Study) -> Iterator[Difference]:
    """Yield what two studies ask otherwise."""
    first, second = (dict(line.split(" = ", 1) for line in study.text().splitlines()) for study in (before, after))
    first |= {"runs": str(before.runs), **_limits(before)}
    second |= {"runs": str(after.runs), **_limits(after)}
    for key in sorted({*first, *second}):
        if first.get(key) != second.get(key):
            yield Difference(f"study.{key}", first.get(key, ""), second.get(key, ""))


def _limits(study: Study) -> dict[str, str]:
    return {f"limits.{name}": str(limit) for name, limit in study.limits.items()}


def _same_sensors(before: Study, after: Study) -> bool:
    """Return whether run k of one study is the sensor of run k of the other."""
    if "latin_hypercube" in (before.design, after.design) and before.runs != after.runs:
        return False
    drawn = [(study.seed, study.design, sorted(study.spread), study.points) for study in (before, after)]
    return drawn[0] == drawn[1]


def _means(before: StudyResult, after: StudyResult, places: tuple[Any, Any], *, paired: bool) -> Iterator[MeanChange]:
    units = {measure.name: measure.unit for measure in before.measures}
    ages = [age for age in before.study.epochs if age in after.study.epochs]
    for name in (name for name in before.values if name in after.values):
        for age in ages:
            values = [
                result[name][place, result.study.epochs.index(age)]
                for result, place in zip((before, after), places, strict=True)
            ]
            if paired:
                sound = np.isfinite(values[0]) & np.isfinite(values[1])
                values = [column[sound] for column in values]
            else:
                values = [column[np.isfinite(column)] for column in values]
            if min(map(len, values)) > 1:
                yield _mean_change(name, units[name], age, *values, paired=paired)


def _mean_change(name: str, unit: str, age: float, first: Array, second: Array, *, paired: bool) -> MeanChange:
    if paired:
        interval, probability = mean_interval(second - first), _paired(second - first)
    else:
        interval, probability = _independent(first, second)
    means = float(first.mean()), float(second.mean())
    difference = float((second - first).mean()) if paired else means[1] - means[0]
    return MeanChange(name, unit, age, (len(first), len(second)), *means, difference, interval, probability)


def _paired(apart: Array) -> float:
    """Probability of Student's test of differences; certain where they are all the same."""
    need("scipy")
    # for start-up time: graphs and runs are compared without it
    from scipy.stats import ttest_1samp

    if np.ptp(apart) == 0.0:
        return 1.0 if apart[0] == 0.0 else 0.0
    test: Any = ttest_1samp(apart, 0.0)
    return float(test.pvalue)


def _independent(first: Array, second: Array) -> tuple[Interval, float]:
    """Interval of the difference of two means and the probability of Welch's test."""
    need("scipy")
    # for start-up time: graphs and runs are compared without it
    from scipy.stats import ttest_ind

    if np.ptp(first) == 0.0 and np.ptp(second) == 0.0:
        difference = float(second[0] - first[0])
        return (difference, difference), 1.0 if difference == 0.0 else 0.0
    test: Any = ttest_ind(second, first, equal_var=False)
    low, high = test.confidence_interval(LEVEL)
    return (float(low), float(high)), float(test.pvalue)


def _yields(before: StudyResult, after: StudyResult, places: tuple[Any, Any], *, paired: bool) -> Iterator[YieldChange]:
    shared = [name for name in before.study.limits if name in after.study.limits]
    for name in [*shared, *([ALL] if shared else [])]:
        kept = [_kept(result, name)[place] for result, place in zip((before, after), places, strict=True)]
        if min(map(len, kept)):
            one, other = kept
            probability = _yield_probability(one, other, paired=paired)
            yield YieldChange(name, float(one.mean()), float(other.mean()), probability)


def _kept(result: StudyResult, name: str) -> Array:
    good = result.good() if name == ALL else result.kept(name)
    assert good is not None
    return good


def _yield_probability(first: Array, second: Array, *, paired: bool) -> float:
    """McNemar's exact test of sensors that changed sides, or Fisher's of two samples."""
    need("scipy")
    # for start-up time: graphs and runs are compared without it
    from scipy.stats import binomtest, fisher_exact

    if paired:
        lost, won = int((first & ~second).sum()), int((second & ~first).sum())
        return float(binomtest(won, lost + won).pvalue) if lost + won else 1.0
    table = [[int(column.sum()), int((~column).sum())] for column in (first, second)]
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
    return row | {"interval": [end if math.isfinite(end) else None for end in row["interval"]]}
