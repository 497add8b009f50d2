"""A hand-over at a tick of one's choice: machine code that is ready when the test says so."""

import threading
from typing import Any

import numpy as np

from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.compiling import Compiling
from proofmass.runner.run.hand_over import HandOver
from proofmass.runner.targets.native import CompiledPlan


class ReadyAfter(Compiling):
    """Machine code that is made at once and ready after so many looks, each at the start of a chunk."""

    def __init__(self, compiled: CompiledPlan, looks: int) -> None:
        self.plan, self._compiled, self._failed = compiled.plan, compiled, None
        self.looked, self.ended = threading.Event(), _After(looks)
        self.looked.set()
        self.asked = 0

    def want(self) -> None:
        """Count how often it was wanted."""
        self.asked += 1


class _After(threading.Event):
    """An event that is set after so many looks, and is never waited for."""

    def __init__(self, looks: int) -> None:
        super().__init__()
        self._looks = looks

    def is_set(self) -> bool:
        """Whether it was looked at often enough."""
        self._looks -= 1
        return self._looks < 0

    def wait(self, timeout: float | None = None) -> bool:
        """Go on at once."""
        return False


def handed_over(compiled: CompiledPlan, ticks: tuple[int, ...], last: int) -> tuple[list[bytes], Memory]:
    """Rows and memory of a run whose chunks in plain Python end at `ticks`, and that machine code ends."""
    plan = compiled.plan
    engine = HandOver(plan, plan.graph.seed, 0, start(plan), ReadyAfter(compiled, len(ticks)), last, 1.0)
    found = run(engine, plan, (*ticks, last))
    assert engine.name == "compiled"
    assert engine.handed_over == (ticks[-1] if ticks else None)
    return found


def run(engine: Any, plan: Plan, ends: tuple[int, ...]) -> tuple[list[bytes], Memory]:
    """Rows of every probe, put together from chunks, and the memory behind."""
    parts: list[list[Any]] = [[] for _ in plan.probes]
    first = 0
    for end in ends:
        rows = [np.empty((probe.rows(first, end), *probe.shape), dtype=probe.dtype) for probe in plan.probes]
        assert engine.advance(end, rows)
        for part, new in zip(parts, rows, strict=True):
            part.append(new)
        first = end
    return [np.concatenate(part).tobytes() for part in parts], engine.memory()


def as_text(memory: Memory) -> str:
    """Everything that moves, every bit of it, whichever engine made it."""
    return repr((memory.tick, _exact(memory.states), _exact(memory.buffers), _exact(memory.wires), memory.overflows))


def _exact(value: Any) -> Any:
    if isinstance(value, dict):
        return sorted((str(key), _exact(held)) for key, held in value.items())
    if isinstance(value, list | tuple):
        return [_exact(held) for held in value]
    return float(value).hex() if isinstance(value, float) else int(value) if value is not None else None
