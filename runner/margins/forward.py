"""A graph run to its operating point: in plain Python at first, in machine code once that takes long."""

import time
from collections.abc import Callable
from dataclasses import replace

from proofmass.blocks.problem import ModelError
from proofmass.graphs.graph import LARGEST_RUN
from proofmass.runner.engine.engines import choose, make_engine
from proofmass.runner.engine.faults import failed, name_fault
from proofmass.runner.engine.interpret import TickError
from proofmass.runner.engine.memory import Memory, start
from proofmass.runner.engine.planned import Plan

Progress = Callable[[int, int], None]  # ticks done, and of how many

INTERPRETED = 1.5  # seconds of plain Python, after which the loop is compiled
_CHUNK = 0.05  # seconds from one report of progress to the next


class Forward:
    """A run that goes on as far as it is wanted. Plain Python and machine code give the same bits."""

    def __init__(self, plan: Plan, memory: Memory | None = None, progress: Progress | None = None) -> None:
        self._plan, self._progress = replace(plan, probes=()), progress
        begin = memory or start(plan)
        self._engine = make_engine(self._plan, "python", plan.graph.seed, 0, begin)
        self.tick, self._spent, self._chunk = begin.tick, 0.0, 16

    @property
    def engine(self) -> str:
        """Name of the engine that runs it now."""
        return self._engine.name

    def to(self, last: int, of: int = 0) -> Memory:
        """What moves at the start of the tick `last`; raises `TickError` in a tick before it that fails."""
        if self._engine.name == "python" and choose(self._plan, last - self.tick, "auto") == "compiled":
            self._compile()
        while self.tick < last:
            if self._progress:
                self._progress(self.tick, max(of, last))
            first, following, before = self.tick, min(self.tick + self._chunk, last), self._engine.snapshot()
            began = time.perf_counter()
            if not self._engine.advance(following, ()):
                name_fault(self._plan, self._plan.graph.seed, 0, before(), following)
            taken = time.perf_counter() - began
            self.tick = following
            if taken < _CHUNK / 2:
                self._chunk *= 2
            elif taken > 2 * _CHUNK:
                self._chunk = max(self._chunk // 2, 1)
            self._spent += taken
            left = taken / (self.tick - first) * (max(of, last) - self.tick)
            if self._engine.name == "python" and self._spent > INTERPRETED < left:
                self._compile()
        return self._engine.memory().copy()

    def _compile(self) -> None:
        if choose(self._plan, LARGEST_RUN, "auto") == "compiled":  # what has values of over 64 bits cannot
            self._engine = make_engine(self._plan, "compiled", self._plan.graph.seed, 0, self._engine.memory())


class _Latest:
    """The last operating point that was run to: what is asked next is most often the same one, or a later one."""

    plan: Plan | None = None
    memory: Memory | None = None


def memory_at(plan: Plan, tick: int, progress: Progress | None = None) -> Memory:
    """The memory at the start of a tick, after a run from tick 0; raises `ModelError` where that fails."""
    if tick == 0:
        return start(plan)
    known = _Latest.memory if _Latest.plan is plan else None
    try:
        reached = Forward(plan, known if known and known.tick <= tick else None, progress).to(tick)
    except TickError as error:
        raise ModelError([failed(plan, error)]) from error
    keep(plan, reached)
    return reached.copy()


def keep(plan: Plan, memory: Memory) -> None:
    """Remember where a plan has got to."""
    _Latest.plan, _Latest.memory = plan, memory
