"""Sources at rest or on an orbit: what follows from the time alone is constant from a time on, or comes round.

A sine of frequency f is the same after n / f seconds, and pulses are after n repetitions. So they
come round after some periods of the schedule if these are a whole number of cycles. A frequency is
the nearest double to the fraction of the rate that it stands for.
"""

import math
from collections.abc import Callable, Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.sources.pulse import Pulse
from proofmass.blocks.sources.sine import Sine
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.ball import arb_of, ball, enclosing
from proofmass.runner.derivatives.dual import SIGNALS, dual, plain, slopes_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.plan.bindings import Default, Time
from proofmass.runner.plan.planned import Plan

MOST_PERIODS = 64  # of an orbit
LATE = 1e9  # s: a source that changes then never stays
_TIME, _LATEST = "time", 1e18  # direction of the time, and the last one, in seconds
_ROLES = ("update", "derivative", "fold")


class RestSources:
    """The outputs of some blocks that follow from the time alone."""

    def __init__(self, plan: Plan, blocks: AbstractSet[str]) -> None:
        """Raises `ModelError` for what else reads the time."""
        self._plan, self._nodes = plan, list[Endpoint]()
        for name in sorted(blocks):
            kind = type(plan.blocks[name])
            for function in [*kind.output_functions, *(role for role in _ROLES if role in kind.functions)]:
                bindings = plan.bindings(name, function)
                if Time() in bindings and not all(isinstance(one, Time | Default) for one in bindings):
                    raise plan.graph.placed(_reads_time(name)).error
                if Time() in bindings:
                    self._nodes.append((name, function))

    def moving(self, plan: Plan, time: float) -> list[Endpoint]:
        """Return those that are not constant from a time on, for a plan with other parameters."""
        with enclosing():
            return [node for node in self._nodes if plan.is_driven(node[0]) or _changes(plan, node, time)]

    def check(self, signal: str, ticks: int, first: int) -> None:
        """Raise `ModelError` that names those which are neither constant from a tick on nor soon come round."""
        moving = self.moving(self._plan, first * self._plan.period)
        turns = [_comes_round(self._plan, node, ticks, first) for node in moving]
        changing = [node for node, turn in zip(moving, turns, strict=True) if not turn]
        if changing or math.lcm(*turns) > MOST_PERIODS:
            raise self._plan.graph.placed(self._depends_on_time(signal, changing or moving)).error

    def turn(self, plan: Plan, ticks: int, first: int) -> int:
        """Return after how many periods of some ticks all come round from a tick on, for a plan
        with other parameters.

        1 if they are constant, 0 where it is not known.
        """
        moving = self.moving(plan, first * plan.period)
        return math.lcm(*(_comes_round(plan, node, ticks, first) for node in moving))

    def _depends_on_time(self, signal: str, sources: Sequence[Endpoint]) -> Problem:
        held = []
        for node in sources:
            unit = self._plan.unit(node)
            value = f"{float(_value_of(self._plan, node, 0.0)):.9g} {unit if unit != '1' else ''}".rstrip()
            held.append(f'--constant "{".".join(node)}={value}"')
        return Problem(
            message=f"{signal} has no point of rest, since sources change with time",
            key=signal,
            got=", ".join(map(".".join, sources)),
            expected="sources that are constant once the loops have settled, or come round",
            hint=f"give them constant values: {' '.join(held)}; or take sines and pulses of which"
            f" at most {MOST_PERIODS} periods of the schedule hold whole cycles",
            path=("blocks", sources[0][0]),
        )


def _comes_round(plan: Plan, source: Endpoint, ticks: int, first: int) -> int:
    """Return after how many periods of some ticks a source comes round from a tick on, 0 where that is not known.

    It does so whatever signals drive its other parameters.
    """
    block, driven = plan.blocks[source[0]], plan.is_driven(source[0])
    if type(block) is Sine:
        return _turn(plan, ticks, block.frequency, lambda frequency: frequency)
    if type(block) is Pulse and not driven and _begun(block.delay, first / plan.schedule.base_rate):
        return _turn(plan, ticks, block.repetition, lambda frequency: 1 / frequency)
    return 0


def _begun(delay: Any, time: Fraction) -> bool:
    return isinstance(delay, float) and delay <= time


def _turn(plan: Plan, ticks: int, number: Any, of_frequency: Callable[[Fraction], Fraction]) -> int:
    """Return the least number of periods that are whole cycles, for a number that follows from the frequency.

    It is the nearest double to what follows from so many cycles: that of a third has no digits of
    its own. One that varies has no such number.
    """
    if not isinstance(number, float) or not number > 0.0:
        return 0
    frequency = of_frequency(Fraction(number))
    for periods in range(1, MOST_PERIODS + 1):
        span = Fraction(periods * ticks) / plan.schedule.base_rate
        cycles = round(frequency * span)
        if cycles and float(of_frequency(cycles / span)) == number:
            return periods
    return 0


def _changes(plan: Plan, source: Endpoint, time: float) -> bool:
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
