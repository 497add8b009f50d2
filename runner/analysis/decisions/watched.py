"""Inputs of quantisers of one bit, and the levels they choose, in two runs with different noise.

Where a level is an output of its block the runs are in machine code, and long. Others are watched
in plain Python.
"""

from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.analysis.decisions.compiled_decisions import (
    Decisions,
    KeptRuns,
    TwoRuns,
    compiled_runs,
    level_port,
)
from proofmass.runner.derivatives.dual_functions import LEVELS, compared, with_functions
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.part import PartInterpreter

DECISIONS, SETTLING = 16_384, 2_048  # of a quantiser that are counted, and before them
_MOST_CALLS = 4_000_000  # of functions of blocks
_FEW = 32  # decisions that show how many quantisers a block has

Records = Mapping[str, list[TwoRuns]]  # of each block those of its quantisers


def recorded(
    plan: Plan, begin: Memory, upstream: AbstractSet[str], deciding: AbstractSet[str], span: int, kept: KeptRuns
) -> Records:
    """Return the decisions of quantisers of one bit among some blocks; raises `TickError` if a run fails.

    In machine code the runs last for a `span` of base ticks, if that is not too few decisions, or
    too many; other ticks find them `kept`.
    """
    seeds = plan.graph.seed, plan.graph.seed ^ 1
    few = Watched(plan, begin.copy(), upstream, deciding, seeds[0]).taken(_FEW, 0)
    if not few:
        return {}
    ports = {name: port for name in few if (port := level_port(type(plan.blocks[name]))) and len(few[name]) == 1}
    runs = compiled_runs(plan, begin.tick, upstream, ports, seeds, span, kept) if len(ports) == len(few) else None
    if runs is not None:
        return {name: [of] for name, of in runs.items()}
    pair = [Watched(plan, begin.copy(), upstream, few.keys(), s).taken(DECISIONS, SETTLING) for s in seeds]
    return {name: [*map(TwoRuns, pair[0][name], pair[1][name])] for name in pair[0]}


class Watched(PartInterpreter):
    """A run with noise that notes inputs of quantisers of one bit, and the levels they choose."""

    def __init__(
        self, plan: Plan, memory: Memory, upstream: AbstractSet[str], deciding: AbstractSet[str], seed: int
    ) -> None:
        self._deciding = deciding
        self._several: dict[str, list[list[tuple[float, float]]]] = {}
        self._seen: dict[str, tuple[int, list[float]]] = {}
        super().__init__(plan, seed, memory, upstream)

    def taken(self, count: int, settling: int) -> dict[str, list[Decisions]]:
        """Return input and level of each decision, a row each: of each block those of its quantisers of one bit."""
        common = max(self.filled.schedule.divisors[name] for name in self._deciding)
        self.advance(self._memory.tick + common, ())
        own = [self.filled.schedule.divisors[name] for name in self._several]
        if not own:  # all have more levels
            return {}
        calls = max(1, len(self._outputs) + len(self._updates))
        ticks = min((count + settling) * max(own), _MOST_CALLS // calls)
        first = ticks * settling // (count + settling)
        self.advance(self._memory.tick + first, ())
        for several in self._several.values():
            for decisions in several:
                decisions.clear()
        self.advance(self._memory.tick + ticks - first, ())
        return {n: [_decisions(pairs) for pairs in several if pairs] for n, several in self._several.items()}

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        if self._owner not in self._deciding:
            return super()._callable(block, behaviour)
        return with_functions(behaviour.function, {rule: self._noting(self._owner, rule) for rule in LEVELS})

    def _noting(self, owner: str, rule: Callable[..., Any]) -> Callable[[Any, Any], Any]:
        def decide(first: Any, second: Any) -> Any:
            level, value = rule(first, second), compared(rule, first, second)
            if value is second or second == 1.0:
                self._note(owner, value, float(level))
            return level

        return decide

    def _note(self, owner: str, value: float, level: float) -> None:
        tick, known = self._seen.get(owner, (-1, []))
        if tick != self._memory.tick:
            known = []
            self._seen[owner] = self._memory.tick, known
        if value in known:
            return
        known.append(value)
        several = self._several.setdefault(owner, [])
        if len(several) < len(known):
            several.append([])
        several[len(known) - 1].append((value, level))


def _decisions(pairs: list[tuple[float, float]]) -> Decisions:
    values, levels = np.array(pairs).T
    return Decisions(values, levels, ())
