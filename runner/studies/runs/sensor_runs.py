"""The runs of a study: run k is a pure function of (graph, study, seed, k).

The graph is planned and compiled once, without probes. A run brings the numbers that differ in it and calls the loop;
which engine, which other runs side by side with it and in which order changes no bit of it.
"""

import dataclasses
import threading
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import split
from proofmass.graphs.studies.study import Study
from proofmass.runner.plan.measuring import refuse_late, value_of
from proofmass.runner.plan.memory import Engine, Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.reference.interpret import Interpreter, TickError
from proofmass.runner.run.engines import EngineName, choose, lanes_for
from proofmass.runner.run.faults import failed, name_fault
from proofmass.runner.run.result import Array
from proofmass.runner.studies.draws.drawing import drawn_together
from proofmass.runner.studies.outcome.outcomes import Outcomes, SensorRun, outcomes_of
from proofmass.runner.studies.runs.margins_per_run import margin_measures, margins_at

if TYPE_CHECKING:
    from proofmass.runner.studies.runs.side_by_side import SideBySide
    from proofmass.runner.targets.native import CompiledPlan

CHUNK = 1 << 18  # ticks between looks at Ctrl-C
PART = 1 << 24  # ticks of all runs that are handed to a thread together
PART_BYTES = 1 << 25  # of memory, at most, that these runs take


class SensorRuns:
    """Runs a study's sensors."""

    def __init__(self, study: Study, engine: EngineName = "auto", lanes: int | None = None) -> None:
        self.study = study
        self.plan = plan(study.graph.changed(probes=()))
        self.measures = (*self.plan.measures, *margin_measures(self.plan, study.margins))
        self.ticks = self.plan.ticks()
        refuse_late(self.plan, self.ticks)
        total = self.ticks * study.runs * study.points * len(study.epochs)
        self.engine = choose(self.plan, total, engine)
        wanted = lanes_for(study.runs * study.points) if lanes is None else lanes
        self.lanes = wanted if self.engine == "compiled" else 0
        self.together = self._side_by_side() if self.lanes else None

    def _side_by_side(self) -> "SideBySide":
        from proofmass.runner.studies.runs.side_by_side import SideBySide

        names = {**self.study.drawn(0)[0], **self._unset}
        return SideBySide(self.study, self.plan, self.ticks, self.lanes, names)

    @cached_property
    def _unset(self) -> dict[str, float]:
        """What the parameters that calibrations set are before the first one: values of the graph."""
        nodes = {name: split(name) for name in self.study.recalibration.carried}
        return {name: getattr(self.plan.blocks[block], parameter) for name, (block, parameter) in nodes.items()}

    def code(self) -> str:
        """Hash of the functions that compute a run, of whichever version of the blocks."""
        from proofmass.runner.program.generate import generate
        from proofmass.runner.targets.compile import content_of

        return content_of(generate(self.plan))

    def parts(self, numbers: Array, threads: int) -> Iterator[Array]:
        """Runs in parts for `runs`: enough in each that what is done once a part counts little, as many a thread."""
        size = 1
        if self.together is not None:
            epochs, groups = len(self.study.epochs), -(-len(numbers) // self.lanes)
            largest = min(
                PART // (self.ticks * self.lanes * epochs), PART_BYTES // (self.together.compiled.size * epochs)
            )
            parts = threads * -(-groups // (threads * max(1, largest)))
            size = self.lanes * max(1, -(-groups // max(1, parts)))
        for first in range(0, len(numbers), size):
            yield numbers[first : first + size]

    def runs(self, numbers: Sequence[int] | Array, stop: threading.Event) -> Outcomes:
        """Some runs at all epochs, side by side where the engine has lanes.

        Raises `StoppedError` soon after the event is set, where they are side by side.
        """
        epochs, measures = len(self.study.epochs), len(self.measures)
        if self.together is None:
            return outcomes_of((done for number in map(int, numbers) for done in self.run(number)), epochs, measures)
        which = np.array(numbers, dtype=np.int64)
        drawn = drawn_together(self.study, which)
        found = Outcomes(which, np.full((len(which), epochs, measures), np.nan), {})
        left = {name: np.full(len(which), value) for name, value in self._unset.items()}
        intervals = len(self.study.recalibration.every)
        calibrated = np.array([self.study.calibrated(number) for number in range(intervals)])[which % intervals]
        for some in [slice(e, e + 1) for e in range(epochs)] if left else [slice(None)]:
            values = {name: rows[some] for name, rows in drawn.items()}
            values |= {name: now[None] for name, now in left.items()}
            self._abreast(found, range(epochs)[some], values, stop)
            if left:
                self._carry(found, some.start, calibrated[:, some.start], left)
        return found

    def _carry(self, found: Outcomes, epoch: int, calibrated: Array, left: dict[str, Array]) -> None:
        """What calibrations of some runs left in the registers: nothing new where one failed."""
        failed = {number for number, at in found.faults if at == epoch}
        new = calibrated & ~np.isin(found.numbers, list(failed))
        names = [measure.name for measure in self.measures]
        for name, measure in self.study.recalibration.carried.items():
            left[name] = np.where(new, found.values[:, epoch, names.index(measure)], left[name])

    def run(self, number: int) -> list[SensorRun]:
        """One run at each epoch; what a calibration measures is what parameters of the later epochs are."""
        runs, left = list[SensorRun](), dict[str, float]()
        calibrated = self.study.calibrated(number)
        for epoch, values in enumerate(self.study.drawn(number)):
            runs.append(self._at(number, epoch, values | left))
            if calibrated[epoch]:
                left |= self._left_by(runs[-1])
        return runs

    def parameters(self, number: int, epoch: int) -> dict[str, float]:
        """Parameters of a run at an epoch; the calibrations before it are run for what they left."""
        drawn, left = self.study.drawn(number), dict[str, float]()
        for before, calibrated in enumerate(self.study.calibrated(number)[:epoch]):
            if calibrated:
                left |= self._left_by(self._at(number, before, drawn[before] | left))
        return drawn[epoch] | left

    def _left_by(self, run: SensorRun) -> dict[str, float]:
        """What a calibration left in the registers: nothing new where it failed."""
        if run.values is None:
            return {}
        measured = {measure.name: value for measure, value in zip(self.measures, run.values, strict=True)}
        return {name: measured[measure] for name, measure in self.study.recalibration.carried.items()}

    def _abreast(
        self, found: Outcomes, epochs: Sequence[int], values: Mapping[str, Array], stop: threading.Event
    ) -> None:
        """Runs at some epochs side by side, with a number of each parameter for each epoch and run."""
        assert self.together is not None
        shape = len(epochs), len(found.numbers)
        noise = np.array([noise_run(self.study, found.numbers, epoch) for epoch in epochs]).ravel()
        flat = {name: np.broadcast_to(rows, shape).ravel() for name, rows in values.items()}
        measured, sound = self.together.measured(flat, noise, stop)
        own = found.values[:, epochs[0] : epochs[-1] + 1]
        own[..., : measured.shape[1]] = np.moveaxis(measured.reshape(*shape, -1), 0, 1)
        for place in range(len(noise)) if self.study.margins else np.flatnonzero(~sound).tolist():
            at, run = divmod(place, shape[1])
            given = {name: float(each[place]) for name, each in flat.items()}
            known = tuple(measured[place].tolist()) if sound[place] else None
            done = self._at(int(found.numbers[run]), epochs[at], given, known)
            own[run, at] = np.nan if done.values is None else done.values
            if done.fault:
                found.faults[done.run, done.epoch] = done.fault

    def _at(
        self, number: int, epoch: int, values: dict[str, float], measured: tuple[float, ...] | None = None
    ) -> SensorRun:
        """One run at one epoch, of which the signals may have been measured already."""
        try:
            changed = varied(self.plan, self.study.blocks(values))
            if measured is None:
                memory = self._last(changed, noise_run(self.study, number, epoch))
                measured = tuple(value_of(changed, measure, memory) for measure in self.plan.measures)
            margins = margins_at(changed, self.study.margins)
        except ModelError as error:
            return SensorRun(number, epoch, None, _said(error.problems[0]))
        except TickError as fault:
            return SensorRun(number, epoch, None, _said(failed(self.plan, fault)))
        return SensorRun(number, epoch, (*measured, *margins))

    def _last(self, changed: Plan, run: int) -> Memory:
        engine = self._started(changed, run)
        for first in range(0, self.ticks, CHUNK):
            before, last = engine.snapshot(), min(first + CHUNK, self.ticks)
            if not engine.advance(last, ()):
                name_fault(changed, self.study.seed, run, before(), last)
        return engine.memory()

    def _started(self, changed: Plan, run: int) -> Engine:
        if self.engine == "python":
            return Interpreter(changed, self.study.seed, run, start(changed))
        from proofmass.runner.targets.native import CompiledLoop

        return CompiledLoop(changed, self.study.seed, run, start(changed), self._compiled)

    @cached_property
    def _compiled(self) -> "CompiledPlan":
        """The loop of one run; where all go side by side, nothing needs it."""
        from proofmass.runner.targets.native import CompiledPlan

        return CompiledPlan(self.plan)


def _said(problem: Problem) -> str:
    """What went wrong in a run, without the file that the study came from: the same words wherever it runs."""
    return str(dataclasses.replace(problem, file="", line=0))


def noise_run(study: Study, run: Any, epoch: int) -> Any:
    """The number by which the noise of a run and epoch differs from that of all others that are not its peers."""
    return study.peer(run) * len(study.epochs) + epoch
