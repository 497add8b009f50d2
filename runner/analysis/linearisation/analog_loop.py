"""Loops among continuous blocks, opened at a wire between them: a linear system in continuous time.

    x' = A x + B u,   y = C x + D u

u is the signal at the readers of the wire, y the signal of its source; A, B, C and D are the exact derivatives of the
functions of the group at the operating point. Signals from discrete blocks are held: loops through them are open.
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.orbit import FROZEN, LONGEST_ORBIT, WAITED
from proofmass.runner.analysis.linearisation.period_map import PeriodMap, blocks_of_map, common_period, plan_graph
from proofmass.runner.analysis.linearisation.waiting import Waiting, switch_note
from proofmass.runner.continuous.algebraic import NoSolutionError
from proofmass.runner.derivatives.dual import NO_SLOPE, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_groups import DualStages
from proofmass.runner.derivatives.dual_plan import SIGNALS
from proofmass.runner.plan.bindings import WireBinding
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.stages import StageContext
from proofmass.runner.reference.interpret import Outputs, TickError

_MOVED = 1e-6  # relative change of a linearisation from one tick to the next that gets a note


def analog_group(plan: Plan, node: Endpoint) -> Group | None:
    """Return the group within which a wire is read; None if only discrete blocks read it."""
    for solver in plan.solvers:
        inside = set(solver.group.nodes)
        readers = {(name, "") for (name, _), source in plan.schedule.drivers.items() if source == node}
        members = {name for name, _ in readers} & set(solver.group.members)
        if node in inside and members:
            return solver.group
    return None


def analog_map(plan: Plan, course: Course, group: Group, node: Endpoint, tick: int) -> PeriodMap:
    """Return the loop opened at a wire within a group, about the state of the graph in a tick; its `period` is 0.

    Raises `ModelError` if the group cannot be linearised, or the wire cannot be cut.
    """
    for loop in group.loops:
        if node in loop.nodes:
            raise ModelError([plan.graph.placed(_within(node, loop.tears[0]))])
    memory = course.at(tick)
    analog = _linearised(plan, group, node, memory)
    later = _linearised(plan, group, node, course.from_memory(memory).to(tick + 1))
    change = _change(analog, later)
    notes = [_moving(tick, change)] if change > _MOVED else []
    notes += _switched(plan, course, group, node, analog, memory)
    behind = _downstream(plan, node)
    held = sorted(".".join(wire) for wire in group.inputs if wire[0] in behind)
    if held:
        notes.append(f"loops through discrete blocks are open here: held are {', '.join(held)}")
    return replace(analog, notes=tuple(notes))


def _change(first: PeriodMap, second: PeriodMap) -> float:
    """Return the largest relative change of an entry."""
    size = np.maximum(np.abs(first.matrix[:, :-1]), np.abs(second.matrix[:, :-1]))
    moved = np.abs(first.matrix - second.matrix)[:, :-1]
    return float(np.max(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0), initial=0.0))


def _switched(plan: Plan, course: Course, group: Group, node: Endpoint, analog: PeriodMap, memory: Memory) -> list[str]:
    """Return a note on a switch that waits, if it changes the loop within the time in which that would matter."""
    upstream, moving = blocks_of_map(plan, [node], [node], False)
    ticks = common_period(plan, [node], [node], everything=True)
    run, known = course.from_memory(memory), {0: memory}

    def after(periods: int) -> Memory:
        if periods not in known:
            tick = memory.tick + periods * ticks
            ahead = run if run.tick <= tick else course.from_memory(memory)
            known[periods] = ahead.to(tick)
        return known[periods]

    horizon = int(min(LONGEST_ORBIT // ticks, _matters(analog) / (ticks * plan.period)))
    for periods in Waiting(course.plan, upstream, moving, memory, ticks).changes(after, horizon):
        later = _linearised(plan, group, node, after(periods))
        if periods > WAITED and _change(analog, later) > FROZEN:
            return [switch_note(periods * ticks * plan.period)]
    return []


def _matters(analog: PeriodMap) -> float:
    """Return the seconds within which a change of a loop matters: some turns at its lowest crossover."""
    system = OpenLoop(analog.between(), continuous=True)
    rates = np.abs(system.poles)
    rates = rates[rates > 0.0]
    if not len(rates):
        return math.inf
    w = np.geomspace(1e-3 * rates.min(), 1e3 * rates.max(), 900)
    above = np.abs(system.response(w)) > 1.0
    crossed = w[:-1][above[:-1] != above[1:]]
    return float(1.0 / (FROZEN * (crossed[0] if len(crossed) else rates.min())))


class _Instant(Outputs):
    """The reference engine at the start of a tick, once its outputs are known."""

    def known(self) -> tuple[Mapping[str, Any], Mapping[Endpoint, Any]]:
        self._compute(self._memory.tick)
        return self._constants, self._memory.wires


class _CutStages(DualStages):
    """The functions of a group with one wire cut: `back` is the signal of its source."""

    def __init__(self, plan: Plan, group: Group, node: Endpoint, column: int) -> None:
        super().__init__(plan, group, by_parameters=False)
        self._cut, self._column = self._place(WireBinding(node)), column
        self.back: Any = 0.0

    def _called(self, call: Any, known: list[Any]) -> Any:
        value = super()._called(call, known)
        if call.result != self._cut:
            return value
        self.back = value
        return plain(value) + dual(0.0, {self._column: 1.0}, SIGNALS)


def _linearised(plan: Plan, group: Group, node: Endpoint, memory: Memory) -> PeriodMap:
    n, time = len(group.states), memory.tick * plan.period
    try:
        constants, wires = _Instant(plan, plan.graph.seed, 0, memory.copy()).known()
    except TickError as error:
        raise ModelError([plan.graph.placed(_not_linear(error.at, str(error.value)))]) from error
    held = [float(getattr(memory.states[block], field)) for block, field in group.states]
    moving = [j for j, kind in enumerate(group.kinds) if kind is float]
    seeded = [value + dual(0.0, {j: 1.0}, SIGNALS) if j in moving else value for j, value in enumerate(held)]
    stages, rates = _CutStages(plan, group, node, n), [0.0] * n
    inputs = [wires[wire] for wire in group.inputs]
    still, guesses = [0.0] * len(group.ramps), [plain(wires[tear]) for tear in group.guesses]
    try:
        stages.rates(StageContext(constants, inputs, still, guesses, time), time, seeded, rates)
        if stages.unsolved:
            raise NoSolutionError(stages.unsolved)
    except (TypeError, ValueError, AttributeError, ArithmeticError, NoSolutionError) as error:
        raise ModelError([plan.graph.placed(_not_linear(stages.at, str(error)))]) from error
    rows = [*(rates[j] for j in moving), stages.back]
    matrix = np.zeros((len(rows), len(moving) + 2))
    for row, value in enumerate(rows):
        slopes = slopes_of(value, SIGNALS)
        matrix[row] = [*(plain(slopes.get(j, 0.0)) for j in (*moving, n)), plain(value_of(value, SIGNALS))]
        if not np.isfinite(matrix[row]).all():
            at = f"{group.states[moving[row]][0]}.derivative" if row < len(moving) else ".".join(node)
            raise ModelError([plan.graph.placed(_not_linear(at, NO_SLOPE))])
    states = tuple((*group.states[j], -1) for j in moving)
    return PeriodMap(states, ((*node, 0),), ((*node, 0),), matrix, {}, 0.0, tick=memory.tick, time=time)


def _downstream(plan: Plan, node: Endpoint) -> set[str]:
    """Return the blocks that a wire acts on, directly or through others."""
    return reached(plan_graph(plan), [node[0]]) - {node[0]}


def _moving(tick: int, change: float) -> str:
    if tick == 0:
        return (
            'tick 0 is a start-up, and the loop changes afterwards: use --at settled, or a time, such as --at "0.1 s"'
        )
    return f"the operating point moves: the linearisation changes by {100.0 * change:.1g} % in a tick"


def _within(node: Endpoint, tear: Endpoint) -> Problem:
    signal = ".".join(node)
    return Problem(
        message=f"{signal} lies in a loop that Newton's method solves: its value follows from the others",
        key=signal,
        expected="an output that is not solved together with others",
        hint=f"open the loop elsewhere, or put a LowPass after {'.'.join(tear)}",
        path=("blocks", node[0]),
    )


def _not_linear(at: str, got: str) -> Problem:
    name, _, what = at.rpartition(".")
    return Problem(
        message=f"cannot be linearised: {what} has no derivative here",
        key=f"blocks.{name}",
        got=got,
        expected="arithmetic, comparisons and functions of math on values that signals change",
        hint="linearise at another time",
        path=("blocks", name),
    )
