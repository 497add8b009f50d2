"""Runs of a study in the lanes of vector instructions."""

import threading
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.blocks.problem import ModelError
from proofmass.graphs.graph import split
from proofmass.graphs.schedule import Node
from proofmass.graphs.study import Study
from proofmass.runner.engine.interrupts import StoppedError
from proofmass.runner.engine.native import Array
from proofmass.runner.engine.native_lanes import CompiledLanes, Lanes
from proofmass.runner.engine.plan import varied
from proofmass.runner.engine.planned import Plan
from proofmass.runner.studies.measuring import value_of

CHUNK = 1 << 20  # ticks of all lanes between looks at an interruption


class SideBySide:
    """Runs sensors of a study, `lanes` at a time; the bits are those of each run alone."""

    def __init__(self, study: Study, plan: Plan, ticks: int, lanes: int, names: Iterable[str]) -> None:
        self.study, self.plan, self.ticks, self.lanes = study, plan, ticks, lanes
        nodes = {name: _node(name) for name in names}
        self.compiled = CompiledLanes(plan, frozenset(nodes.values()), lanes)
        self._settled = [name for name, node in nodes.items() if node[0] in self.compiled.settled]
        self._free = {name: node for name, node in nodes.items() if name not in self._settled}
        self._measuring = {measure.node[0] for measure in plan.measures}

    def measured(
        self, values: Mapping[str, Array], noise: Sequence[int], stop: threading.Event
    ) -> list[tuple[float, ...] | None]:
        """Values of the measures of sensors; parameters by `block.parameter`, a number a sensor, and its noise.

        None where they must be looked for in the run alone. Raises `StoppedError` soon after the event is set.
        """
        made = {int(number): self._plan(values, int(number)) for number in np.flatnonzero(self._inside(values))}
        able = [number for number, plan in made.items() if plan is not None]
        found: list[tuple[float, ...] | None] = [None] * len(noise)
        for first in range(0, len(able), self.lanes):
            some = able[first : first + self.lanes]
            free = {node: values[name][some] for name, node in self._free.items()}
            plans = [plan for number in some if (plan := made[number]) is not None]
            lanes = Lanes(self.compiled, self.study.seed, [noise[number] for number in some], free, plans)
            self._advance(lanes, stop)
            for number, measures in zip(some, self._measures(lanes, plans), strict=True):
                found[number] = measures
        return found

    def _advance(self, lanes: Lanes, stop: threading.Event) -> None:
        step = CHUNK // self.lanes
        for first in range(0, self.ticks, step):
            if stop.is_set():
                raise StoppedError
            lanes.advance(min(first + step, self.ticks))

    def _measures(self, lanes: Lanes, plans: Sequence[Plan]) -> Iterator[tuple[float, ...] | None]:
        for plan, sound, memory in zip(plans, lanes.sound(), lanes.memories(self._measuring), strict=False):
            if sound:
                yield tuple(value_of(plan, measure, memory) for measure in self.plan.measures)
            else:
                yield None

    def _inside(self, values: Mapping[str, Array]) -> Any:
        """Which sensors have parameters within their bounds."""
        inside = np.isfinite(np.array(list(values.values()))).all(axis=0)
        for name, (block, parameter) in self._free.items():
            declared = self.plan.blocks[block].parameters[parameter]
            inside &= np.array([declared.inside(value) for value in values[name].tolist()])
        return inside

    def _plan(self, values: Mapping[str, Array], number: int) -> Plan | None:
        """The plan of a sensor with the blocks that are settled before it runs; None where it cannot be made."""
        if not self._settled:
            return self.plan
        try:
            blocks = self.study.blocks({name: float(values[name][number]) for name in self._settled})
            return varied(self.plan, blocks)
        except ModelError:
            return None


def _node(name: str) -> Node:
    block, parameter = split(name)
    return block, parameter
