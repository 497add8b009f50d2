"""Truth values that noise decides: they have no slope, so that no budget has what they do."""

from collections.abc import Sequence
from collections.abc import Set as AbstractSet

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.compiled_decisions import KeptRuns, part_of
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.derivatives.dual_noise import given, reached
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.simulate import RunOptions, simulate_plan

_MOST_CALLS = 4_000_000  # of functions of blocks
_VALUES = 1 << 12  # of the output


def decided_by_noise(plan: Plan, target: Endpoint, tick: int, kept: KeptRuns) -> list[str]:
    """Return the truth values upstream of an output that differ in two runs of different noise.

    What runs for the same values have said is `kept`.
    """
    upstream = upstream_of(plan, target[:1])
    wires = _truths(plan, upstream & reached(plan, given(plan, (Deviate,))), upstream)
    if not wires:
        return []
    names = [".".join(wire) for wire in wires]
    key = "truths", *names, tick, plan.stride(target)
    if key not in kept:
        kept[key] = _decided(plan, wires, names, tick + _VALUES * plan.stride(target))
    decided: list[str] = kept[key]
    return decided


def _decided(plan: Plan, wires: Sequence[Endpoint], names: Sequence[str], most: int) -> list[str]:
    """Return those that differ within some ticks at most."""
    alone = part_of(plan, upstream_of(plan, (name for name, _ in wires)), names, {})
    ticks = min(most, _MOST_CALLS // max(1, len(alone.schedule.order)))
    seeds = plan.graph.seed, plan.graph.seed ^ 1
    try:
        runs = [simulate_plan(alone, alone.graph.root, RunOptions(samples=ticks, seed=seed)) for seed in seeds]
    except (ModelError, RunError):  # the budget does not depend on what a whole run meets
        return []
    return [name for name in names if not np.array_equal(runs[0][name].values, runs[1][name].values)]


def _truths(plan: Plan, noisy: AbstractSet[str], upstream: AbstractSet[str]) -> list[Endpoint]:
    """Return the truth values of some blocks that others upstream read."""
    read = {node for (name, _), node in plan.schedule.drivers.items() if name in upstream and node[0] in noisy}
    return sorted(node for node in read if type(plan.blocks[node[0]]).outputs[node[1]].dtype is bool)
