"""Runs of a block alone, between sources of numbers: what each comes to in plain Python."""

import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.integration import Integration
from proofmass.runner.contract.around import graph_around
from proofmass.runner.contract.drawn import random_block, random_value
from proofmass.runner.contract.outcomes import Outcome, Sensor, outcome
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan, varied
from proofmass.runner.run.faults import own_line
from proofmass.runner.targets.native import CompiledPlan

TESTED = "tested"
LANES = 8
TICKS, HOSTILE_TICKS, STEPPED_TICKS = 200, 16, 20
_STEPS = Integration(method="runge_kutta_4", substeps=4)


@dataclass(frozen=True)
class Case:
    """Runs side by side that differ in numbers: those of the sources, and of the block."""

    sensors: Sequence[Sensor]
    given: dict[Endpoint, AnyArray]  # what differs, for each of them
    ticks: int

    @cached_property
    def outcomes(self) -> list[Outcome]:
        """Return their outcomes in plain Python."""
        return [outcome(sensor, self.ticks) for sensor in self.sensors]

    @cached_property
    def compiled(self) -> CompiledPlan:
        """The loop in machine code."""
        return CompiledPlan(self.sensors[0].plan)

    @property
    def runs(self) -> list[tuple[Sensor, Outcome]]:
        """Yield each run with its outcome."""
        return list(zip(self.sensors, self.outcomes, strict=True))

    def faults(self) -> Counter[str]:
        """Count the runs that end with each fault."""
        return Counter(_kind_of(sensor.plan.blocks[TESTED], o.error.value) for sensor, o in self.runs if o.fault)


def _kind_of(block: Block, value: Any) -> str:
    if not isinstance(value, Exception):
        return "a number that is not finite"
    line = own_line(block, value)
    return type(value).__name__ + (f" at {line}" if line else "")


def cases(kind: type[Block], folder: Path, hostile: bool, sets: int, lanes: int = LANES) -> list[Case]:
    """Return runs of the block as it is by default, and with sets of parameters drawn by chance."""
    dice = random.Random(f"{kind.__name__} {hostile}")
    blocks = [_default(kind, dice, folder), *(random_block(kind, dice, folder) for _ in range(sets - 1))]
    return [_case(block, folder, hostile, 0.1**number, dice, lanes) for number, block in enumerate(blocks)]


def _default(kind: type[Block], dice: random.Random, folder: Path) -> Block:
    """The block by default; one of a recording needs a file."""
    recorded = any(buffer.recorded for buffer in kind.buffers.values())
    return random_block(kind, dice, folder) if recorded else kind()


def _case(block: Block, folder: Path, hostile: bool, scale: float, dice: random.Random, lanes: int) -> Case:
    graph = graph_around({TESTED: block}, folder, hostile, scale)
    planned = plan(graph)
    ticks = HOSTILE_TICKS if hostile else TICKS
    if any(not solver.exact for solver in planned.solvers):
        planned, ticks = plan(replace(graph, integration=_STEPS)), min(ticks, STEPPED_TICKS)
    plans = [planned, *(_another(planned, dice) for _ in range(lanes - 1))]
    differing = [
        (name, parameter)
        for name, first in planned.blocks.items()
        for parameter in type(first).parameters
        if any(getattr(other.blocks[name], parameter) != getattr(first, parameter) for other in plans)
    ]
    given = {node: np.array([getattr(p.blocks[node[0]], node[1]) for p in plans], dtype=float) for node in differing}
    return Case([Sensor(other, run) for run, other in enumerate(plans)], given, ticks)


def _another(planned: Plan, dice: random.Random) -> Plan:
    """The plan with other seeds of sources, and other numbers of the block if they go together."""
    seeds = {
        name: replace(block, seed=dice.randrange(2**31))  # type: ignore[call-arg]
        for name, block in planned.blocks.items()
        if name.startswith("source_")
        and "seed" in type(block).parameters
        and type(block).parameters["seed"].kind is int
        and "taps" not in type(block).parameters
    }
    block: Any = planned.blocks[TESTED]
    if not type(block).has_formats():
        free = [p for p in type(block).parameters.values() if p.kind is float]
        try:
            other = replace(block, **{p.name: random_value(p, dice) for p in free})
            made = varied(planned, {**seeds, TESTED: other})
            if made.same_sizes(planned):
                return made
        except ModelError:
            pass
    return varied(planned, seeds)
