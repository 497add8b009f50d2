"""Loops among continuous blocks, opened at wires between them: a linear system in continuous time.

    x' = A x + B u,   y = C x + D u

u are the signals at the readers of the wires, y those of their sources; A, B, C and D are the exact
derivatives of the functions of the group at the operating point. Signals from discrete blocks are
held: loops through them are open.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem, problem_of_output
from proofmass.graphs.model.digraph import reached
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.map_blocks import not_linear, upstream_of
from proofmass.runner.analysis.linearisation.map_changes import LOOKS
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.orbit import FROZEN, LONGEST_ORBIT, STARTS_UP, WAITED
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, PointSlopes, with_slopes
from proofmass.runner.analysis.linearisation.waiting import Waiting, switch_note
from proofmass.runner.continuous.algebraic import NoSolutionError
from proofmass.runner.derivatives.dual import NO_SLOPE, PARAMETERS, SIGNALS, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_groups import DualStages
from proofmass.runner.derivatives.dual_plan import differentiated
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import WireBinding
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.stages import StageContext
from proofmass.runner.reference.interpret import TickError

_MOVED = 1e-6  # relative change of a linearisation from one tick to the next that gets a note
_AT_ANOTHER_TIME = "linearise at another time"


def analog_group(plan: Plan, node: Endpoint) -> Group | None:
    """Return the group within which a wire is read; None if only discrete blocks read it."""
    for solver in plan.solvers:
        inside = set(solver.group.nodes)
        readers = {(name, "") for (name, _), source in plan.schedule.drivers.items() if source == node}
        members = {name for name, _ in readers} & set(solver.group.members)
        if node in inside and members:
            return solver.group
    return None


def analog_map(plan: Plan, onward: Onward, group: Group, nodes: Sequence[Endpoint]) -> PeriodMap:
    """Return the loop opened at wires within a group, about a state of the graph; its `period` is 0.

    Raises `ModelError` if the group cannot be linearised, or a wire cannot be cut.
    """
    solved = [(node, loop.tears[0]) for loop in group.loops for node in nodes if node in loop.nodes]
    if solved:
        raise ModelError([plan.graph.placed(_within(node, tear)) for node, tear in solved])
    tick = onward.begin.tick
    analog = analog_map_at(plan, group, nodes, onward.begin)
    later = [analog_map_at(plan, group, nodes, onward.at(tick + look)) for look in LOOKS]
    change = _change(analog, later[0])
    moving = f"the operating point moves: the linearisation changes by {100.0 * change:.1g} % in a tick"
    notes = [moving if tick else STARTS_UP] if change > _MOVED else []
    switched = _switched(plan, onward, group, nodes, analog)
    if switched is not None:
        later.append(switched)
        notes.append(switch_note(switched.time - analog.time))
    behind = set[str]().union(*(reached(plan.readers, [name]) - {name} for name, _ in nodes))
    held = sorted(".".join(wire) for wire in group.inputs if wire[0] in behind)
    if held:
        notes.append(f"loops through discrete blocks are open here: held are {', '.join(held)}")
    return replace(analog, notes=tuple(notes), later=tuple(later))


def _change(first: PeriodMap, second: PeriodMap) -> float:
    """Return the largest relative change of an entry."""
    size = np.maximum(np.abs(first.matrix[:, :-1]), np.abs(second.matrix[:, :-1]))
    moved = np.abs(first.matrix - second.matrix)[:, :-1]
    return float(np.max(np.divide(moved, size, out=np.zeros_like(size), where=size > 0.0), initial=0.0))


def _switched(
    plan: Plan, onward: Onward, group: Group, nodes: Sequence[Endpoint], analog: PeriodMap
) -> PeriodMap | None:
    """Return the loop after a switch that waits, if it changes it within the time in which that would matter."""
    upstream, moving = Ends(tuple(nodes), tuple(nodes)).blocks(plan)
    ticks = Ends(tuple(nodes), tuple(nodes), everything=True).common_period(plan)

    def after(periods: int) -> Memory:
        return onward.at(onward.begin.tick + periods * ticks)

    horizon = int(min(LONGEST_ORBIT // ticks, _matters(analog) / (ticks * plan.period)))
    for periods in Waiting(onward, upstream, moving, ticks, nodes).changes(after, horizon):
        later = analog_map_at(plan, group, nodes, after(periods))
        if periods > WAITED and _change(analog, later) > FROZEN:
            return later
    return None


def _matters(analog: PeriodMap) -> float:
    """Return the seconds within which a change of a loop matters: turns at its lowest crossover."""
    system = OpenLoop(analog.between(), continuous=True)
    rates = np.abs(system.poles)
    rates = rates[rates > 0.0]
    if not len(rates):
        return math.inf
    w = np.geomspace(1e-3 * rates.min(), 1e3 * rates.max(), 900)
    above = np.linalg.norm(system.lifted(w), 2, axis=(1, 2)) > 1.0
    crossed = w[:-1][above[:-1] != above[1:]]
    return float(1.0 / (FROZEN * (crossed[0] if len(crossed) else rates.min())))


class _Instant(DualTicks):
    """The reference engine at the start of a tick, once its outputs are known."""

    def known(self) -> tuple[Mapping[str, Any], Mapping[Endpoint, Any]]:
        self._compute(self._memory.tick)
        return self._constants, self._memory.wires


class _CutStages(DualStages):
    """The functions of a group with some wires cut, a column for each: `back` are the signals of their sources."""

    def __init__(self, plan: Plan, group: Group, columns: Mapping[Endpoint, int], by_parameters: bool) -> None:
        super().__init__(plan, group, by_parameters)
        self._columns = {self._place(WireBinding(node)): column for node, column in columns.items()}
        self.back: dict[int, Any] = dict.fromkeys(columns.values(), 0.0)

    def _called(self, call: Any, known: list[Any]) -> Any:
        value = super()._called(call, known)
        column = self._columns.get(call.result)
        if column is None:
            return value
        self.back[column] = value
        return value_of(value, SIGNALS) + dual(0.0, {column: 1.0}, SIGNALS)


def analog_map_at(
    plan: Plan,
    group: Group,
    nodes: Sequence[Endpoint],
    memory: Memory,
    by_parameters: bool = False,
    point_slopes: PointSlopes | None = None,
) -> PeriodMap:
    """Return the loop opened at wires within a group, about a memory; options as `period_map`."""
    begin = memory
    if by_parameters:
        plan = differentiated(plan)
        begin = with_slopes(memory, plan, point_slopes, NO_RINGS)
    try:
        moving, rows = analog_rates(plan, group, nodes, begin, by_parameters)
    except TickError as error:
        raise plan.graph.placed(not_linear(error.at, str(error.value), _AT_ANOTHER_TIME)).error from error
    columns, time = (*moving, *range(len(group.states), len(group.states) + len(nodes))), memory.tick * plan.period
    matrix = np.zeros((len(rows), len(moving) + len(nodes) + 1))
    by_name: dict[str, Array] = {}
    for row, value in enumerate(rows):
        slopes = slopes_of(value, SIGNALS)
        entries = [*(slopes.get(j, 0.0) for j in columns), value_of(value, SIGNALS)]
        matrix[row] = [plain(entry) for entry in entries]
        for column, entry in enumerate(entries):
            for name, slope in slopes_of(entry, PARAMETERS).items():
                by_name.setdefault(str(name), np.zeros_like(matrix))[row, column] = slope
        if not np.isfinite(matrix[row]).all():
            state = row < len(moving)
            whose = group.states[moving[row]][0] + ".derivative" if state else ".".join(nodes[row - len(moving)])
            raise plan.graph.placed(not_linear(whose, NO_SLOPE, _AT_ANOTHER_TIME)).error
    undefined = tuple(sorted(name for name, slope in by_name.items() if not np.isfinite(slope).all()))
    return PeriodMap(
        tuple((*group.states[j], -1) for j in moving),
        tuple((*node, 0) for node in nodes),
        tuple((*node, 0) for node in nodes),
        matrix,
        {name: slope for name, slope in by_name.items() if name not in undefined},
        0.0,
        tick=memory.tick,
        time=time,
        undefined=undefined,
    )


def analog_rates(
    plan: Plan, group: Group, nodes: Sequence[Endpoint], memory: Memory, by_parameters: bool = False
) -> tuple[list[int], list[Any]]:
    """Return the numbers of the states that move, their rates and the signals of the wires at the
    start of a tick.

    The rates have slopes by the states, and by what is added at the readers of the wires, numbered
    after all states. Raises `TickError` where they have none.
    """
    n, time = len(group.states), memory.tick * plan.period
    begin = memory.copy()
    upstream = upstream_of(plan, group.members)
    constants, wires = _Instant(replace(plan, solvers=()), begin, upstream, (), (), False, by_parameters).known()
    held = [getattr(begin.states[block], field) for block, field in group.states]
    moving = [j for j, kind in enumerate(group.kinds) if kind is float]
    seeded = [value + dual(0.0, {j: 1.0}, SIGNALS) if j in moving else value for j, value in enumerate(held)]
    columns = {node: n + i for i, node in enumerate(nodes)}
    stages, rates = _CutStages(plan, group, columns, by_parameters), [0.0] * n
    inputs = [wires[wire] for wire in group.inputs]
    still, guesses = [0.0] * len(group.ramps), [plain(wires[tear]) for tear in group.guesses]
    try:
        stages.rates(StageContext(constants, inputs, still, guesses, time), time, seeded, rates)
        if stages.unsolved:
            raise NoSolutionError(stages.unsolved)
    except (TypeError, ValueError, AttributeError, ArithmeticError, NoSolutionError) as error:
        raise TickError(stages.at, memory.tick, error) from error
    return moving, [*(rates[j] for j in moving), *stages.back.values()]


def _within(node: Endpoint, tear: Endpoint) -> Problem:
    return problem_of_output(
        node,
        message=f"{'.'.join(node)} lies in a loop that Newton's method solves: its value follows from the others",
        expected="an output that is not solved together with others",
        hint=f"open the loop elsewhere, or put a LowPass after {'.'.join(tear)}",
    )
