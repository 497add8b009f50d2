"""The runs of a study that are worth looking at again: those that failed, and those furthest beyond a limit."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.result import StudyResult

BEYOND = "beyond its limit"


@dataclass(frozen=True)
class WorstRun:
    """A run at an epoch, and why it is named."""

    run: int
    epoch: int
    value: float  # of the measure; NaN where the run failed
    why: str


def failed_runs(result: StudyResult, most: int) -> list[WorstRun]:
    """Return the first runs that failed."""
    return [WorstRun(run, epoch, math.nan, text) for (run, epoch), text in list(result.faults.items())[:most]]


def worst_runs(result: StudyResult, measure: str, most: int) -> list[WorstRun]:
    """Return runs, each once, by distance beyond the limits of a measure, or from its median if it has no limit."""
    values = result[measure]
    if not np.isfinite(values).any():
        return []
    limit = result.study.limits.get(measure)
    distances = _from_median(values) if limit is None else _beyond(values, limit, result.study.epochs)
    distances = np.where(np.isfinite(values), distances, -np.inf)
    epochs = distances.argmax(axis=1)
    farthest = distances[np.arange(len(epochs)), epochs]
    order = [row for row in np.argsort(-farthest, kind="stable")[:most] if np.isfinite(farthest[row])]
    return [_named(result, measure, int(row), int(epochs[row]), float(farthest[row]), limit) for row in order]


def _named(result: StudyResult, measure: str, row: int, epoch: int, distance: float, limit: Limit | None) -> WorstRun:
    where = "from the median" if limit is None else BEYOND if distance > 0.0 else "within its limit"
    return WorstRun(int(result.numbers[row]), epoch, float(result[measure][row, epoch]), f"{abs(distance):.4g} {where}")


def _from_median(values: AnyArray) -> AnyArray:
    return np.asarray(np.abs(values - np.nanmedian(values, axis=0)))


def _beyond(values: AnyArray, limit: Limit, ages: Sequence[float]) -> AnyArray:
    """Return the distance of each value beyond the nearest limit; negative inside, NaN at epochs that do not count."""
    counted = limit.counted(ages)
    beyond = np.maximum(limit.at_least - values, values - limit.at_most)
    if math.isfinite(limit.change):
        first = values[:, counted : counted + 1]
        beyond = np.maximum(beyond, np.abs(values - first) - limit.change * np.abs(first))
    return np.where(np.arange(len(ages)) < counted, np.nan, beyond)
