"""One run of a graph: plan, choose an engine, advance chunk by chunk, record."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from types import FrameType
from typing import Any, Literal

import numpy as np

from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.graph import LARGEST_RUN, Graph, read_duration
from proofmass.runner.interpret import Interpreter
from proofmass.runner.memory import Engine, Memory, start
from proofmass.runner.plan import Plan, plan
from proofmass.runner.provenance import provenance
from proofmass.runner.result import Recorder, Result

EngineName = Literal["auto", "python", "compiled"]
Progress = Callable[[int, int], None]  # ticks done, ticks in all

IN_MEMORY = 256 << 20  # bytes of traces; more goes to files
CHUNK_SECONDS = 0.05
CHUNK_BYTES = 32 << 20
INTERPRETED_SECONDS = 1.0  # what plain Python may take before compiling is worth it
_INTERPRETED_STEP = 1.5e-6  # seconds a block and tick in plain Python, measured


class RunError(RuntimeError):
    """A run that failed, with the problem: block, port, tick and time."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        super().__init__(str(problem))


def simulate(
    graph: Graph,
    *,
    duration: str | float | Fraction | None = None,
    samples: int | None = None,
    seed: int | None = None,
    engine: EngineName = "auto",
    folder: str | Path | None = None,
    progress: Progress | None = None,
    resume: "tuple[Memory, dict[str, Any]] | None" = None,
) -> Result:
    """Run a graph once.

    `duration` runs all ticks from 0 to it, both ends included; `samples` so many base ticks; without either the graph
    says. Traces of more than 256 MiB are written to `.npy` files in `folder` as they come, and are mapped from there.
    `resume` takes the memory and rows of a checkpoint. Ctrl-C ends the run after the chunk under way: the result then
    holds what was done and says that it was interrupted.

    Raises `ModelError` when the graph is wrong and `RunError` when a number stops being finite.
    """
    began = time.perf_counter()
    planned = plan(graph)
    total = planned.ticks(read_duration(duration) if duration is not None else None, samples)
    _refuse_length(planned, total)
    chosen_seed = graph.seed if seed is None else seed
    memory, kept = resume or (start(planned), {})
    runs = make_engine(planned, choose(planned, total, engine), chosen_seed, memory)
    recorders = _recorders(planned, total, Path(folder) if folder else None)
    for name, rows in kept.items():
        recorders[name].keep(rows)
    looped = time.perf_counter()
    done = _loop(planned, runs, memory.tick, total, recorders, progress, chosen_seed)
    ended = time.perf_counter()
    base = planned.schedule.base_rate
    return Result(
        graph=graph,
        traces={name: recorder.finish(base) for name, recorder in recorders.items()},
        ticks=done,
        planned_ticks=total,
        base_rate=base,
        seed=chosen_seed,
        seconds=ended - looped,
        preparation=looped - began,
        provenance=provenance(graph, runs.name),
        memory=runs.memory() if done < total else None,
    )


def choose(planned: Plan, ticks: int, wanted: EngineName) -> str:
    """The engine that is ready sooner: short runs are interpreted, long ones and ones compiled before are compiled."""
    if wanted != "auto":
        return wanted
    if ticks * len(planned.schedule.order) * _INTERPRETED_STEP < 0.1:
        return "python"
    if ticks * len(planned.schedule.order) * _INTERPRETED_STEP > INTERPRETED_SECONDS:
        return "compiled"
    from proofmass.runner.native import already_compiled

    return "compiled" if already_compiled(planned) else "python"


def make_engine(planned: Plan, name: str, seed: int, memory: Memory) -> Engine:
    """An engine that starts from a memory."""
    if name == "python":
        return Interpreter(planned, seed, memory=memory.copy())
    from proofmass.runner.native import CompiledLoop

    return CompiledLoop(planned, seed, memory=memory)


def _loop(
    planned: Plan,
    engine: Engine,
    done: int,
    total: int,
    recorders: dict[str, Recorder],
    progress: Progress | None,
    seed: int,
) -> int:
    chunk = 256 if engine.name == "python" else 1 << 14
    row_bytes = sum(8 * int(np.prod(p.shape)) / p.stride for p in planned.probes)
    largest = max(1, int(CHUNK_BYTES / row_bytes)) if row_bytes else LARGEST_RUN
    with _interrupts() as interrupted:
        while done < total and not interrupted.is_set():
            if progress:
                progress(done, total)
            before = engine.snapshot()
            last = min(done + chunk, total)
            began = time.perf_counter()
            rows = [recorders[p.signal].space(p.rows(done, last)) for p in planned.probes]
            try:
                engine.advance(last, rows)
            except ArithmeticError:
                raise RunError(_fault(planned, before(), last, seed)) from None
            taken = time.perf_counter() - began
            if not (engine.finite() and all(_finite(values) for values in rows if values.dtype == np.float64)):
                raise RunError(_fault(planned, before(), last, seed))
            for probe, values in zip(planned.probes, rows, strict=True):
                recorders[probe.signal].keep(values)
            done = last
            if taken < CHUNK_SECONDS / 2:
                chunk = min(2 * chunk, largest)
            elif taken > 2 * CHUNK_SECONDS:
                chunk = max(chunk // 2, 1)
        if progress:
            progress(done, total)
    return done


def _fault(planned: Plan, before: Memory, last: int, seed: int) -> Problem:
    """Where a number stopped being finite: the chunk once more in plain Python, output by output."""
    engine = Interpreter(planned, seed, memory=before)
    wires = before.wires
    for tick in range(before.tick, last):
        at = f"in tick {tick}, t = {float(tick / planned.schedule.base_rate):.9g} s"
        due = engine.outputs(tick)
        where = "a block"
        try:
            for node, value in due:
                wires[node] = value
                where = ".".join(node)
                if not _finite(value):
                    return _not_finite(planned, node, value, at)
            engine.move(tick)
        except ArithmeticError as error:
            name = engine.at
            return planned.graph.placed(
                Problem(message=f"{error} {at}", key=name, hint="record its inputs", path=("blocks", name.split(".")[0]))
            )
        if not engine.finite():
            name = next(n for n, state in before.states.items() if state is not None and not _finite(state))
            return _not_finite(planned, (name, "state"), before.states[name], at)
    return Problem(message=f"a number was not finite before tick {last}", key=where)


def _not_finite(planned: Plan, node: tuple[str, str], value: Any, at: str) -> Problem:
    inputs = [
        f"{i} = {planned.schedule.drivers[node[0], i][0]}.{planned.schedule.drivers[node[0], i][1]}"
        for i in planned.blocks[node[0]].inputs
        if (node[0], i) in planned.schedule.drivers
    ]
    return planned.graph.placed(
        Problem(
            message=f"is not finite {at}",
            key=".".join(node),
            got=str(value),
            hint="the loop may be unstable, or a parameter of the wrong size"
            + (f"; probe what drives it: {', '.join(inputs)}" if inputs else ""),
            path=("blocks", node[0]),
        )
    )


def _finite(values: Any) -> bool:
    return bool(np.isfinite(values).all())


def _recorders(planned: Plan, total: int, folder: Path | None) -> dict[str, Recorder]:
    """A recorder per probe, in memory as long as all traces fit."""
    rows = {p.signal: p.rows(0, total) for p in planned.probes}
    size = sum(8 * rows[p.signal] * int(np.prod(p.shape)) for p in planned.probes)
    if size > IN_MEMORY and folder is None:
        problem = Problem(
            message="the traces are too large for memory",
            key="probes",
            got=f"{size / 2**20:,.0f} MiB",
            expected=f"at most {IN_MEMORY >> 20} MiB without a folder",
            hint="say --out FOLDER to write them as they come, or thin a probe: every = 1000",
            path=("probes",),
        )
        raise ModelError([planned.graph.placed(problem)])
    if size > IN_MEMORY and folder:
        folder.mkdir(parents=True, exist_ok=True)
    return {p.signal: Recorder(p, rows[p.signal], folder if size > IN_MEMORY else None) for p in planned.probes}


def _refuse_length(planned: Plan, total: int) -> None:
    if not 1 <= total <= LARGEST_RUN:
        problem = Problem(message="cannot run so long", key="samples", got=f"{total:g} ticks", expected="1 to 1e12 ticks")
        raise ModelError([planned.graph.placed(problem)])


@contextmanager
def _interrupts() -> Iterator[threading.Event]:
    """An event that Ctrl-C sets instead of breaking into a chunk; as it was before afterwards."""
    pressed = threading.Event()

    def note(number: int, frame: FrameType | None) -> None:
        pressed.set()

    if threading.current_thread() is not threading.main_thread():
        yield pressed
        return
    before = signal.signal(signal.SIGINT, note)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)
