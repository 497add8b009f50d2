"""The folder of a study: its ledger and a copy of the study, to show and replay runs."""

import contextlib
import functools
from pathlib import Path

from proofmass.blocks.declaration.catalog import Own
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.changes import moved, recordings_of
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.graphs.studies.study_writer import files_beside, write_study
from proofmass.runner.output.export import whole_file
from proofmass.runner.run.provenance import graph_text, provenance
from proofmass.runner.studies.kept.ledger import FILE, Ledger
from proofmass.runner.studies.outcome.result import StudyResult, collected
from proofmass.runner.studies.outcome.running_means import RunningMeans
from proofmass.runner.studies.runs.notes import notes_of_a_study
from proofmass.runner.studies.runs.sensor_runs import SensorRuns

STUDY_FILE = "study.toml"


def keep_study(study: Study, folder: Path) -> None:
    """Write the study into its folder as one file that needs no others."""
    files = files_beside(study) | {STUDY_FILE: write_study(study, moved(study.graph, str(folder))).encode()}
    for name, content in files.items():
        with whole_file(folder / name) as file:
            file.write(content)


def last_result(path: Path, own: Own | None = None) -> tuple[Path, StudyResult]:
    """Return the folder in which a study file ran last, and its result by the limits and `stop` the file has now.

    It is beside the file, or in the working folder. Raises `ModelError` if there is none.
    """
    study = read_study(path, own)
    folder = _find_folder(study, path, own)
    return folder, kept_result(folder, own, study)


def _find_folder(study: Study, path: Path, own: Own | None) -> Path:
    ledgers = list[Path]()
    for ledger in {*path.parent.glob(f"*/{FILE}"), *Path().glob(f"*/{FILE}")}:
        with contextlib.suppress(ModelError):  # a folder of something else, or of other blocks
            kept = read_study(ledger.parent / STUDY_FILE, own)
            if _told(kept, str(ledger.parent)) == _told(
                study.changed(runs=kept.runs, seed=kept.seed), str(ledger.parent)
            ):
                ledgers.append(ledger)
    if not ledgers:
        hint = f"run it: proofmass montecarlo {path} --out FOLDER; or name the folder"
        raise Problem(message="no folder of this study is beside the file or here", file=str(path), hint=hint).error
    return max(ledgers, key=lambda ledger: ledger.stat().st_mtime).parent


def _told(study: Study, folder: str) -> tuple[str, str]:
    """Return the text of a study, its recordings named relative to a folder."""
    return study.text(), graph_text(moved(study.graph, folder))


def kept_result(folder: Path, own: Own | None = None, asked: Study | None = None) -> StudyResult:
    """Return the result of a study, ended or still running, from the ledger in its folder; nothing is run.

    `asked` is the same study with the limits and `stop` that count; without it those of the folder do.

    Raises `ModelError` if there is no study, or its ledger belongs to another.
    """
    for name in (FILE, STUDY_FILE):
        if not (folder / name).is_file():
            hint = f"create one: proofmass montecarlo STUDY.toml --out {folder}"
            raise Problem(message=f"holds no study: {name} is missing", file=str(folder), hint=hint).error
    study = read_study(folder / STUDY_FILE, own)
    study = study if asked is None else study.asked_as(asked)
    measures = SensorRuns(study, "python").measures
    names = (measure.name for measure in measures)
    facts = {"study": study.text()}
    if not recordings_of(study.graph):  # they have other names from here
        facts["graph"] = graph_text(study.graph)
    ledger = Ledger(folder / FILE, names, len(study.epochs), facts)
    try:
        means = RunningMeans(study, measures)
        means.add(ledger.outcomes(means.end))
        outcomes = collected(measures, ledger.outcomes(means.end))
    finally:
        ledger.close()
    return StudyResult(
        study=study,
        measures=measures,
        planned_runs=means.end,
        seconds=0.0,
        engine="",
        provenance=provenance(study.graph, ""),
        noted=functools.partial(notes_of_a_study, study),
        **outcomes,
    )
