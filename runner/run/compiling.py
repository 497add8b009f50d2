"""The loop of a plan on its way to machine code, in a thread of its own, while plain Python runs the first ticks.

First it is looked up: the program is written, which tells its place in the cache. Only when someone
wants it then is it compiled. LLVM works without holding Python's lock; writing the program holds
it.

The end of the process does not wait for machine code, but for LLVM to end the step that it is at,
since its memory is taken away behind. No other step begins then.
"""

import atexit
import threading
from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING

from proofmass.runner.host.llvm_lock import AT_WORK
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.program.tick_loop import TickLoop
    from proofmass.runner.targets.machine_code import LlvmModule
    from proofmass.runner.targets.native import CompiledPlan

_leaving = threading.Event()  # the process is about to end


class _LeavingError(Exception):
    """Raised in a thread whose work nobody waits for any more."""


class Compiling:
    """The machine code of a plan, as far as it is.

    `looked` is set once it is known whether it is in the cache; `ended` once the machine code is
    there, or cannot be. It is made for a long run, or is `quick`.
    """

    def __init__(self, plan: Plan, quick: bool = False) -> None:
        self.plan, self._quick = plan, quick
        self.looked, self.ended = threading.Event(), threading.Event()
        self._prepared: tuple[TickLoop, LlvmModule] | None = None
        self._compiled: CompiledPlan | None = None
        self._failed: BaseException | None = None
        self._wanted, self._looking = False, threading.Lock()
        self._begin(self._look)

    def want(self) -> None:
        """Have it compiled, once it is known that the cache does not hold it."""
        with self._looking:
            idle, self._wanted = self.looked.is_set() and not self._wanted and not self.ended.is_set(), True
        if idle:
            self._begin(self._compile)

    def result(self) -> "CompiledPlan":
        """The machine code once it has `ended`; raises what went wrong."""
        if self._failed is not None:
            raise self._failed
        assert self._compiled is not None, "the work has not ended"
        return self._compiled

    def _look(self) -> None:
        # start-up time: the first ticks do not wait for the compiler
        from proofmass.runner.program.tick import write_tick
        from proofmass.runner.targets.machine_code import is_cached
        from proofmass.runner.targets.native import module_of

        written = write_tick(self.plan)
        with AT_WORK:
            _go_on()
            self._prepared = written, module_of(written, self._quick)
        if is_cached(self._prepared[1].key):
            self._compile()
        with self._looking:
            self.looked.set()
            wanted = self._wanted and not self.ended.is_set()
        if wanted:
            self._compile()

    def _compile(self) -> None:
        # start-up time: the first ticks do not wait for the compiler
        from proofmass.runner.targets.machine_code import load_module
        from proofmass.runner.targets.native import CompiledPlan

        assert self._prepared is not None
        written, module = self._prepared
        self._compiled = CompiledPlan(self.plan, written, load_module(module, _go_on))
        self.ended.set()

    def _begin(self, work: Callable[[], None]) -> None:
        def done() -> None:
            try:
                work()
            except _LeavingError:
                return
            except BaseException as error:  # which `result` raises where the run is
                self._failed = error
                self.ended.set()
                self.looked.set()

        _stop_at_exit()
        threading.Thread(target=done, name="proofmass compiling", daemon=True).start()


def _go_on() -> None:
    """Go on with the work, unless the process is about to end."""
    if _leaving.is_set():
        raise _LeavingError


@cache
def _stop_at_exit() -> None:
    """Have LLVM left alone before it is taken down, once in a process."""
    atexit.register(_leave)


def _leave() -> None:
    """Wait for the step that LLVM is at; a thread that writes a program is in Python, which stops it by itself."""
    _leaving.set()
    AT_WORK.acquire()  # for good
