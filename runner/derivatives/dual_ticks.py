"""Ticks of a graph in dual numbers: the reference engine, with the blocks' functions made to take them.

Only what the wanted outputs depend on is run. Noise is zero.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from math import isfinite
from typing import Any

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.checks.schedule import AlgebraicLoop, ConstantsOf
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual import NO_SLOPE, SIGNALS, dual, plain, slopes_of, value_of, with_errors
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.dual_groups import DualAdvance, HeldAdvance, IntegratedAdvance, solve_dual
from proofmass.runner.derivatives.dual_plan import dual_constants, dual_parameters, is_finite
from proofmass.runner.plan.bindings import Binding, Deviate
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance
from proofmass.runner.reference.interpret import Interpreter, TickError

LastingPlace = tuple[str, Any, int]  # "state", "constant", "buffer" or "wire", whose it is, and its number there


class DualTicks(Interpreter):
    """Ticks that add `inputs` to what some wires carry, or replace it at a cut."""

    _solve_loop = staticmethod(solve_dual)

    def __init__(
        self,
        plan: Plan,
        memory: Memory,
        blocks: AbstractSet[str],
        inputs: Sequence[Endpoint],
        outputs: Sequence[Endpoint],
        cut: bool,
        by_parameters: bool,
        integrated: bool = False,
    ) -> None:
        for loop in plan.schedule.loops:
            if not set(inputs).isdisjoint(loop.nodes):
                raise plan.graph.placed(_within(loop)).error
        self._inputs, self._watched, self._cut, self._by_parameters = inputs, outputs, cut, by_parameters
        self._blocks = blocks
        self._injections = Counter[Endpoint]()
        self.recorded: dict[Endpoint, list[Any]] = {node: [] for node in outputs}
        self.injected: list[tuple[str, str, int]] = []  # in their order, which is that of time
        self.sources: list[tuple[str, str, int]] = []  # of noise, where it is not zero
        self.quantised: dict[tuple[str, str, int], Any] = {}  # what erring quantisers get
        self.drops: dict[tuple[str, str, int], Drop] = {}  # of these in fixed point
        super().__init__(replace(plan, solvers=(), probes=()), seed=0, memory=memory)
        self._advances = [
            self._advance(plan, solver, integrated) for solver in plan.solvers if blocks & set(solver.group.blocks)
        ]
        self._outputs = [
            (step, beat, compute if isinstance(step, ConstantsOf) else self._wired(step, compute))
            for step, beat, compute in self._outputs
            if step[0] in blocks
        ]
        self._updates = [update for update in self._updates if update[0] in blocks]
        self._folds = [fold for fold in self._folds if fold[0] in blocks]

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        if solver.exact and not solver.renewed and not solver.group.ramps and not self._by_parameters:
            return HeldAdvance(plan, solver)
        if integrated and not solver.exact and not solver.group.ramps:
            return IntegratedAdvance(plan, solver, self._by_parameters)
        return DualAdvance(plan, solver.group, self._by_parameters)

    def _wired(self, node: Endpoint, step: Callable[[int], Any]) -> Callable[[int], Any]:
        """Return the step of a wire: its value is recorded, and the input is added."""
        if node not in self._inputs and node not in self._watched:
            return step

        def compute(tick: int) -> Any:
            value = step(tick)
            if node in self._watched:
                self.recorded[node].append(value)
            if node not in self._inputs:
                return value
            key = (*node, self._injections[node])
            self._injections[node] += 1
            self.injected.append(key)
            return (value_of(value, SIGNALS) if self._cut else value) + dual(0.0, {key: 1.0}, SIGNALS)

        return compute

    def _counted(self, name: str, function: str) -> Callable[..., Any]:
        """Return a function of a digital block: no counter shows saturation, so a limit has the slope of a limit."""
        reference: Callable[..., Any] = self.filled.digital[name].steps[function].reference

        def call(*arguments: Any) -> Any:
            with with_errors(lambda value, drop: self._drop(name, value, drop)):
                return reference(*arguments)

        return call

    def _drop(self, owner: str, value: Any, drop: Drop) -> Any:
        """Return a whole number of a block, in steps, with the error of what it drops: none where noise is zero."""
        return value

    def _callable(self, block: Block, behaviour: Behaviour) -> Callable[..., Any]:
        return for_duals(behaviour.function)

    def _finite(self, value: Any) -> bool:
        values = value if isinstance(value, list | tuple) else [value]
        if not all(is_finite(plain(v)) for v in values):
            return False
        for entry in values:
            for slope in slopes_of(entry, SIGNALS).values():
                if not (isfinite(slope) if type(slope) is float else is_finite(plain(slope))):
                    raise TickError(self._at, self._memory.tick, NO_SLOPE)
        return True

    def _driven(self, name: str) -> Callable[[int], Any]:
        block, drivers, wires = self.filled.blocks[name], self.filled.schedule.drivers, self._memory.wires
        parameters = dual_parameters(self.filled, name, self._by_parameters)
        driven = [parameter for parameter in type(block).parameters if (name, parameter) in drivers]
        period = self.filled.block_period(name)

        def compute(tick: int) -> Any:
            vars(parameters).update({parameter: wires[drivers[name, parameter]] for parameter in driven})
            return dual_constants(block, parameters, period)

        return compute

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        if isinstance(binding, Deviate):
            return lambda tick: 0.0
        return super()._getter(binding)

    def replace_lasting(self, transform: Callable[[LastingPlace, Any], Any]) -> None:
        """Replace every number of the blocks that lasts to the next tick, by its place."""
        memory = self._memory
        for what, table in (("state", memory.states), ("constant", self._constants)):
            for name in self._blocks:
                values = table[name]
                if isinstance(values, tuple):  # skips blocks without state, and constants that each tick makes anew
                    moved = [transform((what, name, i), value) for i, value in enumerate(values)]
                    table[name] = type(values)(*moved)
        for node, held in memory.of_blocks().items():
            if node[0] in self._blocks and isinstance(held, list):
                held[:] = [transform(("buffer", node, i), value) for i, value in enumerate(held)]
        for node, wire in memory.wires.items():
            if node[0] not in self._blocks:
                continue
            if isinstance(wire, list):
                memory.wires[node] = [transform(("wire", node, i), value) for i, value in enumerate(wire)]
            else:
                memory.wires[node] = transform(("wire", node, 0), wire)


def _within(loop: AlgebraicLoop) -> Problem:
    return Problem(
        message="lies in a loop that Newton's method solves: its value follows from the others",
        got=", ".join(map(".".join, loop.nodes)),
        expected="an output that is not solved together with others",
        hint=f"open the loop elsewhere, or put a UnitDelay behind {'.'.join(loop.tears[0])}",
        path=("integration", "algebraic_loops"),
    )
