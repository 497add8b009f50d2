"""Studies from the first to the last run: ledger, batches, progress, interruption."""

import contextlib
import dataclasses
import functools
import threading
import time
from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TypeVar

import numpy as np

from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.model.call_numbers import refuse_counts, whole
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_reader import only_study, read_variants
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.interrupts import StoppedError, interrupts
from proofmass.runner.host.processors import processors
from proofmass.runner.plan.measuring import Measured
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.engine_table import ENGINES, EngineName
from proofmass.runner.run.provenance import provenance
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunOptions, simulate_plan
from proofmass.runner.studies.kept.folder import keep_study
from proofmass.runner.studies.kept.ledger import FILE, Ledger
from proofmass.runner.studies.kept.ledger import repair as rewrite
from proofmass.runner.studies.outcome.outcomes import Outcomes
from proofmass.runner.studies.outcome.result import StudyResult, collected
from proofmass.runner.studies.outcome.running_means import RunningMeans
from proofmass.runner.studies.runs.facts import facts_of
from proofmass.runner.studies.runs.margins_per_run import margin_measures
from proofmass.runner.studies.runs.notes import notes_of_a_study
from proofmass.runner.studies.runs.sensor_runs import SensorRuns, noise_run

MOST_THREADS = 1024
BATCH_SECONDS = 0.2  # of runs that are written together
_Source = Callable[[AnyArray, RunningMeans, threading.Event], Generator[Outcomes, None, None]]
StudyProgress = Callable[[int, int, str], None]  # runs done, runs in all, the current means
AnyStudy = TypeVar("AnyStudy", bound=Study)


@named_arguments
def run_study(
    study: Study | str | Path,
    *,
    runs: int | None = None,
    seed: int | None = None,
    engine: EngineName = "auto",
    lanes: int | None = None,
    threads: int | None = None,
    dask: str | None = None,
    folder: str | Path | None = None,
    progress: StudyProgress | None = None,
    repair: bool = False,
) -> StudyResult:
    """Run a study, or the rest of it.

    `runs` and `seed` override those of the study. The compiled engine runs `lanes` sensors side by
    side (0 for none) in each of `threads`. Both have suitable defaults, and change no bit.
    With `dask`, workers of a Dask cluster compute instead of threads: give the address of a
    scheduler, or "local" or "local:4" for processes of this machine.

    With a `folder`, every run is written to a ledger there. After Ctrl-C, SIGTERM or a crash the
    same call continues to the same bits; more runs may be asked for later. Ctrl-C ends the study
    after the runs under way, and the result has the runs that are done. A damaged ledger is
    refused; `repair` keeps its whole runs, and runs the others again. A study with `stop` ends when
    its means are known well enough; `planned_runs` of the result says after how many.

    What `check` would say of it, and of blocks at a corner, is in the `notes` of the result.

    Raises `ModelError` if the study is wrong or has variants, or the ledger in the folder is
    damaged or belongs to another graph or study; `RunError` if the cluster fails.

    `study` is a `Study`, a file, or "library:NAME". `engine` is "auto", "python" or "compiled".
    `progress` is called with the runs that are done, all runs, and a text on the measures.

    >>> from proofmass import read_study, run_study
    >>> result = run_study(read_study("library:scale_factor_drift"), runs=4)
    >>> result["scale_factor"].shape  # four sensors at six ages
    (4, 6)
    """
    study = study if isinstance(study, Study) else only_study(read_variants(study))
    if threads is not None:
        refuse_counts(threads=(threads, 0, MOST_THREADS))
    sensors = SensorRuns(with_numbers(study, runs, seed), engine, lanes)
    return run_sensors(sensors, threads, dask, folder, progress, repair)


def run_sensors(
    sensors: SensorRuns,
    threads: int | None = None,
    dask: str | None = None,
    folder: str | Path | None = None,
    progress: StudyProgress | None = None,
    repair: bool = False,
) -> StudyResult:
    """Run the study of prepared sensors, as `run_study` does."""
    began, study = time.perf_counter(), sensors.study
    total = study.runs * study.points
    path = None
    if folder is not None:
        Path(folder).mkdir(parents=True, exist_ok=True)
        path = Path(folder) / FILE
    facts = facts_of(sensors) if path else {}
    names = [measure.name for measure in sensors.measures]
    if repair and path is not None and path.exists():
        rewrite(path, names, len(study.epochs), facts)
    ledger, lost = Ledger(path, names, len(study.epochs), facts), list[str]()
    try:
        if folder is not None:
            keep_study(study, Path(folder))
        kept, means = ledger.outcomes(total), RunningMeans(study, sensors.measures)
        means.add(kept)
        left = np.setdiff1d(np.arange(total), kept.numbers)
        if dask is None:
            source = functools.partial(_in_threads, sensors, threads or processors())
        else:
            # start-up time: only --dask needs workers
            from proofmass.runner.studies.workers.chunks import runs_on_workers

            source = functools.partial(runs_on_workers, dask, sensors, lost)
        _fill(ledger, source, left, means, progress)
        outcomes = collected(sensors.measures, ledger.outcomes(means.end))
    finally:
        ledger.close()
    return StudyResult(
        study=study,
        measures=sensors.measures,
        planned_runs=means.end,
        seconds=time.perf_counter() - began,
        engine=sensors.engine,
        provenance=provenance(study.graph, sensors.engine),
        lost_workers=tuple(lost),
        noted=functools.partial(notes_of_a_study, study),
        **outcomes,
    )


def replay(study: Study | str | Path, run: int, epoch: int = 0, engine: EngineName = "auto") -> Result:
    """Repeat one run of a study at one epoch, bit for bit, with the traces of all probes of the graph.

    `run` and `epoch` count from 0, in the order of the `study`. `engine` is that of `simulate`.
    Raises `ModelError` for a run or an epoch that the study does not have.

    >>> from proofmass import read_study, replay
    >>> result = replay(read_study("library:scale_factor_drift"), run=3, epoch=5)
    >>> list(result.measures)
    ['noise', 'scale_factor']
    """
    began = time.perf_counter()
    study = study if isinstance(study, Study) else only_study(read_variants(study))
    for what, value, count in (("run", run, study.runs * study.points), ("epoch", epoch, len(study.epochs))):
        if not (whole(value) and value in range(count)):
            raise Problem(
                message=f"there is no such {what}", key=what, got=shown(value), expected=f"0 to {count - 1}"
            ).error
    values = study.drawn(run)[epoch]
    if any(study.calibrated(run)[:epoch]):
        values = SensorRuns(study, engine).parameters(run, epoch)
    planned = varied(plan(study.graph, free=study.varying), study.blocks(values))
    graph = with_parameters(study.graph, values)
    number = noise_run(study, run, epoch)
    result = simulate_plan(planned, graph, RunOptions(seed=study.seed, engine=engine, noise=number, began=began))
    (values_of,) = SensorRuns(study, engine).margins_of([planned]) if study.margins else ((),)
    if isinstance(values_of, ModelError):
        raise values_of
    margins = _measured(margin_measures(planned, study.margins), values_of)
    return dataclasses.replace(result, measures={**result.measures, **margins, **_changes(study, run, epoch, engine)})


def _changes(study: Study, run: int, epoch: int, engine: EngineName) -> dict[str, Measured]:
    """Return what a run has changed by at an epoch: the epochs before it run too."""
    if not study.changes:
        return {}
    sensors = SensorRuns(study, engine)
    row = sensors.runs([run], threading.Event()).values[0, epoch]
    return {name: of for name, of in _measured(sensors.measures, row.tolist()).items() if name in study.changes}


def _measured(measures: Iterable[PlannedMeasure], values: Iterable[float]) -> dict[str, Measured]:
    pairs = zip(measures, values, strict=True)
    return {m.name: Measured(value, m.unit, m.signal, m.statistic, m.shown_in) for m, value in pairs}


def with_numbers(study: AnyStudy, runs: int | None, seed: int | None) -> AnyStudy:
    """Return the study with other runs and seed; None leaves them."""
    return study.changed(runs=study.runs if runs is None else runs, seed=study.seed if seed is None else seed)


def _fill(
    ledger: Ledger,
    source: _Source,
    left: AnyArray,
    means: RunningMeans,
    progress: StudyProgress | None,
) -> None:
    """Do the remaining runs, and write them in batches."""
    batch: list[Outcomes] = []
    done, written = means.end - len(left), time.perf_counter()
    with interrupts() as interrupted, contextlib.closing(source(left, means, interrupted)) as arriving:
        for outcomes in arriving:
            means.add(outcomes)
            batch.append(outcomes)
            done += len(outcomes.numbers)
            if time.perf_counter() - written > BATCH_SECONDS:
                ledger.keep(batch)
                batch, written = [], time.perf_counter()
                if progress:
                    progress(min(done, means.end), means.end, means.text())
        ledger.keep(batch)
        if progress:
            progress(min(done, means.end), means.end, means.text())


def _in_threads(
    sensors: SensorRuns, threads: int, left: AnyArray, means: RunningMeans, interrupted: threading.Event
) -> Generator[Outcomes, None, None]:
    """Yield results in the order of the runs, computed ahead in threads, until the means are known well enough."""
    threads = threads if ENGINES[sensors.engine].threads else 1
    parts, waiting = iter(sensors.parts(left, threads)), deque[Future[Outcomes]]()
    with ThreadPoolExecutor(threads) as pool, contextlib.suppress(StoppedError):
        while True:
            while len(waiting) <= threads and not interrupted.is_set() and not means.enough:
                some = next(parts, None)
                if some is None:
                    break
                waiting.append(pool.submit(sensors.runs, some, interrupted))
            if not waiting:
                return
            yield waiting.popleft().result()
