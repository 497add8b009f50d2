"""Sensors that run to rest side by side, in the lanes of machine code, where that pays."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.settle import looks, resting_numbers
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.tick_loop import bytes_of_a_run
from proofmass.runner.run.estimates import is_short
from proofmass.runner.run.side_by_side import lanes_for

if TYPE_CHECKING:
    from proofmass.runner.targets.native_lanes import CompiledLanes

_LATER = 4  # times the tick by which the first has settled: those that have not by then run alone


class SettledLanes:
    """Runs sensors that differ from a plan in real parameters until their loops have settled.

    Each is to the bit what it would be alone. The plan has settled by a `tick`.
    """

    def __init__(self, plan: Plan, tick: int) -> None:
        self._plan, self._tick = replace(plan, probes=()), tick
        self._compiled: dict[tuple[frozenset[Endpoint], int], CompiledLanes] = {}

    def memories(self, sensors: Sequence[Plan], total: int) -> list[Memory | None]:
        """Return the memory in which each has settled; None of those that are to run alone.

        A `total` that runs for a short time runs alone: compiling takes time too.
        """
        found: list[Memory | None] = [None] * len(sensors)
        varied = self._varied(sensors)
        lanes = lanes_for(len(sensors), bytes_of_a_run(self._plan))
        if not varied or not lanes or is_short(self._plan, total * self._tick):
            return found
        # start-up time: few sensors need no compiler
        from proofmass.runner.targets.native_lanes import CompiledLanes, Lanes

        if (varied, lanes) not in self._compiled:
            self._compiled[varied, lanes] = CompiledLanes(self._plan, varied, lanes)
        values = {(name, key): np.array([getattr(of.blocks[name], key) for of in sensors]) for name, key in varied}
        alone = np.zeros(len(sensors), dtype=np.int64)  # no noise tells runs apart
        runs = Lanes(self._compiled[varied, lanes], self._plan.graph.seed, alone, values, sensors)
        left, at = np.ones(len(sensors), dtype=bool), resting_numbers(self._plan)

        def numbers(tick: int) -> Array:
            runs.advance(tick)
            return runs.held(at.entries)

        for look in looks(at, len(sensors), numbers):
            for number in np.flatnonzero(look.settled & left & runs.sound()).tolist():
                found[number] = runs.memory(number, sensors[number])
            left &= ~look.settled
            if not left.any() or look.tick >= _LATER * self._tick:
                break
        return found

    def _varied(self, sensors: Sequence[Plan]) -> frozenset[Endpoint]:
        """Return the parameters in which sensors differ from the plan; none if one of these is not a real number.

        What a wire gives is none.
        """
        varied, driven = set[Endpoint](), self._plan.schedule.drivers
        for name, block in self._plan.blocks.items():
            others = {id(of.blocks[name]): of.blocks[name] for of in sensors if of.blocks[name] is not block}
            for parameter in type(block).parameters if others else ():
                own = getattr(block, parameter)
                values = [getattr(other, parameter) for other in others.values()]
                if (name, parameter) in driven or all(value is own or value == own for value in values):
                    continue
                if not all(isinstance(value, float) for value in (own, *values)):
                    return frozenset()
                varied.add((name, parameter))
        return frozenset(varied)
