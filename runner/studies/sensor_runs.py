"""The runs of a study: run k is a pure function of (graph, study, seed, k).

The graph is planned and compiled once, without probes. A run brings the numbers that differ in it and calls the loop;
which engine, which other runs side by side with it and in which order changes no bit of it.
"""

import dataclasses
import threading
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from proofmass.blocks.problem import ModelError
from proofmass.graphs.graph import split
from proofmass.graphs.study import Study
from proofmass.runner.engine.engines import EngineName, choose, lanes_for
from proofmass.runner.engine.faults import failed, name_fault
from proofmass.runner.engine.interpret import Interpreter, TickError
from proofmass.runner.engine.memory import Engine, Memory, start
from proofmass.runner.engine.plan import plan, varied
from proofmass.runner.engine.planned import Plan
from proofmass.runner.engine.result import Array
from proofmass.runner.studies.drawing import drawn_together
from proofmass.runner.studies.margins_per_run import margin_measures, margins_at
from proofmass.runner.studies.measuring import refuse_late, value_of

if TYPE_CHECKING:
    from proofmass.runner.engine.native import CompiledPlan
    from proofmass.runner.studies.side_by_side import SideBySide

CHUNK = 1 << 18  # ticks between looks at Ctrl-C


class SensorRun(NamedTuple):
    """What one run gave at one epoch: values of the measures in the order of their names, or why there are none."""

    run: int
    epoch: int
    values: tuple[float, ...] | None
    fault: str = ""


class SensorRuns:
    """Runs a study's sensors."""

    def __init__(self, study: Study, engine: EngineName = "auto", lanes: int | None = None) -> None:
        self.study = study
        self.plan = plan(dataclasses.replace(study.graph, probes=()))
        self.measures = (*self.plan.measures, *margin_measures(self.plan, study.margins))
        self.ticks = self.plan.ticks()
        refuse_late(self.plan, self.ticks)
        total = self.ticks * study.runs * study.points * len(study.epochs)
        self.engine = choose(self.plan, total, engine)
        wanted = lanes_for(study.runs * study.points) if lanes is None else lanes
        self.lanes = wanted if self.engine == "compiled" else 0
        self.together = self._side_by_side() if self.lanes else None

    def _side_by_side(self) -> "SideBySide":
        from proofmass.runner.studies.side_by_side import SideBySide

        names = {**self.study.drawn(0)[0], **self._unset}
        return SideBySide(self.study, self.plan, self.ticks, self.lanes, names)

    @cached_property
    def _unset(self) -> dict[str, float]:
        """What the parameters that calibrations set are before the first one: values of the graph."""
        nodes = {name: split(name) for name in self.study.recalibration.carried}
        return {name: getattr(self.plan.blocks[block], parameter) for name, (block, parameter) in nodes.items()}

    def code(self) -> str:
        """Hash of the functions that compute a run, of whichever version of the blocks."""
        from proofmass.runner.engine.compile import content_of
        from proofmass.runner.engine.generate import generate

        return content_of(generate(self.plan))

    def runs(self, numbers: Sequence[int], stop: threading.Event) -> list[SensorRun]:
        """Some runs at each epoch, side by side where the engine has lanes.

        Raises `StoppedError` soon after the event is set, where they are side by side.
        """
        if self.together is None:
            return [done for number in numbers for done in self.run(number)]
        drawn, found = drawn_together(self.study, numbers), list[SensorRun]()
        left = {number: dict(self._unset) for number in numbers}
        every = range(len(self.study.epochs))
        for epochs in ([epoch] for epoch in every) if self._unset else [every]:
            which = [(number, epoch) for number in numbers for epoch in epochs]
            values = {name: rows[[*epochs]].T.ravel() for name, rows in drawn.items()}
            values |= {name: np.array([left[number][name] for number, _ in which]) for name in self._unset}
            for run in self._abreast(which, values, stop):
                found.append(run)
                if self.study.calibrated(run.run)[run.epoch]:
                    left[run.run] |= self._left_by(run)
        return sorted(found, key=lambda run: run[:2])

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
        self, which: Sequence[tuple[int, int]], values: Mapping[str, Array], stop: threading.Event
    ) -> Iterator[SensorRun]:
        """Runs and epochs side by side, with a number of each parameter for each."""
        noise = [noise_run(self.study, *each) for each in which]
        found = self.together.measured(values, noise, stop) if self.together else []
        for place, (each, measures) in enumerate(zip(which, found, strict=True)):
            if measures is not None and not self.study.margins:
                yield SensorRun(*each, measures)
            else:
                yield self._at(*each, {name: float(given[place]) for name, given in values.items()}, measures)

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
            return SensorRun(number, epoch, None, str(error.problems[0]))
        except TickError as fault:
            return SensorRun(number, epoch, None, str(failed(self.plan, fault)))
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
        from proofmass.runner.engine.native import CompiledLoop

        return CompiledLoop(changed, self.study.seed, run, start(changed), self._compiled)

    @cached_property
    def _compiled(self) -> "CompiledPlan":
        """The loop of one run; where all go side by side, nothing needs it."""
        from proofmass.runner.engine.native import CompiledPlan

        return CompiledPlan(self.plan)


def noise_run(study: Study, run: int, epoch: int) -> int:
    """The number by which the noise of a run and epoch differs from that of all others that are not its peers."""
    return study.peer(run) * len(study.epochs) + epoch
