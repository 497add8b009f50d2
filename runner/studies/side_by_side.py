"""Runs of a study in the lanes of vector instructions."""

import math
import threading
from collections.abc import Iterator, Mapping, Sequence

from proofmass.blocks.problem import ModelError
from proofmass.graphs.graph import split
from proofmass.graphs.schedule import Node
from proofmass.graphs.study import Study
from proofmass.runner.engine.interrupts import StoppedError
from proofmass.runner.engine.native_lanes import CompiledLanes, Lanes
from proofmass.runner.engine.plan import varied
from proofmass.runner.engine.planned import Plan
from proofmass.runner.studies.measuring import value_of

CHUNK = 1 << 20  # ticks of all lanes between looks at an interruption
Parameters = Mapping[str, float]  # by `block.parameter`


class SideBySide:
    """Runs sensors of a study, `lanes` at a time; the bits are those of each run alone."""

    def __init__(self, study: Study, plan: Plan, ticks: int, lanes: int, names: Sequence[str]) -> None:
        self.study, self.plan, self.ticks, self.lanes = study, plan, ticks, lanes
        nodes = {name: _node(name) for name in names}
        self._compiled = CompiledLanes(plan, frozenset(nodes.values()), lanes)
        self._settled = [name for name, node in nodes.items() if node[0] in self._compiled.settled]
        self._free = [(n, node, plan.blocks[node[0]].parameters[node[1]]) for n, node in nodes.items()]
        self._free = [entry for entry in self._free if entry[0] not in self._settled]
        self._measuring = {measure.node[0] for measure in plan.measures}

    def measured(
        self, sensors: Sequence[tuple[Parameters, int]], stop: threading.Event
    ) -> list[tuple[float, ...] | None]:
        """Values of the measures of sensors, of which the parameters and the number of the noise are given.

        None where they must be looked for in the run alone. Raises `StoppedError` soon after the event is set.
        """
        plans = [self._plan(values) for values, _ in sensors]
        able = [(*sensor, plan) for sensor, plan in zip(sensors, plans, strict=True) if plan is not None]
        groups = (able[first : first + self.lanes] for first in range(0, len(able), self.lanes))
        done = iter([values for group in groups for values in self._run(group, stop)])
        return [None if plan is None else next(done) for plan in plans]

    def _run(
        self, group: Sequence[tuple[Parameters, int, Plan]], stop: threading.Event
    ) -> Iterator[tuple[float, ...] | None]:
        values = [{node: given[name] for name, node, _ in self._free} for given, _, _ in group]
        noise, plans = [number for _, number, _ in group], [plan for _, _, plan in group]
        lanes = Lanes(self._compiled, self.study.seed, noise, values, plans)
        step = CHUNK // self.lanes
        for first in range(0, self.ticks, step):
            if stop.is_set():
                raise StoppedError
            lanes.advance(min(first + step, self.ticks))
        for lane, plan in enumerate(plans):
            if not lanes.sound(lane):
                yield None
                continue
            memory = lanes.memory(lane, self._measuring)
            yield tuple(value_of(plan, measure, memory) for measure in plan.measures)

    def _plan(self, values: Parameters) -> Plan | None:
        """The plan of a sensor with the blocks that are settled before it runs; None where it cannot be made."""
        for name, _, parameter in self._free:
            if not (math.isfinite(values[name]) and parameter.inside(values[name])):
                return None
        if not self._settled:
            return self.plan
        try:
            return varied(self.plan, self.study.blocks({name: values[name] for name in self._settled}))
        except ModelError:
            return None


def _node(name: str) -> Node:
    block, parameter = split(name)
    return block, parameter
