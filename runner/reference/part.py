"""The reference engine for some blocks of a plan: all that they depend on must be among them."""

from collections.abc import Set as AbstractSet
from dataclasses import replace

from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import Interpreter


class PartInterpreter(Interpreter):
    """Ticks of some blocks, with the continuous groups that they are in."""

    def __init__(self, plan: Plan, seed: int, memory: Memory, blocks: AbstractSet[str]) -> None:
        solvers = tuple(solver for solver in plan.solvers if not blocks.isdisjoint(solver.group.blocks))
        super().__init__(replace(plan, solvers=solvers, probes=()), seed, memory=memory)
        self._outputs = [each for each in self._outputs if each[0][0] in blocks]
        self._updates = [update for update in self._updates if update[0] in blocks]
        self._folds = [fold for fold in self._folds if fold[0] in blocks]
