"""One run of a graph: plan, choose an engine, advance chunk by chunk, record."""

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import NamedTuple

from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, shown
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.call_numbers import whole
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.limits import LARGEST_SEED
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.measuring import measured
from proofmass.runner.plan.memory import Engine, Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.checkpoint import (
    is_interrupted,
    load_checkpoint,
    recorder,
    remove_checkpoint,
    save_checkpoint,
)
from proofmass.runner.run.engine_table import EngineName, engine_problems
from proofmass.runner.run.faults import RunError, failed, name_fault
from proofmass.runner.run.hand_over import HandOver, begin
from proofmass.runner.run.provenance import integration_of, provenance
from proofmass.runner.run.recorder import Recorder
from proofmass.runner.run.result import Result
from proofmass.runner.run.trace_size import IN_MEMORY, refuse_full, refuse_large, trace_bytes

FIRST_CHUNK = 16  # ticks
CHUNK_SECONDS = 0.05
CHUNK_BYTES = 32 << 20  # of rows


@named_arguments
def simulate(
    graph: GraphSource,
    *,
    duration: str | float | Fraction | None = None,
    samples: int | None = None,
    seed: int | None = None,
    engine: EngineName = "auto",
    folder: str | Path | None = None,
    progress: Progress | None = None,
    resume: bool | None = None,
) -> Result:
    """Run a graph once.

    `duration` runs all ticks from 0 to it, both ends included; `samples` so many base ticks;
    without either the graph says. Traces of more than 256 MiB are written to `.npy` files in
    `folder` as they come, and are mapped from there.

    Ctrl-C (or SIGTERM) ends the run after the chunk under way: the result then holds what was done
    and says that it was interrupted. With a `folder` a checkpoint is kept there, and the same call
    goes on from it to the same bits. With `resume` there must be one; `resume=False` removes it and
    starts at tick 0.

    Raises `ModelError` when the graph is wrong, or other than that of a checkpoint in the folder,
    and `RunError` when a number stops being finite, or leaves a format whose overflow is "refuse".

    `graph` may have come from a file or from Python. `seed` is that of all noise, or else the
    graph's. `engine` is "auto", "python", "compiled" or "cxxrtl"; all give the same bits.
    `progress` is called with the ticks that are done and all ticks.

    >>> from proofmass import read_graph, simulate
    >>> result = simulate(read_graph("library:template"), duration="1 ms")
    >>> [(signal, len(result[signal]), result[signal].unit) for signal in result]
    [('sensor.displacement', 11, 'm'), ('adc.code', 11, '1')]
    """
    options = RunOptions(duration, samples, seed, engine, folder, progress, resume)
    graph = graph_from(graph)
    return simulate_plan(plan(graph), graph, options)


@dataclass(frozen=True)
class RunOptions:
    """Options of one run. `noise` is the run's number in a study; `began`, when preparing began."""

    duration: str | float | Fraction | None = None
    samples: int | None = None
    seed: int | None = None
    engine: EngineName = "auto"
    folder: str | Path | None = None
    progress: Progress | None = None
    resume: bool | None = None
    noise: int = 0
    began: float = field(default_factory=time.perf_counter)


def simulate_plan(planned: Plan, graph: Graph, options: RunOptions) -> Result:
    """Run a plan that is made already, of the graph as it was written, as `simulate` does."""
    run = _run(planned, options)
    place = Path(options.folder) if options.folder is not None else None
    streamed = _streamed(planned, run.ticks, place)
    memory = start(planned)
    rows_before: Mapping[str, int] = {}
    if options.resume and place is None:
        raise ValueError("resume needs the folder of the interrupted run")
    if place is not None and (options.resume or (options.resume is None and is_interrupted(place))):
        memory, rows_before = load_checkpoint(place, planned, run.seed, run.ticks)
    engine = begin(planned, options.engine, run.seed, run.noise, memory, run.ticks)
    recorders = _recorders(planned, run.ticks, place, streamed, rows_before)
    looped = time.perf_counter()
    done, memory, unwritten = _loop(run, engine, memory.tick, recorders, options.progress)
    ended = time.perf_counter()
    base = planned.schedule.base_rate
    overflows = memory.overflow_counts()
    waited, handed_over = (engine.waited, engine.handed_over) if isinstance(engine, HandOver) else (0.0, None)
    result = Result(
        graph=graph,
        traces={probe.signal: recorders[probe.signal].finish(base, probe.unit) for probe in graph.probes},
        measures=measured(planned, memory),
        ticks=done,
        planned_ticks=run.ticks,
        base_rate=base,
        seed=run.seed,
        seconds=ended - looped - waited,
        preparation=looped - options.began + waited,
        provenance=provenance(graph, engine.name, integration_of(planned), handed_over),
        overflows=overflows,
        overflow_ticks={name: planned.schedule.beat(name).before(done) for name in overflows},
        memory=memory if done < run.ticks else None,
    )
    if place is not None:
        if result.interrupted:
            save_checkpoint(result, planned, place)
        else:
            remove_checkpoint(result, place)
    if unwritten is not None:
        message = f"{unwritten.strerror}; the {done:,} ticks that are done are kept, the same run goes on from there"
        raise OSError(unwritten.errno, message, unwritten.filename or str(place))
    return result


def ticks_of(planned: Plan, options: RunOptions) -> int:
    """Return how many ticks a run with these options has; raises `ModelError`."""
    return _run(planned, options).ticks


class _Run(NamedTuple):
    """A plan, and what was asked of its run, read."""

    planned: Plan
    ticks: int
    seed: int
    noise: int


def _run(planned: Plan, options: RunOptions) -> _Run:
    """Return the run with its length and seed; raises `ModelError` with all wrong options."""
    problems = engine_problems(options.engine)

    def refuse(key: str, value: object, message: str, expected: str = "", hint: str = "") -> None:
        problems.append(Problem(message=message, key=key, got=shown(value), expected=expected, hint=hint))

    seconds, ticks = None, None
    if options.duration is not None and options.samples is not None:
        refuse("samples", options.samples, "give samples or duration, not both")
    elif options.duration is not None:
        try:
            seconds = read_duration(options.duration)
        except Refusal as error:
            refuse("duration", options.duration, str(error), hint=error.hint)
    elif options.samples is not None:
        ticks = plain(options.samples)
        if not whole(ticks) or ticks < 1:
            refuse("samples", options.samples, "must be an integer of at least 1")
    seed = planned.graph.seed if options.seed is None else plain(options.seed)
    if not whole(seed) or not 0 <= seed <= LARGEST_SEED:
        refuse("seed", seed, "must be an integer", expected=f"0 to {LARGEST_SEED}")
    if problems:
        raise ModelError(problems)
    return _Run(planned, planned.ticks(seconds, ticks), seed, options.noise)


def _loop(
    run: _Run, engine: Engine, done: int, recorders: Mapping[str, Recorder], progress: Progress | None
) -> tuple[int, Memory, OSError | None]:
    """Chunk after chunk of about 50 ms, so that Ctrl-C and progress are soon served.

    Returns the ticks done, what moves after them, and why a file of rows could not be written.
    """
    planned, total, chunk = run.planned, run.ticks, FIRST_CHUNK
    row_bytes = sum(8 * math.prod(p.shape) / p.stride for p in planned.probes)
    largest = max(1, int(CHUNK_BYTES / row_bytes)) if row_bytes else total
    with interrupts() as interrupted:
        while done < total and not interrupted.is_set():
            if progress:
                progress(done, total)
            before = engine.snapshot()
            last = min(done + chunk, total)
            began = time.perf_counter()
            rows = [recorders[p.signal].space(p.rows(done, last)) for p in planned.probes]
            try:
                if not engine.advance(last, rows):
                    name_fault(planned, run.seed, run.noise, before(), last)
            except TickError as fault:
                raise RunError(failed(planned, fault)) from fault.__cause__
            seconds = time.perf_counter() - began
            try:
                for probe, values in zip(planned.probes, rows, strict=True):
                    recorders[probe.signal].keep(values)
            except OSError as error:
                return done, before(), error
            done = last
            if seconds < CHUNK_SECONDS / 2:
                chunk = min(2 * chunk, largest)
            elif seconds > 2 * CHUNK_SECONDS:
                chunk = max(chunk // 2, 1)
        if progress:
            progress(done, total)
    return done, engine.memory(), None


def _streamed(planned: Plan, ticks: int, folder: Path | None) -> bool:
    """Return whether the traces are written to files as they come, since together they do not fit into memory."""
    if folder is None:
        refuse_large(planned, ticks, IN_MEMORY)
    elif trace_bytes(planned, ticks) > IN_MEMORY:
        refuse_full(planned, ticks, folder)
    return trace_bytes(planned, ticks) > IN_MEMORY


def _recorders(
    planned: Plan, ticks: int, folder: Path | None, streamed: bool, before: Mapping[str, int]
) -> dict[str, Recorder]:
    """A recorder per probe, which continues after the rows that an interrupted run wrote."""
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    if folder is not None and before:
        return {p.signal: recorder(p, p.rows(0, ticks), folder, streamed, before[p.signal]) for p in planned.probes}
    place = folder if streamed else None
    return {p.signal: Recorder(p, p.rows(0, ticks), place) for p in planned.probes}
