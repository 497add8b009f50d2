"""The command `montecarlo`: run what is left of a study, show and write it; or replay a run."""

import time
from collections.abc import Mapping
from pathlib import Path

import click

from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import read_variants
from proofmass.runner.commands.answers import (
    DONE,
    print_answer,
    print_files,
    print_interruption,
    print_json,
    print_picture,
    print_problem,
    print_text,
)
from proofmass.runner.commands.declarations.graphs import MontecarloRequest
from proofmass.runner.commands.graph_options import changed
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import progress, working
from proofmass.runner.commands.run_files import need_for, usual_format, write_run
from proofmass.runner.commands.run_text import show_run
from proofmass.runner.commands.study_files import study_data, write_study
from proofmass.runner.comparison.tables import text_of
from proofmass.runner.comparison.variants import VariantComparison, folders_of
from proofmass.runner.output.times import time_text
from proofmass.runner.run.result import Result
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.runs.notes import notes_of_a_study
from proofmass.runner.studies.shown.plot import plot_study
from proofmass.runner.studies.shown.text import study_text
from proofmass.runner.studies.whole.study import replay, run_study, with_numbers


def run_montecarlo(request: MontecarloRequest) -> int:
    """Run a study, or replay one of its runs, and return the exit code."""
    studies = read_variants(request.study, own_blocks(request.own), lambda graph: changed(graph, request.changes))
    studies = {name: study for name, study in studies.items() if request.variant in (None, name)}
    if not studies:
        raise click.UsageError(f"--variant {request.variant}: the study has no such variant")
    need_for(request.formats if request.out is not None else ())
    if request.run is not None:
        if len(studies) > 1:
            raise click.UsageError(f"--run: name one of its variants: --variant {next(iter(studies))!r}")
        study = with_numbers(next(iter(studies.values())), request.runs, request.seed)
        if request.picture is not None:
            raise click.UsageError("--plot is of a study, --run repeats one sensor: --out FOLDER has its plot")
        return _show_replay(request.call(replay, study), request)
    if len(studies) == 1:
        return _run_one(request, next(iter(studies.values())), request.out)[0]
    return _run_variants(request, studies)


def _run_variants(request: MontecarloRequest, studies: Mapping[str, Study]) -> int:
    """Run each variant in a folder of its own, and compare them with the first."""
    results = dict[str, StudyResult]()
    folders = {} if request.out is None else folders_of(request.out, studies)
    for name, study in studies.items():
        if not request.as_json:
            print_text([f"variant {name}", ""])
        code, results[name] = _run_one(request, study, folders.get(name), alone=False)
        if code != DONE:
            return code
    comparison = VariantComparison(results)
    data = {"variants": {name: study_data(result) for name, result in results.items()}}
    data |= {"compared": comparison.as_data()}
    print_answer(request.as_json, lambda: data, ["", *text_of(comparison.tables())])
    if request.out is not None:
        print_files(request.out, comparison.save(request.out), request.as_json)
    return DONE


def _run_one(request: MontecarloRequest, study: Study, out: Path | None, alone: bool = True) -> tuple[int, StudyResult]:
    """Run one study, show it, write it to a folder; return the exit code and the result."""
    for note in notes_of_a_study(study):
        print_problem(note)
    with progress(request.quiet or request.as_json, "run") as bar:
        result = request.call(run_study, study, folder=out, progress=bar)
    if not request.as_json:
        print_text([study_text(result)])
    elif alone:
        print_json(study_data(result))
    if result.interrupted:
        return _interrupted(result, out), result
    print_picture(lambda: plot_study(result), request.picture if alone else None, request.as_json)
    if out is not None:
        began = time.perf_counter()
        with working(request.quiet or request.as_json, "writing") as say:
            names = write_study(result, out, request.formats, request.report, say)
        print_files(out, names, request.as_json)
        if not request.as_json:
            what = "tables, pictures and report" if request.report else "tables"
            print_text([f"{what}: {time_text(time.perf_counter() - began)}"])
    return DONE, result


def _show_replay(result: Result, request: MontecarloRequest) -> int:
    show_run(result, request.as_json)
    if request.out is not None:
        request.out.mkdir(parents=True, exist_ok=True)
        print_files(request.out, write_run(result, request.out, (usual_format(), *request.formats)), request.as_json)
    return DONE


def _interrupted(result: StudyResult, out: Path | None) -> int:
    done = f"{len(result.numbers):,} of {result.planned_runs:,} runs"
    cure = "the same command goes on from there" if out is not None else "with --out FOLDER a study can be resumed"
    return print_interruption(done, out, cure)
