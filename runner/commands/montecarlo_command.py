"""The command `montecarlo`: run what is left of a study, show and write it; or replay one of its runs."""

import re
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

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
from proofmass.runner.commands.study_data import study_data
from proofmass.runner.comparison.studies import StudyComparison, compare_studies
from proofmass.runner.comparison.tables import Table, save_tables, study_tables, text_of
from proofmass.runner.output.export import write_whole
from proofmass.runner.output.json_text import json_text
from proofmass.runner.output.times import time_text
from proofmass.runner.run.result import Result
from proofmass.runner.studies.kept.folder import STUDY_FILE
from proofmass.runner.studies.kept.ledger import FILE as LEDGER
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.curves import variant_pictures
from proofmass.runner.studies.shown.export import save_study_csv, save_study_netcdf, save_study_parquet
from proofmass.runner.studies.shown.export_answers import ENDINGS, save_answers
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.plot import plot_study, save_study_plots
from proofmass.runner.studies.shown.report import FILE, save_study_report
from proofmass.runner.studies.shown.text import study_text
from proofmass.runner.studies.whole.ready import study_notes
from proofmass.runner.studies.whole.study import replay, run_study, with_numbers

PAGE, DATA = "variants.html", "variants.json"  # of several variants


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
    for name, study in studies.items():
        out = None if request.out is None else folder_of(request.out, name)
        if not request.as_json:
            print_text([f"variant {name}", ""])
        code, results[name] = _run_one(request, study, out, alone=False)
        if code != DONE:
            return code
    comparisons = compared(results)
    data = {"variants": {name: study_data(result) for name, result in results.items()}}
    data |= {"compared": comparison_data(comparisons)}
    print_answer(request.as_json, lambda: data, ["", *text_of(comparison_tables(results, comparisons))])
    if request.out is not None:
        print_files(request.out, write_comparison(results, comparisons, request.out), request.as_json)
    return DONE


def _run_one(request: MontecarloRequest, study: Study, out: Path | None, alone: bool = True) -> tuple[int, StudyResult]:
    """Run one study, show it, write it to a folder; return the exit code and the result."""
    for note in study_notes(study):
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


def folder_of(out: Path, name: str) -> Path:
    """Return the folder of a variant.

    >>> folder_of(Path("out"), "cheap, adc.bits = 12").name
    'cheap_adc.bits_12'
    """
    return out / re.sub(r"[^A-Za-z0-9.+-]+", "_", name).strip("_")


def compared(results: Mapping[str, StudyResult]) -> dict[str, StudyComparison]:
    """Return the comparisons of the later variants with the first."""
    (_, first), *others = results.items()
    return {name: compare_studies(first, result) for name, result in others}


def comparison_tables(results: Mapping[str, StudyResult], comparisons: Mapping[str, StudyComparison]) -> list[Table]:
    """Return the means and yields of each variant beside the first, and what moved."""
    first = next(iter(results))
    tables = []
    for name, comparison in comparisons.items():
        for table in study_tables(comparison)[1:]:
            tables.append(Table(f"{name}, after {first}: {table.title}", table.heads, table.rows, table.left))
    return tables


def comparison_data(comparisons: Mapping[str, StudyComparison]) -> dict[str, Any]:
    """Return the comparisons as plain data."""
    return {name: comparison.as_data() for name, comparison in comparisons.items()}


def write_comparison(
    results: Mapping[str, StudyResult], comparisons: Mapping[str, StudyComparison], out: Path
) -> list[str]:
    """Write the comparison as a page and as data; returns the names of the files."""
    write_whole(out / DATA, json_text(comparison_data(comparisons), indent=1) + "\n")
    title = f"{next(iter(results.values())).study.graph.name}: variants"
    verdict = "Each variant has the same sensors as the first. Their own reports are in the folders beside this page."
    save_tables(out / PAGE, title, verdict, comparison_tables(results, comparisons), variant_pictures(results))
    return [DATA, PAGE]
