"""Runs to an operating point: in plain Python at first, in machine code once that takes long."""

import time
from dataclasses import replace
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.memory import Engine, Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.run.engines import choose, make_engine
from proofmass.runner.run.faults import failed, name_fault

if TYPE_CHECKING:
    from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
    from proofmass.runner.targets.native_slopes import SlopeCode


INTERPRETED = 1.5  # seconds of plain Python, after which the loop is compiled
_CHUNK = 0.05  # seconds from one report of progress to the next


class Forward:
    """A run that can be continued. Plain Python and machine code give the same bits."""

    def __init__(
        self,
        plan: Plan,
        memory: Memory | None = None,
        progress: Progress | None = None,
        compiled: "CompiledPlan | None" = None,
    ) -> None:
        self._plan, self.progress, self._compiled = replace(plan, probes=()), progress, compiled
        begin = memory or start(plan)
        self._engine = self._python(begin) if self._compiled is None else self._machine_code(begin)
        self.tick, self._spent, self._chunk = begin.tick, 0.0, 16
        self._asked = 0  # ticks for which an engine was chosen

    @property
    def engine(self) -> str:
        """The name of the engine that runs it now."""
        return self._engine.name

    @property
    def compiled(self) -> "CompiledPlan | None":
        """Machine code of the plan, once the run has wanted it."""
        return self._compiled

    def to(self, last: int, of: int = 0) -> Memory:
        """Run to the start of the tick `last` and return the memory there; raises `ModelError` if a tick fails."""
        if self._engine.name == "python" and last - self.tick > self._asked:
            self._asked = last - self.tick  # asking costs as much as some ticks, too much for each of many short parts
            if choose(self._plan, self._asked, "auto") == "compiled":
                self.compile()
        while self.tick < last:
            if self.progress:
                self.progress(self.tick, max(of, last))
            first, following, before = self.tick, min(self.tick + self._chunk, last), self._engine.snapshot()
            began = time.perf_counter()
            try:
                if not self._engine.advance(following, ()):
                    name_fault(self._plan, self._plan.graph.seed, 0, before(), following)
            except TickError as error:
                self.tick = last + 1  # no run goes on from here
                raise ModelError([failed(self._plan, error)]) from error
            seconds = time.perf_counter() - began
            self.tick = following
            if seconds < _CHUNK / 2:
                self._chunk *= 2
            elif seconds > 2 * _CHUNK:
                self._chunk = max(self._chunk // 2, 1)
            self._spent += seconds
            left = seconds / (self.tick - first) * (max(of, last) - self.tick)
            if self._engine.name == "python" and self._spent > INTERPRETED < left:
                self.compile()
        return self._engine.memory().copy()

    def compile(self) -> None:
        """Go on in machine code, if the plan can."""
        if choose(self._plan, LARGEST_RUN, "auto") == "compiled":  # not with values beyond 64 bits
            self._engine = self._machine_code(self._engine.memory())

    def _python(self, memory: Memory) -> Engine:
        return make_engine(self._plan, "python", self._plan.graph.seed, 0, memory)

    def _machine_code(self, memory: Memory) -> Engine:
        # start-up time: short runs need no compiler
        from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

        self._compiled = self._compiled or CompiledPlan(self._plan)
        return CompiledLoop(self._plan, self._plan.graph.seed, 0, memory, self._compiled)


class Course:
    """The run of a plan from tick 0, without noise: how far it has got, and its machine code.

    An analysis owns one. Runs that go on from elsewhere borrow its machine code, and so does a course `like` another
    whose plan differs in numbers alone.
    """

    def __init__(self, plan: Plan, like: "Course | None" = None) -> None:
        self.plan = plan.without_noise
        self._run: Forward | None = None
        self._slopes: SlopeCode | None = None
        self._like = like

    def slopes(self) -> "SlopeCode | None":
        """Return the machine code of ticks with their slopes, if the plan has such."""
        if self._like is not None:
            return self._like.slopes()
        # start-up time: short periods need no compiler
        from proofmass.runner.targets.native_slopes import SlopeCode, has_slopes

        if self._slopes is None and has_slopes(self.plan) and choose(self.plan, LARGEST_RUN, "auto") == "compiled":
            self._slopes = SlopeCode(self.plan)
        return self._slopes

    def at(self, tick: int, progress: Progress | None = None, of: int = 0) -> Memory:
        """Return the memory at the start of a tick of a run of `of` ticks; raises `ModelError` if the run fails."""
        if tick == 0:
            return start(self.plan)
        if self._run is None or self._run.tick > tick:
            self._run = self.from_memory(None)
        self._run.progress = progress
        return self._run.to(tick, of)

    def machine_code(self, memory: Memory, wanted: bool = False) -> "CompiledLoop | None":
        """Return a run in machine code from a memory on, if there is such code by now, or can be if it is `wanted`."""
        if wanted:
            self._run = self._run or self.from_memory(None)
            self._run.compile()
        compiled = self._run.compiled if self._run else None
        if compiled is None:
            return None
        # start-up time: only what was compiled before needs it
        from proofmass.runner.targets.native import CompiledLoop

        return CompiledLoop(compiled.plan, compiled.plan.graph.seed, 0, memory.copy(), compiled)

    def from_memory(self, memory: Memory | None) -> Forward:
        """Return a run from a memory on, or from tick 0."""
        run = self._run or (self._like and self._like._run)
        return Forward(self.plan, memory and memory.copy(), compiled=run.compiled if run else None)
