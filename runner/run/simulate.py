"""One run of a graph: plan, choose an engine, advance chunk by chunk, record."""

import math
import time
from collections.abc import Callable, Mapping
from fractions import Fraction
from pathlib import Path
from typing import get_args

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.graphs.model.graph import LARGEST_SEED, Graph
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.plan.measuring import measured
from proofmass.runner.plan.memory import Engine, Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.engines import EngineName, choose, make_engine
from proofmass.runner.run.faults import RunError, failed, name_fault
from proofmass.runner.run.provenance import integration_of, provenance
from proofmass.runner.run.result import Recorder, Result
from proofmass.runner.run.trace_size import IN_MEMORY, refuse_large, trace_bytes

Progress = Callable[[int, int], None]  # ticks done, ticks in all

FIRST_CHUNK = 16  # ticks
CHUNK_SECONDS = 0.05
CHUNK_BYTES = 32 << 20  # of rows


def simulate(
    graph: Graph,
    *,
    duration: str | float | Fraction | None = None,
    samples: int | None = None,
    seed: int | None = None,
    engine: EngineName = "auto",
    folder: str | Path | None = None,
    progress: Progress | None = None,
    resume: bool = False,
) -> Result:
    """Run a graph once.

    `duration` runs all ticks from 0 to it, both ends included; `samples` so many base ticks; without either the graph
    says. Traces of more than 256 MiB are written to `.npy` files in `folder` as they come, and are mapped from there.

    Ctrl-C (or SIGTERM) ends the run after the chunk under way: the result then holds what was done and says that it
    was interrupted. With a `folder` a checkpoint is kept there, and `resume` goes on from it to the same bits.

    Raises `ModelError` when the graph is wrong and `RunError` when a number stops being finite, or leaves a format
    whose overflow is "refuse".
    """
    began = time.perf_counter()
    return simulate_plan(plan(graph), graph, 0, duration, samples, seed, engine, folder, progress, resume, began)


def simulate_plan(
    planned: Plan,
    graph: Graph,
    run: int,
    duration: str | float | Fraction | None,
    samples: int | None,
    seed: int | None,
    engine: EngineName,
    folder: str | Path | None,
    progress: Progress | None,
    resume: bool,
    began: float,
) -> Result:
    """As `simulate`, of a plan that is made already, `graph` as it was written; `run` counts in its noise."""
    wanted = _Wanted(planned, duration, samples, seed, engine)
    place = Path(folder) if folder is not None else None
    streamed = _streamed(planned, wanted.ticks, place)
    memory = start(planned)
    kept: Mapping[str, int] = {}
    if resume:
        if place is None:
            raise ValueError("resume needs the folder of the interrupted run")
        from proofmass.runner.run.checkpoint import load_checkpoint

        memory, kept = load_checkpoint(place, planned, wanted.seed, wanted.ticks)
    runs = make_engine(planned, choose(planned, wanted.ticks, engine), wanted.seed, run, memory)
    recorders = _recorders(planned, wanted.ticks, place, streamed, kept)
    looped = time.perf_counter()
    done, memory, unwritten = _loop(planned, runs, memory.tick, wanted, run, recorders, progress)
    ended = time.perf_counter()
    base = planned.schedule.base_rate
    overflows = memory.overflow_counts()
    result = Result(
        graph=graph,
        traces={probe.signal: recorders[probe.signal].finish(base) for probe in graph.probes},
        measures=measured(planned, memory),
        ticks=done,
        planned_ticks=wanted.ticks,
        base_rate=base,
        seed=wanted.seed,
        seconds=ended - looped,
        preparation=looped - began,
        provenance=provenance(graph, runs.name, integration_of(planned)),
        overflows=overflows,
        overflow_ticks={name: -(-done // planned.schedule.divisors[name]) for name in overflows},
        memory=memory if done < wanted.ticks else None,
    )
    if place is not None:
        from proofmass.runner.run.checkpoint import remove_checkpoint, save_checkpoint

        if result.interrupted:
            save_checkpoint(result, planned, place)
        else:
            remove_checkpoint(result, place)
    if unwritten is not None:
        message = f"{unwritten.strerror}; the {done:,} ticks that are done are kept, resume goes on from there"
        raise OSError(unwritten.errno, message, str(place))
    return result


class _Wanted:
    """Length, seed and engine of a run as the caller gave them, read and refused."""

    def __init__(self, planned: Plan, duration: object, samples: object, seed: object, engine: object) -> None:
        problems = []

        def refuse(key: str, value: object, message: str, expected: str = "", hint: str = "") -> None:
            problems.append(Problem(message=message, key=key, got=shown(value), expected=expected, hint=hint))

        seconds, ticks = None, None
        if duration is not None and samples is not None:
            refuse("samples", samples, "give samples or duration, not both")
        elif duration is not None:
            try:
                seconds = read_duration(duration)
            except Refusal as error:
                refuse("duration", duration, str(error), hint=error.hint)
        elif samples is not None:
            if isinstance(samples, int) and not isinstance(samples, bool) and samples >= 1:
                ticks = samples
            else:
                refuse("samples", samples, "must be an integer of at least 1")
        self.seed = planned.graph.seed
        if isinstance(seed, int) and not isinstance(seed, bool) and 0 <= seed <= LARGEST_SEED:
            self.seed = seed
        elif seed is not None:
            refuse("seed", seed, "must be an integer", expected=f"0 to {LARGEST_SEED}")
        if engine not in get_args(EngineName):
            hint = did_you_mean(str(engine), get_args(EngineName), "the engines")
            refuse("engine", engine, "there is no such engine", hint=hint)
        if problems:
            raise ModelError(problems)
        self.ticks = planned.ticks(seconds, ticks)


def _loop(
    planned: Plan,
    engine: Engine,
    done: int,
    wanted: _Wanted,
    run: int,
    recorders: Mapping[str, Recorder],
    progress: Progress | None,
) -> tuple[int, Memory, OSError | None]:
    """Chunk after chunk of about 50 ms, so that Ctrl-C and progress are soon served.

    Returns the ticks done, what moves after them, and why a file of rows could not be written.
    """
    total, chunk = wanted.ticks, FIRST_CHUNK
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
                    name_fault(planned, wanted.seed, run, before(), last)
            except TickError as fault:
                raise RunError(failed(planned, fault)) from fault.__cause__
            taken = time.perf_counter() - began
            try:
                for probe, values in zip(planned.probes, rows, strict=True):
                    recorders[probe.signal].keep(values)
            except OSError as error:
                return done, before(), error
            done = last
            if taken < CHUNK_SECONDS / 2:
                chunk = min(2 * chunk, largest)
            elif taken > 2 * CHUNK_SECONDS:
                chunk = max(chunk // 2, 1)
        if progress:
            progress(done, total)
    return done, engine.memory(), None


def _streamed(planned: Plan, ticks: int, folder: Path | None) -> bool:
    """Whether the traces are written to files as they come, since together they do not fit into memory."""
    if folder is None:
        refuse_large(planned, ticks, IN_MEMORY)
    return trace_bytes(planned, ticks) > IN_MEMORY


def _recorders(
    planned: Plan, ticks: int, folder: Path | None, streamed: bool, kept: Mapping[str, int]
) -> dict[str, Recorder]:
    """A recorder per probe, which goes on behind the rows that are kept."""
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    if folder is not None and kept:
        from proofmass.runner.run.checkpoint import recorder

        return {p.signal: recorder(p, p.rows(0, ticks), folder, streamed, kept[p.signal]) for p in planned.probes}
    place = folder if streamed else None
    return {p.signal: Recorder(p, p.rows(0, ticks), place) for p in planned.probes}
