"""The files of a study in its folder."""

from collections.abc import Callable
from pathlib import Path

from proofmass.runner.commands.run_files import usual_format
from proofmass.runner.commands.study_data import study_data
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.kept.ledger import FILE as LEDGER
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.export_answers import ENDINGS, save_answers
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.plot import save_study_plots
from proofmass.runner.studies.shown.report import FILE, save_study_report


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
