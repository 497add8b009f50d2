"""The operating point at which the loops of a graph have come to rest.

The graph runs for 1, 2, 4, 8, 16, 31, 59, ... of its common periods, 15/8 as long each time so that no periodic signal
can hide. It has settled when twice in a row no state of blocks in loops has changed by more than `TOLERANCE` of its
largest value, which leaves room for the dither of converters. A decaying mode has then decayed to the 3.5th power of
`TOLERANCE`, whatever its time constant and the length of a tick. Integers and switches are left out.

Loops that are unstable in tick 0 may still settle at a limit. They are given up if they are unstable three times in a
row, each time after growth by a million, or if they still move when the mode of tick 0 would have grown by 1e60.
"""

import math
from collections.abc import Iterator

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import loops
from proofmass.runner.analysis.linearisation.forward import Course, Progress
from proofmass.runner.analysis.linearisation.period_map import period_map, plan_graph
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

TOLERANCE = 1e-2
FEWEST, MOST = 64, 1 << 20  # base ticks
# Growth from which on an unstable mode counts, and at which the search ends.
GROWN, ENOUGH = math.log(1e6), math.log(1e60)
LONGEST_LOOK = 10_000  # base ticks of a period that is linearised on the way
Number = tuple[str, str, int]  # block, field or buffer, and index in the buffer


def settled_tick(course: Course, progress: Progress | None = None) -> int:
    """Return the base tick by which the loops have settled; raises `ModelError` that names what still moves."""
    plan = course.plan
    names = sorted(_in_loops(plan))
    ticks = math.lcm(*(plan.schedule.divisors[name] for name in names)) if names else 1
    memory, periods, still, got = start(plan), 0, 0, ""
    unstable = _Unstable(plan, names, ticks, memory)
    largest, before = dict[Number, float](), dict(_numbers(memory, names))
    while memory.tick < MOST:
        earlier, periods = memory.tick, periods * 15 // 8 + 1
        try:
            memory = course.at(ticks * periods, progress, MOST)
        except ModelError as error:
            raise ModelError([plan.graph.placed(_restless(error.problems[0].message))]) from error
        now = dict(_numbers(memory, names))
        largest = {key: max(largest.get(key, 0.0), abs(value)) for key, value in now.items()}
        change = {key: abs(value - before[key]) / (largest[key] or 1.0) for key, value in now.items()}
        worst = max(change, key=lambda key: change[key], default=None)
        still = still + 1 if worst is None or change[worst] <= TOLERANCE else 0
        if still >= 2 and memory.tick >= FEWEST:
            return memory.tick
        if worst is not None:
            what = f"{worst[0]}.{worst[1]}" + (f"[{worst[2]}]" if worst[2] >= 0 else "")
            share = f"{change[worst]:.2g} of its largest value"
            got = f"{what} moves by {share}, from {earlier:,} ticks to {memory.tick:,}"
            if not still and unstable.again(memory):
                raise ModelError([plan.graph.placed(unstable.told(got))])
        before = now
    raise ModelError([plan.graph.placed(_restless(got))])


class _Unstable:
    """Watches whether the loops, linearised on the way, are unstable again and again."""

    def __init__(self, plan: Plan, names: list[str], ticks: int, memory: Memory) -> None:
        self._plan, self._names, self._ticks, self._times = plan, names, ticks, 0
        self._first = self._largest_pole(memory) if names and ticks <= LONGEST_LOOK else 0.0

    def again(self, memory: Memory) -> bool:
        """Linearise again; return whether to give up."""
        grown = self._grown(self._first, memory.tick)
        if grown > GROWN:
            pole = self._largest_pole(memory)
            self._times = self._times + 1 if self._grown(pole, memory.tick) > GROWN else 0
        return self._times >= 3 or grown > ENOUGH

    def _grown(self, pole: float, ticks: int) -> float:
        """Return the logarithm of the growth of a pole in some ticks."""
        return math.log(max(pole, 1.0)) * ticks / self._ticks

    def told(self, got: str) -> Problem:
        """Return the problem to report."""
        period = f"{self._ticks * self._plan.period:.3g} s"
        return Problem(
            message="the loops do not settle: they are unstable",
            key="at",
            got=f"a mode that grows by {self._first:.6g} in {period} at the start; {got}",
            expected="closed-loop poles inside the unit circle",
            hint="without --at the margins are those of tick 0; they show how far the loops are from being stable",
        )

    def _largest_pole(self, memory: Memory) -> float:
        """Return the size of the largest closed-loop pole over the loops' common period; 0 if it is not known."""
        ports = [(name, _first_number(self._plan, name)) for name in self._names]
        outputs = [(name, port) for name, port in ports if port]
        try:
            a = period_map(self._plan, (), outputs, everything=True, memory=memory.copy()).parts()[0]
        except ModelError:
            return 0.0
        poles = np.abs(np.linalg.eigvals(a)) if len(a) and np.isfinite(a).all() else np.zeros(1)
        return float(poles.max())


def _first_number(plan: Plan, name: str) -> str:
    """Return an output of a block that is one number; empty if it has none."""
    ports = type(plan.blocks[name]).outputs.items()
    return next((port for port, declared in ports if not declared.shape and declared.dtype is not bool), "")


def _in_loops(plan: Plan) -> set[str]:
    """Return the blocks that act on themselves, directly or through others."""
    return set[str]().union(*loops(plan_graph(plan)))


def _numbers(memory: Memory, names: list[str]) -> Iterator[tuple[Number, float]]:
    """Yield the real numbers in the states of blocks."""
    for name in names:
        state = memory.states[name]
        if state is not None:
            kinds = type(state).__annotations__
            yield from (((name, f, -1), getattr(state, f)) for f in state._fields if kinds[f] is float)
    for (name, buffer), held in memory.of_blocks().items():
        if name in names:
            yield from (((name, buffer, i), float(v)) for i, v in enumerate(held) if isinstance(v, float))


def _restless(got: str) -> Problem:
    return Problem(
        message="the loops do not settle",
        key="at",
        got=got,
        expected=f"{TOLERANCE:g} at most, in {MOST:,} base ticks",
        hint="of carriers that fit the rate take --at periodic; else remove signals that keep changing, or name a time,"
        " such as 20 ms",
    )
