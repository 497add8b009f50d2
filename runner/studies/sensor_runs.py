"""The runs of a study, one at a time: run k is a pure function of (graph, study, seed, k).

The graph is planned and compiled once, without probes. A run brings constants and starts of the blocks that differ in
it and calls the loop; which engine, which other runs and in which order changes no bit of it.
"""

import dataclasses
from collections.abc import Callable
from typing import NamedTuple

from proofmass.blocks.problem import ModelError
from proofmass.graphs.study import Study
from proofmass.runner.engine.engines import EngineName, choose
from proofmass.runner.engine.faults import failed, name_fault
from proofmass.runner.engine.interpret import Interpreter, TickError
from proofmass.runner.engine.memory import Engine, Memory, start
from proofmass.runner.engine.plan import plan, varied
from proofmass.runner.engine.planned import Plan
from proofmass.runner.studies.measuring import refuse_late, value_of

CHUNK = 1 << 18  # ticks between looks at Ctrl-C


class SensorRun(NamedTuple):
    """What one run gave at one epoch: values of the measures in the order of their names, or why there are none."""

    run: int
    epoch: int
    values: tuple[float, ...] | None
    fault: str = ""


class SensorRuns:
    """Runs a study's sensors."""

    def __init__(self, study: Study, engine: EngineName = "auto") -> None:
        self.study = study
        self.plan = plan(dataclasses.replace(study.graph, probes=()))
        self.ticks = self.plan.ticks()
        refuse_late(self.plan, self.ticks)
        total = self.ticks * study.runs * study.points * len(study.epochs)
        self.engine = choose(self.plan, total, engine)
        self._make: Callable[[Plan, int, int, Memory], Engine] = Interpreter
        if self.engine == "compiled":
            from proofmass.runner.engine.native import CompiledLoop, CompiledPlan

            compiled = CompiledPlan(self.plan)
            self._make = lambda plan, seed, run, memory: CompiledLoop(plan, seed, run, memory, compiled)

    def code(self) -> str:
        """Hash of the functions that compute a run, of whichever version of the blocks."""
        from proofmass.runner.engine.compile import content_of
        from proofmass.runner.engine.generate import generate

        return content_of(generate(self.plan))

    def run(self, number: int) -> list[SensorRun]:
        """One run at each epoch."""
        drawn = self.study.drawn(number)
        return [self._at(number, epoch, values) for epoch, values in enumerate(drawn)]

    def _at(self, number: int, epoch: int, values: dict[str, float]) -> SensorRun:
        try:
            changed = varied(self.plan, self.study.blocks(values))
            memory = self._last(changed, noise_run(self.study, number, epoch))
        except ModelError as error:
            return SensorRun(number, epoch, None, str(error.problems[0]))
        except TickError as fault:
            return SensorRun(number, epoch, None, str(failed(self.plan, fault)))
        return SensorRun(number, epoch, tuple(value_of(changed, measure, memory) for measure in self.plan.measures))

    def _last(self, changed: Plan, run: int) -> Memory:
        engine: Engine = self._make(changed, self.study.seed, run, start(changed))
        for first in range(0, self.ticks, CHUNK):
            before, last = engine.snapshot(), min(first + CHUNK, self.ticks)
            if not engine.advance(last, ()):
                name_fault(changed, self.study.seed, run, before(), last)
        return engine.memory()


def noise_run(study: Study, run: int, epoch: int) -> int:
    """The number by which the noise of a run and epoch differs from that of all others."""
    return run * len(study.epochs) + epoch
