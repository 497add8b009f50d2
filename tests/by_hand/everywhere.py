"""Random graphs over all kinds of blocks in every engine: plain Python, machine code, lanes, C99, WebAssembly.

`python -m tests.by_hand.everywhere 0 500` runs the graphs of these seeds, prints the SHA-256 of what each comes to and
whatever differs, and ends with exit code 1 if anything does. 500 graphs take some eight minutes of a core.
"""

import dataclasses
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.build import Graph
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.integration import Integration
from proofmass.runner.contract.foreign import FOREIGN
from proofmass.runner.contract.outcomes import (
    Outcome,
    Sensor,
    foreign_differences,
    lane_differences,
    native_differences,
    outcome,
    resumed_differences,
)
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.planning.plan import Plan, plan, varied
from proofmass.runner.targets.native import CompiledPlan
from tests.by_hand.random_graphs import ALL_KINDS, random_graphs

TICKS, STEPPED_TICKS = 200, 12
LANES = 4
_STEPS = Integration(method="runge_kutta_4", substeps=2)


@dataclasses.dataclass(frozen=True)
class Compared:
    """One random graph: what it comes to, and in which engines to something else."""

    seed: int
    outcomes: Sequence[Outcome]
    differences: Sequence[str]
    lacking: Sequence[str]  # engines that cannot run it
    kinds: frozenset[str]

    @property
    def digest(self) -> str:
        """SHA-256 of traces and memory of the first run."""
        return self.outcomes[0].digest()


def compared(seeds: Sequence[int], folder: Path, largest: int = 8) -> Iterator[Compared]:
    """Each graph in every engine; the kinds of blocks are dealt so that none is rare."""
    for seed, graph in zip(seeds, random_graphs(seeds, folder, largest, ALL_KINDS), strict=True):
        yield compared_graph(seed, graph)


def compared_graph(seed: int, graph: Graph) -> Compared:
    """One graph in every engine: two sensors that differ in noise and in the parameters that may differ."""
    dice = random.Random(f"sensors of {seed}")
    planned, ticks = plan(graph), TICKS
    if any(not solver.exact for solver in planned.solvers):
        planned, ticks = plan(replace(graph, integration=_STEPS)), STEPPED_TICKS
    plans = [planned, another(planned, dice)]
    sensors = [Sensor(made, run) for run, made in enumerate(plans)]
    outcomes = [outcome(sensor, ticks) for sensor in sensors]
    compiled = CompiledPlan(planned)
    told = [f"machine code: {text}" for text in native_differences(compiled, sensors, outcomes)]
    told += [f"interrupted: {text}" for text in resumed_differences(compiled, sensors, outcomes)]
    told += [f"lanes: {text}" for text in lane_differences(sensors, outcomes, differing(plans), LANES)]
    lacking = []
    for compiler in FOREIGN:
        if compiler.lacks(compiled.written.program):
            lacking.append(compiler.name)
            continue
        told += [f"{compiler.name}: {text}" for text in foreign_differences(compiler, compiled, sensors, outcomes)]
    return Compared(seed, outcomes, told, lacking, frozenset(type(b).__name__ for b in flatten(graph).blocks.values()))


def another(planned: Plan, dice: random.Random) -> Plan:
    """The plan with numbers changed by some ten-thousandths that neither a wire nor a format settles."""
    blocks = {}
    for name, block in planned.blocks.items():
        free = [
            p.name
            for p in type(block).parameters.values()
            if p.kind is float and not type(block).has_formats() and (name, p.name) not in planned.schedule.drivers
        ]
        try:
            changes = {p: getattr(block, p) * (1.0 + 1e-4 * dice.uniform(-1.0, 1.0)) for p in free}
            varied(planned, {name: replace(block, **changes)})  # type: ignore[arg-type]
        except ModelError:  # two of its numbers must be alike
            continue
        blocks[name] = replace(block, **changes)  # type: ignore[arg-type]
    return varied(planned, blocks)


def differing(plans: Sequence[Plan]) -> dict[Endpoint, AnyArray]:
    """The parameters in which the plans differ, with what they are in each."""
    first = plans[0]
    return {
        (name, p.name): np.array([getattr(made.blocks[name], p.name) for made in plans], dtype=float)
        for name, block in first.blocks.items()
        for p in type(block).parameters.values()
        if any(getattr(made.blocks[name], p.name) != getattr(block, p.name) for made in plans)
    }


def main(first: int, last: int) -> int:
    """Compare the graphs of these seeds; returns the exit code."""
    wrong, kinds, lacking, faults = 0, Counter[str](), Counter[str](), 0
    with tempfile.TemporaryDirectory() as folder:
        for graph in compared(range(first, last), Path(folder)):
            print(f"{graph.seed:6} {graph.digest} {graph.outcomes[0].ticks:5} ticks", *graph.lacking, flush=True)
            for text in graph.differences:
                print(f"       {text}", flush=True)
            wrong += bool(graph.differences)
            kinds.update(graph.kinds)
            lacking.update(graph.lacking)
            faults += bool(graph.outcomes[0].fault)
    least = min(kinds.items(), key=lambda item: item[1])
    print(f"{last - first} graphs of {len(kinds)} kinds, each in at least {least[1]} ({least[0]}); {faults} end early")
    print(f"not run in: {dict(lacking) or 'none'}; {wrong} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
