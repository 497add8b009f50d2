"""The files of a study in its folder."""

from pathlib import Path

from proofmass.runner.commands.study_data import study_data
from proofmass.runner.output.export import whole_file
from proofmass.runner.output.json_text import json_text
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.kept.ledger import FILE as LEDGER
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.export_answers import save_answers
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.plot import save_study_plots
from proofmass.runner.studies.shown.report import FILE, save_study_report


def write_study(result: StudyResult, out: Path, formats: tuple[str, ...], report: bool) -> list[str]:
    """Write the tables of a study, its pictures and report if asked for; returns the names of the files."""
    with whole_file(out / "study.json") as file:
        file.write((json_text(study_data(result)) + "\n").encode())
    tables = {"csv": save_study_csv, "parquet": save_study_parquet}
    save_study_netcdf(result, out / "study.nc")
    more = [tables[form](result, out / f"study.{form}").name for form in formats]
    names = [LEDGER, STUDY_FILE, "study.json", "study.nc", *more]
    return [*names, *_write_report(result, out, formats)] if report else names


def _write_report(result: StudyResult, out: Path, formats: tuple[str, ...]) -> list[str]:
    """Influences of the parameters, lifetimes, pictures, and the report."""
    influences = StudyInfluences(result)
    return [
        *save_answers(influences, out, formats),
        *save_study_plots(result, out / "study", ("svg", "png")),
        save_study_report(result, out / FILE, influences).name,
    ]
