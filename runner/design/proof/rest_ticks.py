"""Ticks in balls at rest or on an orbit, and sources that are constant from a time on or come round.

Continuous groups move by phi(A T) T f, with A and f where they are, which is their exact step where they are linear.
Elsewhere they move by P f for a regular P, so that they rest where f is zero.

A sine of frequency f is the same after n / f seconds, and pulses after n repetitions. So they come round after the
periods of the schedule of which a whole number fits these, of rates, frequencies and repetitions as they are written.
"""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction
from typing import Any

import flint
import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.sources.pulse import Pulse
from proofmass.blocks.sources.sine import Sine
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.ball import UndecidedError, arb_of, ball
from proofmass.runner.derivatives.dual import dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.dual_groups import DualAdvance
from proofmass.runner.derivatives.dual_plan import SIGNALS, dual_hold
from proofmass.runner.design.proof.ball_map import BallTicks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import Binding, Default, Tick, Time
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance, Moment

_TIME, _LATEST = "time", 1e18  # direction of the time, and the last one, in seconds
_ROLES = ("update", "derivative", "fold")


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


def sources_of(plan: Plan, blocks: AbstractSet[str]) -> list[Endpoint]:
    """Return the outputs of some blocks that follow from the time alone; raises `ModelError` for what else reads it."""
    sources = []
    for name in sorted(blocks):
        kind = type(plan.blocks[name])
        for function in [*kind.output_functions, *(role for role in _ROLES if role in kind.functions)]:
            bindings = plan.bindings(name, function)
            if Time() in bindings and not all(isinstance(one, Time | Default) for one in bindings):
                raise plan.graph.placed(_reads_time(name)).error
            if Time() in bindings:
                sources.append((name, function))
    return sources


def changes_later_on(plan: Plan, source: Endpoint, time: float) -> bool:
    """Return whether an output that follows from the time alone may change after some time.

    Intervals of time touch, so that what has no slope in any of them stays the same.
    """
    while time < _LATEST:
        try:
            value = _value_of(plan, source, dual(ball(time, 2.0 * time), {_TIME: 1.0}, SIGNALS))
        except ArithmeticError:  # it decides differently within the interval
            return True
        if not arb_of(plain(slopes_of(value, SIGNALS).get(_TIME, 0.0))).is_zero():
            return True
        time *= 2.0
    return False


def comes_round(plan: Plan, source: Endpoint, ticks: int, first: int) -> int:
    """Return after how many periods of some ticks an output that follows from the time alone comes round.

    It does so from the tick `first` on, whatever signals drive its other parameters. 0 where that is not known.
    """
    block = plan.blocks[source[0]]
    base, frequency = plan.schedule.base_rate, Fraction(0)
    if type(block) is Sine:
        frequency = _written(block.frequency)
    elif type(block) is Pulse and not plan.is_driven(source[0]) and 0 <= _written(block.delay) * base <= first:
        frequency = 1 / repetition if (repetition := _written(block.repetition)) > 0 else Fraction(0)
    return (frequency * ticks / base).denominator if frequency > 0 else 0


def _written(number: Any) -> Fraction:
    """Return a number as a person writes it, negative for one that varies."""
    return Fraction(repr(number)) if isinstance(number, float) else Fraction(-1)


def value_at_start(plan: Plan, source: Endpoint) -> float:
    """Return what an output that follows from the time alone is at the start."""
    return float(_value_of(plan, source, 0.0))


def _value_of(plan: Plan, source: Endpoint, time: Any) -> Any:
    name, port = source
    function = for_duals(type(plan.blocks[name]).output_functions[port].function)
    bindings = plan.bindings(name, port)
    return function(plan.constants[name], *(one.value if isinstance(one, Default) else time for one in bindings))


def _reads_time(name: str) -> Problem:
    return Problem(
        message=f"{name} reads the time, and no point of rest is proved of what follows from it",
        key=name,
        hint="put a block without time in its place; `proofmass worst` searches at other points",
        path=("blocks", name),
    )
