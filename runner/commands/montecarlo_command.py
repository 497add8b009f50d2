"""The command `montecarlo`: run what is left of a study, show and write it; or replay one of its runs."""

import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from proofmass.blocks.declaration.libraries import need
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.commands.answers import print_files, print_interruption, print_json, print_text
from proofmass.runner.commands.exit_codes import DONE
from proofmass.runner.commands.graph_options import changed
from proofmass.runner.commands.own_blocks import own_blocks
from proofmass.runner.commands.progress import progress, working
from proofmass.runner.commands.run_files import write_run
from proofmass.runner.commands.run_text import show_run
from proofmass.runner.commands.study_data import study_data
from proofmass.runner.commands.study_files import write_study
from proofmass.runner.commands.texts.study import study_text
from proofmass.runner.commands.texts.times import time_text
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.result import Result
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import replay, run_study, with_numbers


@dataclass(frozen=True)
class StudyRequest:
    """A call of `proofmass montecarlo`."""

    study: Path
    runs: int | None
    seed: int | None
    engine: EngineName
    changes: tuple[str, ...]
    out: Path | None
    threads: int | None
    lanes: int | None
    dask: str | None
    formats: tuple[str, ...]
    report: bool
    run: int | None
    epoch: int
    quiet: bool
    own: Path | None
    as_json: bool

    def __post_init__(self) -> None:
        if self.dask is not None and self.threads is not None:
            raise click.UsageError("give --threads or --dask, not both: Dask's workers have threads of their own")


def run_montecarlo(request: StudyRequest) -> int:
    """Run a study, or replay one of its runs, and return the exit code."""
    study = read_study(request.study, own_blocks(request.own), lambda graph: changed(graph, request.changes))
    need("scipy", *(_for_files(request) if request.out is not None else ()))
    if request.run is not None:
        study = with_numbers(study, request.runs, request.seed)
        return _show_replay(replay(study, request.run, request.epoch, request.engine), request)
    with progress(request.quiet or request.as_json, "run") as bar:
        result = run_study(
            study,
            runs=request.runs,
            seed=request.seed,
            engine=request.engine,
            lanes=request.lanes,
            threads=request.threads,
            dask=request.dask,
            folder=request.out,
            progress=bar,
        )
    if request.as_json:
        print_json(study_data(result))
    else:
        print_text([study_text(result)])
    if result.interrupted:
        return _interrupted(result, request.out)
    if request.out is not None:
        began = time.perf_counter()
        with working(request.quiet or request.as_json, "writing tables, pictures and report"):
            names = write_study(result, request.out, request.formats, request.report)
        print_files(request.out, names, request.as_json)
        if not request.as_json:
            what = "tables, pictures and report" if request.report else "tables"
            print_text([f"{what}: {time_text(time.perf_counter() - began)}"])
    return DONE


def _for_files(request: StudyRequest) -> Iterator[str]:
    """Libraries that the files of a study take."""
    yield from ("h5netcdf", "xarray")
    if request.report:
        yield "matplotlib"
    if "parquet" in request.formats:
        yield "pyarrow"


def _show_replay(result: Result, request: StudyRequest) -> int:
    show_run(result, request.as_json)
    if request.out is not None:
        request.out.mkdir(parents=True, exist_ok=True)
        print_files(request.out, write_run(result, request.out, ("netcdf", *request.formats)), request.as_json)
    return DONE


def _interrupted(result: StudyResult, out: Path | None) -> int:
    done = f"{len(result.numbers):,} of {result.planned_runs:,} runs"
    cure = "the same command goes on from there" if out is not None else "with --out FOLDER a study can be resumed"
    return print_interruption(done, out, cure)
