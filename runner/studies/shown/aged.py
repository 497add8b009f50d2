"""Measures over the epochs of a study as pictures show them: values, and changes where these are limited."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.pictures import axis_label
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.result import StudyResult

LIMIT = "limit"


class Aged(NamedTuple):
    """A fan over the epochs: of the values of a measure, or of its change since the epoch from which a limit counts."""

    measure: PlannedMeasure
    label: str
    limits: tuple[float, ...]
    first: int = 0
    change: bool = False

    def values(self, result: StudyResult) -> AnyArray:
        """Return the values by run and epoch from the first on; changes in percent of what each sensor had there."""
        values = whole(result, self.measure.name)[:, self.first :]
        if not self.change:
            return values
        known = values[values[:, 0] != 0.0]
        return np.asarray(100.0 * (known - known[:, :1]) / np.abs(known[:, :1]))


def aged(result: StudyResult, measure: PlannedMeasure) -> list[Aged]:
    """Return the fans of a measure: that of its values, and that of its change where this is limited."""
    limit = result.study.limits.get(measure.name, Limit())
    fans = [Aged(measure, label_of(measure), (limit.at_least, limit.at_most))]
    if math.isfinite(limit.change):
        first, percent = limit.counted(result.study.epochs), 100.0 * limit.change
        since = f" since {age_text(result.study.epochs[first])}" if first else ""
        fans.append(Aged(measure, f"change of {measure.name}{since} [%]", (-percent, percent), first, change=True))
    return fans


def whole(result: StudyResult, name: str) -> AnyArray:
    """Return the values of a measure of the runs that have it at every epoch."""
    return result[name][np.isfinite(result[name]).all(axis=1)]


def label_of(measure: PlannedMeasure) -> str:
    """Name and unit of a measure for an axis."""
    return axis_label(measure.name, measure.unit)


def near(limits: Sequence[float], values: AnyArray) -> list[float]:
    """Return the limits that lie near the values; others would only squeeze the picture."""
    known = values[np.isfinite(values)]
    if not known.size:
        return []
    low, high, span = known.min(), known.max(), np.ptp(known)
    return [limit for limit in limits if math.isfinite(limit) and low - span <= limit <= high + span]
