"""Influences on the measures of a study at each of its points and epochs, as values and as rows for other tools.

Without drift one epoch says everything; with drift, a measure depends on changes since the last
calibration. Points and intervals between calibrations are never mixed, unless there are too many
for separate tables.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from proofmass.graphs.studies.ages import some_of
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.draws.drawn_table import drawn_columns
from proofmass.runner.studies.draws.factors import CHANGE, Drawn, Factors
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.points import first_point, parts
from proofmass.runner.studies.shown.sensitivities import MOST_RUNS, Columns, Regression, regression, sobol_indices

MOST_TABLES = 500  # points x epochs x measures up to which every epoch is analysed


@dataclass(frozen=True)
class Influences:
    """Influences on one measure of some runs at one epoch."""

    measure: PlannedMeasure
    epoch: int
    since: AnyArray  # of each run the epoch of its last calibration
    factors: Factors
    values: AnyArray
    regression: Regression


def influences_at(result: StudyResult, drawn: Drawn, epoch: int) -> Iterator[Influences]:
    """Yield the influences on each measure that varies; `drawn` are parameters of first runs."""
    factors, since = drawn.factors(epoch), drawn.since(epoch)
    prepared = Columns(factors.columns)
    for measure in result.measures:
        values = result[measure.name][: len(drawn.runs), epoch]
        found = regression(factors.columns, values, prepared)
        if found is not None:
            yield Influences(measure, epoch, since, factors, values, found)


def drawn_of(result: StudyResult) -> Drawn:
    """Return the parameters of the first runs of a result."""
    return Drawn(result.study, result.numbers[:MOST_RUNS])


def epochs_looked_at(result: StudyResult) -> list[int]:
    """Return all epochs, or a dozen if there would be too many tables."""
    epochs = result.study.epochs
    many = len(epochs) * min(len(parts(result)), result.study.points) * len(result.measures) > MOST_TABLES
    shown = some_of(epochs) if many else frozenset(epochs)
    return [number for number, age in enumerate(epochs) if age in shown]


class StudyInfluences:
    """The influences at each point and epoch of a study, computed once for tables and report."""

    def __init__(self, result: StudyResult) -> None:
        self.result = result
        self._epochs = epochs_looked_at(result)
        self._found = dict[int, list[Influences]]()

    def of(self, part: StudyResult) -> list[Influences]:
        """Return the influences of one point, epoch by epoch."""
        point = first_point(part)
        if point not in self._found:
            drawn = drawn_of(part)
            self._found[point] = [found for epoch in self._epochs for found in influences_at(part, drawn, epoch)]
        return self._found[point]

    def by_measure(self, part: StudyResult) -> dict[str, list[Influences]]:
        """Return the influences of one point on each measure that varies, epoch by epoch."""
        measures = dict[str, list[Influences]]()
        for influences in self.of(part) if len(part.numbers) else ():
            measures.setdefault(influences.measure.name, []).append(influences)
        return measures

    def rows(self) -> list[dict[str, Any]]:
        """Return a row for each point, epoch, measure and factor, with the effect of one standard deviation."""
        return [row for part in parts(self.result).values() if len(part.numbers) for row in _rows(part, self.of(part))]


def index_rows(result: StudyResult) -> list[dict[str, Any]]:
    """Return a row for each point, epoch, measure and parameter with its Sobol indices, for Saltelli's design."""
    study = result.study
    if study.design != "saltelli" or not len(result.numbers):
        return []
    rows = []
    for part in parts(result).values():
        for epoch in epochs_looked_at(result):
            for measure in result.measures:
                for index in sobol_indices(part, measure.name, epoch, first_point(part)):
                    first, total = index.first_interval, index.total_interval
                    rows.append(
                        place_of(part, measure.name, epoch)
                        | {"unit": measure.unit, "parameter": study.name_of(index.parameter)}
                        | {"first_order": index.first, "first_order_low": first[0], "first_order_high": first[1]}
                        | {"total": index.total, "total_low": total[0], "total_high": total[1]}
                    )
    return rows


def _rows(part: StudyResult, found: Sequence[Influences]) -> Iterator[dict[str, Any]]:
    for influences in found:
        effects, since = influences.regression, one_age(part.study.epochs, influences.since)
        place = place_of(part, influences.measure.name, influences.epoch)
        for influence in effects.influences:
            first = influence.parameters[0]
            yield (
                place
                | {"unit": influences.measure.unit, "since_s": since, "factor": influence.parameter}
                | {"change": all(name.startswith(CHANGE) for name in influence.parameters)}
                | {"factor_unit": influences.factors.units[first], "slope": influence.slope}
                | {"effect": influence.effect, "effect_half": influence.effect_half, "share": influence.share}
                | {"standardised": influence.standardised, "of_ranks": influence.rank}
                | {
                    "explained": effects.explained,
                    "explained_of_ranks": effects.explained_of_ranks,
                    "runs": effects.runs,
                }
            )


def place_of(part: StudyResult, name: str, epoch: int) -> dict[str, Any]:
    """Return the point of a part of a study, a measure or limit, and an epoch, as the first columns of a row."""
    study = part.study
    return point_columns(part) | {"measure": name, "epoch": epoch, "age_s": study.epochs[epoch]}


def point_columns(part: StudyResult) -> dict[str, Any]:
    """Return the point of a part of a study: swept values, and the time between calibrations."""
    study, point = part.study, first_point(part)
    told_apart = len(part.numbers) and (part.numbers % study.points == point).all()
    swept = study.point(point) if told_apart else {}
    every = {"recalibration_s": study.recalibrated_every(point) if told_apart else math.nan}
    names = {column.parameter: column.name for column in drawn_columns(study)}
    named = {names[name]: value for name, value in swept.items()}
    return named | (every if study.recalibration.carried else {})


def one_age(ages: Sequence[float], since: AnyArray) -> float:
    """Return the age at the epoch `since` of each run if it is the same for all, else NaN."""
    found = {ages[epoch] for epoch in since.tolist()}
    return found.pop() if len(found) == 1 else math.nan
