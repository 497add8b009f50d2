"""Ticks of blocks whose parameters are balls, or polynomials of them.

At rest, or on an orbit, continuous groups move by phi(A T) T f, with A and f where they are, which
is their exact step where they are linear. Elsewhere they move by P f for a regular P, so that they
rest where f is zero.
"""

import copy
import types
from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import replace
from typing import Any

import flint
import numpy as np

from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.derivatives.ball import Ball, UndecidedError, arb_of
from proofmass.runner.derivatives.dual import SIGNALS, plain, value_of
from proofmass.runner.derivatives.dual_groups import DualAdvance
from proofmass.runner.derivatives.dual_plan import dual_constants, dual_hold, dual_start
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import Binding, Tick, Time
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance, Moment
from proofmass.runner.reference.interpret import TickError


class BallTicks(DualTicks):
    """Ticks whose numbers may be balls: no group is moved by the matrices of a run, which are rounded, nor is time."""

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        linear = solver.exact and not (
            solver.group.guesses or solver.factors
        )  # a factor times a state is not linear in both
        return DualAdvance(plan, solver.group, False, linear)

    def _getter(self, binding: Binding) -> Callable[[int], Any]:
        base = self.filled.schedule.base_rate
        if isinstance(binding, Time):
            return lambda tick: Ball(flint.arb(tick * base.denominator) / base.numerator).widened()
        return super()._getter(binding)


def advanced(engine: DualTicks, tick: int) -> None:
    """Advance an engine in balls to a tick; raises `UndecidedError` where a block decides differently within them."""
    try:
        engine.advance(tick, ())
    except TickError as error:
        cause = error.__cause__ or error.value
        raise UndecidedError(f"{error.at}: {cause}") from error


def with_balls(plan: Plan, parameters: Mapping[str, Any]) -> Plan:
    """Return a plan whose blocks have other parameters, which may be balls, with all that follows from them.

    `parameters` are named `"block.parameter"`; places of what is remembered are among them, with a colon.
    """
    moved: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
        if ":" in name:
            continue
        owner, parameter = split(name)
        moved.setdefault(owner, {})[parameter] = value
    blocks, constants, starts, buffers = dict(plan.blocks), dict(plan.constants), dict(plan.starts), dict(plan.buffers)
    for name, values in moved.items():
        block = copy.copy(plan.blocks[name])
        vars(block).update(values)
        blocks[name] = block
        given = types.SimpleNamespace(**{p: getattr(block, p) for p in type(block).parameters})
        if not plan.is_driven(name):
            constants[name] = dual_constants(block, given, plan.block_period(name))
        if "start" in type(block).functions:
            starts[name], filled = dual_start(plan, name, given)
            buffers |= filled
    return replace(plan, blocks=blocks, constants=constants, starts=starts, buffers=buffers)


class RestTicks(BallTicks):
    """Ticks on from the operating point, of all that is at rest or comes round."""

    def __init__(
        self, plan: Plan, begin: Memory, blocks: AbstractSet[str], outputs: Sequence[Endpoint], steps: dict[int, Array]
    ) -> None:
        self._steps = steps
        super().__init__(plan, begin, blocks, (), outputs, False, False)

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        number = plan.solvers.index(solver)
        return _RestAdvance(plan, solver, self._steps, number)

    def _getter(self, binding: Binding) -> Any:
        return _counting if isinstance(binding, Tick) else super()._getter(binding)


def _counting(tick: int) -> Any:
    raise UndecidedError("it counts ticks, and has no point of rest")


class _RestAdvance(DualAdvance):
    """Moves the states of a group by its exact step where it is linear, and else by P f."""

    def __init__(self, plan: Plan, solver: Solver, steps: dict[int, Array], number: int) -> None:
        super().__init__(plan, solver.group, False)
        self._steps, self._number, self._exact = steps, number, solver.exact

    def moved(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        if self._exact:
            return super().moved(moment)
        group, states, wires = self.stages.group, moment.states, moment.wires
        now = [getattr(states[block], field) for block, field in group.states]
        point = [*now, *(wires[node] for node in group.inputs)]
        if self._number not in self._steps:
            self._steps[self._number] = self._step(moment, point)
        rates = self._rates(moment.constants, point, len(now), [], moment.time)
        rows = self._steps[self._number].tolist()
        moved = [
            x + sum((p * rate for p, rate in zip(row, rates, strict=True)), 0.0)
            for x, row in zip(now, rows, strict=True)
        ]
        kinds = zip(group.kinds, now, moved, strict=False)
        return self.stages.states([after if kind is float else before for kind, before, after in kinds])

    def _step(self, moment: Moment, point: Sequence[Any]) -> Array:
        """Return P, a regular matrix of doubles: near phi(A T) T."""
        a, _, _ = self._linear(moment, [value_of(value, SIGNALS) for value in point])
        near = [[float(arb_of(plain(value)).mid()) for value in row] for row in a]
        unit = [[float(i == j) for j in range(len(a))] for i in range(len(a))]
        step = np.array(dual_hold(near, unit, self.period)[1])
        regular: Any = flint.arb_mat(step.tolist()).det()
        return step if np.isfinite(step).all() and not regular.contains(0) else self.period * np.eye(len(a))
