"""The points of a study: values of its sweep and intervals between calibrations, each seen alone."""

from dataclasses import replace

from proofmass.graphs.studies.ages import recalibration_text
from proofmass.graphs.studies.study import Study
from proofmass.runner.output.plot import pretty
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.result import StudyResult

MOST_POINTS = 12  # that tables and pictures tell apart


def by_point(result: StudyResult) -> list[StudyResult]:
    """The same study at each of its points alone, in the order in which runs take turns at them."""
    points = result.study.points
    return [_some(result, result.numbers % points == point, points) for point in range(points)]


def parts(result: StudyResult) -> dict[str, StudyResult]:
    """The study at each point that has runs, by its name; as one, without a name, where they are too many."""
    found = by_point(result) if result.study.points <= MOST_POINTS else []
    named = {point_text(result.study, point): part for point, part in enumerate(found) if len(part.numbers)}
    return named or {"": result}


def swept_parts(result: StudyResult) -> dict[str, StudyResult]:
    """As `parts`, with all intervals between calibrations at each point of the sweep: they are there to be compared."""
    study, intervals = result.study, len(result.study.recalibration.every)
    swept = study.points // intervals
    if swept > MOST_POINTS:
        return {"": result}
    names = (_swept_text(study, number * intervals) for number in range(swept))
    numbers = result.numbers % study.points // intervals
    return {name: _some(result, numbers == number, swept) for number, name in enumerate(names)}


def first_point(result: StudyResult) -> int:
    """Number of the point of the first run."""
    return int(result.numbers[0]) % result.study.points if len(result.numbers) else 0


def point_text(study: Study, point: int) -> str:
    """What a point is: values of the swept parameters, and how often sensors are calibrated; "" for a study of one."""
    calibrated = recalibration_text(study.recalibrated_every(point)) if study.recalibration.carried else ""
    return ", ".join(filter(None, (_swept_text(study, point), calibrated)))


def _swept_text(study: Study, point: int) -> str:
    swept = study.point(point) if study.points > len(study.recalibration.every) else {}
    return ", ".join(
        f"{study.name_of(name)} = {value:g} {_unit(study, name)}".rstrip() for name, value in swept.items()
    )


def all_points_text(study: Study) -> str:
    """What is said where points are not told apart."""
    return f"all {study.points:,} points of the sweep together; study.nc has each of them"


def _unit(study: Study, parameter: str) -> str:
    unit = pretty(study.unit_of(parameter))
    return "" if unit == "1" else unit


def _some(result: StudyResult, chosen: Array, parts: int) -> StudyResult:
    """Runs of one of several parts of a study."""
    numbers = result.numbers[chosen]
    chosen_numbers = set(numbers.tolist())
    return replace(
        result,
        numbers=numbers,
        values={name: values[chosen] for name, values in result.values.items()},
        faults={key: fault for key, fault in result.faults.items() if key[0] in chosen_numbers},
        planned_runs=result.planned_runs // parts,
    )
