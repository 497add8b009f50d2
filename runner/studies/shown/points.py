"""The points of a study: values of its sweep and calibration intervals, each seen alone."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from proofmass.blocks.declaration.shown_units import in_table
from proofmass.graphs.studies.ages import recalibration_text
from proofmass.graphs.studies.study import Study
from proofmass.runner.studies.outcome.intervals import mean_interval
from proofmass.runner.studies.outcome.result import StudyResult

MOST_POINTS = 12  # with tables and pictures of their own


def by_point(result: StudyResult) -> list[StudyResult]:
    """Return the study at each of its points alone, in the order in which runs take turns."""
    points = result.study.points
    if points == 1:
        return [result]
    return [result.some(result.numbers % points == point, points) for point in range(points)]


def parts(result: StudyResult) -> dict[str, StudyResult]:
    """Return the study at each point that has runs, by name; as one, without a name, if there are too many."""
    found = by_point(result) if result.study.points <= MOST_POINTS else []
    named = {point_text(result.study, point): part for point, part in enumerate(found) if len(part.numbers)}
    return named or {"": result}


def differences(first: StudyResult, other: StudyResult) -> Iterator[dict[str, Any]]:
    """Yield how far the mean of each measure at each age is from that at another point, sensor by sensor.

    The same sensors are at both points: what they have in common falls out of the interval. A group
    of Saltelli's design counts once.
    """
    first, other = same_sensors(first, other)
    for measure in first.measures:
        differences = first.of_draws(other[measure.name] - first[measure.name])
        for epoch, age in enumerate(first.study.epochs):
            apart = differences[:, epoch]
            apart = apart[np.isfinite(apart)]
            if len(apart):
                row = {"measure": measure.name, "unit": measure.unit, "age_s": age, "sensors": len(apart)}
                yield row | {"difference": float(apart.mean()), "interval": mean_interval(apart)}


def same_sensors(first: StudyResult, other: StudyResult) -> tuple[StudyResult, StudyResult]:
    """Return the runs of two points whose sensors both have, sensor by sensor."""
    sensors = (part.numbers // part.study.points for part in (first, other))
    _, *places = np.intersect1d(*sensors, assume_unique=True, return_indices=True)  # type: ignore[call-overload]
    return first.some(places[0]), other.some(places[1])


def swept_parts(result: StudyResult) -> dict[str, StudyResult]:
    """Return `parts` with all intervals between calibrations together, to compare them."""
    study, intervals = result.study, len(result.study.recalibration.every)
    swept = study.points // intervals
    if swept == 1 or swept > MOST_POINTS:
        return {"": result}
    names = (_swept_text(study, number * intervals) for number in range(swept))
    numbers = result.numbers % study.points // intervals
    return {name: result.some(numbers == number, swept) for number, name in enumerate(names)}


def first_point(result: StudyResult) -> int:
    """Return the number of the first run's point."""
    return int(result.numbers[0]) % result.study.points if len(result.numbers) else 0


def point_text(study: Study, point: int) -> str:
    """Return the swept parameters and calibration interval of a point as text; "" for a study of one point."""
    calibrated = recalibration_text(study.recalibrated_every(point)) if study.recalibration.carried else ""
    return ", ".join(filter(None, (_swept_text(study, point), calibrated)))


def _swept_text(study: Study, point: int) -> str:
    swept = study.point(point) if study.points > len(study.recalibration.every) else {}
    return ", ".join(
        f"{study.name_of(name)} = {value:g} {in_table(study.unit_of(name))}".rstrip() for name, value in swept.items()
    )


def all_points_text(study: Study) -> str:
    """Return the text for points that have no tables of their own."""
    return f"all {study.points:,} points of the sweep together; study.nc has them one by one"
