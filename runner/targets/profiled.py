"""Machine code of a tick with a clock in it, for processors that have one that counts without a call: x86-64."""

import platform
from collections.abc import Callable
from typing import Any

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.memory import Memory, Rows, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.timed_tick import HOLD, READ, write_timed_tick
from proofmass.runner.targets.llvm_functions import declared, symbol_of
from proofmass.runner.targets.llvm_text import llvm_text
from proofmass.runner.targets.machine_code import LlvmModule, key_of, load_module
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan, settings

# rdtsc between two fences: the first waits for all before it, the second holds back what follows
_READ = """declare void @llvm.x86.sse2.lfence()
declare i64 @llvm.readcyclecounter()
define internal i64 @{symbol}() alwaysinline {{
call void @llvm.x86.sse2.lfence()
%now = call i64 @llvm.readcyclecounter()
call void @llvm.x86.sse2.lfence()
ret i64 %now
}}"""
_HOLD = """define internal {kind} @{symbol}({kind} %value) alwaysinline {{
%held = call {kind} asm sideeffect "", "={register},0"({kind} %value)
ret {kind} %held
}}"""
_HOLD_TRUTH = """define internal i1 @{symbol}(i1 %value) alwaysinline {{
%byte = zext i1 %value to i64
%held = call i64 asm sideeffect "", "=r,0"(i64 %byte)
%truth = trunc i64 %held to i1
ret i1 %truth
}}"""
_DEFINED = {
    READ: _READ.format(symbol=symbol_of(READ)),
    **{
        hold: _HOLD_TRUTH.format(symbol=symbol_of(hold))
        if kind.name == "TRUTH"
        else _HOLD.format(symbol=symbol_of(hold), kind=text, register=register)
        for (kind, hold), (text, register) in zip(
            HOLD.items(), (("double", "x"), ("i64", "r"), ("i1", "r")), strict=True
        )
    },
}


def can_profile() -> bool:
    """Return whether the processor at hand has the clock."""
    return platform.machine().lower() in ("x86_64", "amd64")


class ProfiledLoop:
    """A run of a plan whose parts are timed; what it computes is what the plain loop does."""

    def __init__(self, plan: Plan, seed: int) -> None:
        written, self.parts = write_timed_tick(plan)
        text = llvm_text(written.program)
        for external, definition in _DEFINED.items():
            text = text.replace(declared(external), definition)
        made, defined = settings(written), frozenset(map(symbol_of, _DEFINED))
        module = LlvmModule(written.program, text, made, key_of(text, made), defined=defined)
        loop: Callable[..., Any] = load_module(module)
        self._plan, self._seed, self._compiled = plan, seed, CompiledPlan(plan, written, loop)
        self.restart()

    def restart(self) -> None:
        """Start again at tick 0."""
        self._run = CompiledLoop(self._plan, self._seed, 0, start(self._plan), self._compiled)

    @property
    def tick(self) -> int:
        """The tick that comes next."""
        return self._run.tick

    def advance(self, last: int, rows: Rows) -> AnyArray:
        """Run up to, not including, a tick; return the counts of the clock in each part."""
        times = np.zeros(len(self.parts), dtype=np.int64)
        self._run.advance(last, [*rows, times])
        return times

    def memory(self) -> Memory:
        """Return the memory of this moment."""
        return self._run.memory()
