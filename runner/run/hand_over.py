"""An engine that answers at once: plain Python from the first tick, machine code from the tick at
which it is ready.

The memory goes from one to the other between two ticks. Both engines compute the same bits from any
memory, so that the tick of the hand-over, which no run repeats, changes nothing but the time.
"""

import time
from collections.abc import Callable

from proofmass.runner.plan.memory import Engine, Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter
from proofmass.runner.run.compiling import Compiling
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.engines import INTERPRETED_PART, choose, make_engine
from proofmass.runner.run.estimates import compiling_seconds, is_short

LOOKING_SECONDS = 0.4  # at most, before the first tick, to know if code is in the cache
_LARGE = 1.0  # seconds of compiling above which the answer takes too long
_PATIENCE = 7.0  # time of the compiler per time of plain Python, since they share a lock and cores
_LONGEST_WAIT = 0.2  # seconds, after which Ctrl-C and rows have their turn


def begin(planned: Plan, wanted: EngineName, seed: int, run: int, memory: Memory, ticks: int) -> Engine:
    """The engine of a run that goes on from a memory to the tick `ticks`."""
    name = choose(planned, ticks, wanted)
    if wanted == "auto" and name == "compiled":
        compiling = Compiling(planned, is_short(planned, ticks - memory.tick))
        return HandOver(planned, seed, run, memory, compiling, ticks, compiling_seconds(planned))
    return make_engine(planned, name, seed, run, memory, ticks)


class HandOver:
    """A run up to the tick `ticks`, of which plain Python does the first.

    `expected` are the seconds that compiling takes, about: a run that plain Python ends sooner is
    not compiled.
    """

    def __init__(
        self, plan: Plan, seed: int, run: int, memory: Memory, compiling: Compiling, ticks: int, expected: float
    ) -> None:
        self.plan, self.seed, self.run = plan, seed, run
        self.waited = 0.0  # seconds for machine code
        self.handed_over: int | None = None  # the tick, where plain Python did any before
        self._tick, self._ticks, self._expected = memory.tick, ticks, expected
        self._engine: Engine = Interpreter(plan, seed, run, memory.copy())
        self._compiling: Compiling | None = compiling
        self._began, self._first = time.perf_counter(), memory.tick
        self._chunk: tuple[int, float] | None = None  # ticks and seconds of the last in Python

    @property
    def name(self) -> str:
        """The name of the engine that runs it now."""
        return self._engine.name

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`, as engines do; raises what went wrong with compiling."""
        if self._compiling is not None and self._is_ready(self._compiling):
            self._take_over(self._compiling)
        began = time.perf_counter()
        sound = self._engine.advance(last, rows)
        self._chunk = last - self._tick, time.perf_counter() - began
        self._tick = last
        return sound

    def memory(self) -> Memory:
        """Return the memory itself, which moves on with the run."""
        return self._engine.memory()

    def snapshot(self) -> Callable[[], Memory]:
        """Return a function that gives the memory of this moment."""
        return self._engine.snapshot()

    def _is_ready(self, compiling: Compiling) -> bool:
        """Return whether machine code is ready; wait for it as long as that is worth it."""
        began = time.perf_counter()
        if self._chunk is None:
            compiling.looked.wait(LOOKING_SECONDS if self._expected < _LARGE else 0.0)
        else:
            done, seconds = self._chunk
            left = seconds / done * (self._ticks - self._tick)
            if left > INTERPRETED_PART * self._expected:
                compiling.want()
                if left > self._expected - (began - self._began):
                    compiling.ended.wait(min(_PATIENCE * seconds, _LONGEST_WAIT))
        self.waited += time.perf_counter() - began
        return compiling.ended.is_set()

    def _take_over(self, compiling: Compiling) -> None:
        # start-up time: the first ticks do not wait for the compiler
        from proofmass.runner.targets.native import CompiledLoop

        memory = self._engine.memory()
        self._engine = CompiledLoop(self.plan, self.seed, self.run, memory, compiling.result())
        self._compiling = None
        if self._tick > self._first:
            self.handed_over = self._tick
