"""The files of a study in its folder, and the study as plain data: `--json` and study.json."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from proofmass.runner.commands.run_files import usual_format
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.kept.ledger import FILE as LEDGER
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.export_answers import ENDINGS, save_answers
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.plot import save_study_plots
from proofmass.runner.studies.shown.points import by_point, differences, first_point
from proofmass.runner.studies.shown.report import FILE, save_study_report

_MOST_ROWS = 5000  # points x epochs x measures that are written point by point


def write_study(
    result: StudyResult, out: Path, formats: tuple[str, ...], report: bool, say: Callable[[str], None] = lambda _: None
) -> list[str]:
    """Write the tables of a study, pictures and report if asked for, and say each; return the names of the files."""
    tables = {"netcdf": save_study_netcdf, "csv": save_study_csv, "parquet": save_study_parquet}
    forms = tuple(dict.fromkeys((usual_format("xarray"), *formats)))
    influences = StudyInfluences(result)
    steps: list[tuple[str, Callable[[], list[str]]]] = [
        ("study.json", lambda: [write_whole(out / "study.json", json_text(study_data(result)) + "\n").name]),
        *((form, lambda form=form: [tables[form](result, out / f"study.{ENDINGS[form]}").name]) for form in forms),
    ]
    if report:
        steps += [
            ("influences", lambda: save_answers(influences, out, forms)),
            ("pictures", lambda: save_study_plots(result, out / "study", ("svg", "png"))),
            (FILE, lambda: [save_study_report(result, out / FILE, influences).name]),
        ]
    names = [LEDGER, STUDY_FILE]
    for number, (name, write) in enumerate(steps, 1):
        say(f"writing {name}, {number} of {len(steps)}")
        names += write()
    return names


def study_data(result: StudyResult) -> dict[str, Any]:
    """Return size, measures, yields, faults and provenance of a study, at sweep points too."""
    study, points = result.study, _points(result)
    return {
        "graph": study.graph.name,
        "runs": len(result.numbers),
        "planned_runs": result.planned_runs,
        "interrupted": result.interrupted,
        "seed": study.seed,
        "epochs_s": list(study.epochs),
        **_answers(result),
        **({"points": points} if points else {}),
        "faults": [{"run": run, "epoch": epoch, "message": text} for (run, epoch), text in result.faults.items()],
        **({"lost_workers": list(result.lost_workers)} if result.lost_workers else {}),
        "digest": result.digest,
        "seconds": result.seconds,
        **result.provenance,
    }


def _points(result: StudyResult) -> list[dict[str, Any]]:
    """The points of a sweep; empty for a study without one."""
    study = result.study
    if study.points < 2 or study.points * len(study.epochs) * len(result.measures) > _MOST_ROWS:
        return []
    done, rows = [part for part in by_point(result) if len(part.numbers)], []
    for part in done:
        point = first_point(part)
        row: dict[str, Any] = {"sweep": {study.name_of(n): v for n, v in study.point(point).items()}}
        if study.recalibration.carried:
            row["every_s"] = study.recalibrated_every(point)  # infinite without any
        row |= _answers(part)
        if part is not done[0] and (against := list(differences(done[0], part))):
            row["against_first"] = against  # sensor by sensor
        rows.append(row)
    return rows


def _answers(result: StudyResult) -> dict[str, Any]:
    return {"measures": result.summary(), "yield": result.yields(), "yield_intervals": result.yield_intervals()}
