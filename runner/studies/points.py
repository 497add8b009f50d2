"""The points of a study: values of its sweep and intervals between calibrations, each seen alone."""

from dataclasses import replace

from proofmass.graphs.study import Study
from proofmass.runner.output.plot import pretty
from proofmass.runner.studies.ages import recalibration_text
from proofmass.runner.studies.result import StudyResult

MOST_POINTS = 12  # that tables and pictures tell apart


def by_point(result: StudyResult) -> list[StudyResult]:
    """The same study at each of its points alone, in the order in which runs take turns at them."""
    return [_at(result, point) for point in range(result.study.points)]


def parts(result: StudyResult) -> dict[str, StudyResult]:
    """The study at each point by its name; all points together, without one, where they are too many to look at."""
    if result.study.points > MOST_POINTS:
        return {"": result}
    return {point_text(result.study, point): part for point, part in enumerate(by_point(result))}


def point_text(study: Study, point: int) -> str:
    """What a point is: values of the swept parameters, and how often sensors are calibrated; "" for a study of one."""
    swept = study.point(point) if study.points > len(study.recalibration.every) else {}
    words = [f"{name} = {value:g} {_unit(study, name)}".rstrip() for name, value in swept.items()]
    carried = study.recalibration.carried
    return ", ".join([*words, *([recalibration_text(study.recalibrated_every(point))] if carried else [])])


def all_points_text(study: Study) -> str:
    """What is said where points are not told apart."""
    return f"all {study.points:,} points of the sweep together; study.nc has each of them"


def _unit(study: Study, parameter: str) -> str:
    unit = pretty(study.unit_of(parameter))
    return "" if unit == "1" else unit


def _at(result: StudyResult, point: int) -> StudyResult:
    points = result.study.points
    chosen = result.numbers % points == point
    return replace(
        result,
        numbers=result.numbers[chosen],
        values={name: values[chosen] for name, values in result.values.items()},
        faults={key: fault for key, fault in result.faults.items() if key[0] % points == point},
        planned_runs=result.planned_runs // points,
    )
