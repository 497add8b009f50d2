"""Ticks of blocks whose parameters are balls, with dual numbers on them for first and second derivatives."""

import copy
import types
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import flint

from proofmass.graphs.model.graph import split
from proofmass.runner.derivatives.ball import Ball, UndecidedError
from proofmass.runner.derivatives.dual import PARAMETERS, Dual, dual
from proofmass.runner.derivatives.dual_groups import DualAdvance
from proofmass.runner.derivatives.dual_plan import dual_constants, dual_start
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.plan.bindings import Binding, Time
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance
from proofmass.runner.reference.interpret import TickError

FIRST, SECOND = PARAMETERS, PARAMETERS - 1  # levels of the first and of the second derivative by coordinates
VARIED = -1  # direction of all that varies, so that converters do not round it


def coordinate(value: Any, number: int) -> Any:
    """Return a ball or number as the coordinate of a number, with its first and second derivative."""
    return dual(dual(value, {number: 1.0}, SECOND), {number: 1.0}, FIRST)


def varied(value: Any) -> Any:
    """Return a parameter with a direction: what varies is never rounded by a converter."""
    return value if isinstance(value, Dual) else dual(value, {VARIED: 1.0}, FIRST)


class BallTicks(DualTicks):
    """Ticks whose numbers may be balls: no group is moved by the matrices of a run, which are rounded, nor is time."""

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        return DualAdvance(plan, solver.group, False)

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

    `parameters` are named `"block.parameter"`.
    """
    moved: dict[str, dict[str, Any]] = {}
    for name, value in parameters.items():
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
