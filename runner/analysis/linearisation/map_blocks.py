"""The blocks of a map between wires, and the base ticks after which they all tick together again."""

import math
from collections.abc import Collection, Sequence

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.digraph import reached, turned
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan

LONGEST_PERIOD = 100_000  # base ticks


def common_period(
    plan: Plan,
    inputs: Sequence[Endpoint],
    outputs: Sequence[Endpoint],
    everything: bool = False,
    noise: Collection[str] = (),
) -> int:
    """Base ticks of the period of a map."""
    return period_of_blocks(plan, blocks_of_map(plan, inputs, outputs, everything, noise)[1], [*inputs, *outputs])


def blocks_of_map(
    plan: Plan, inputs: Sequence[Endpoint], outputs: Sequence[Endpoint], everything: bool, noise: Collection[str] = ()
) -> tuple[set[str], set[str]]:
    """Blocks that the outputs depend on, and those of them that the map has the states of."""
    read = {name for name, _ in outputs}
    upstream = read | reached(turned(plan.readers), read)
    if everything:
        return upstream, upstream
    noisy = {*noise} | reached(plan.readers, noise)
    return upstream, upstream & (_downstream(plan, inputs) | noisy)


def _downstream(plan: Plan, inputs: Sequence[Endpoint]) -> set[str]:
    """Blocks that the wires reach."""
    readers = {target for (target, _), source in plan.schedule.drivers.items() if source in inputs}
    return readers | reached(plan.readers, readers)


def period_of_blocks(plan: Plan, blocks: set[str], ends: Sequence[Endpoint]) -> int:
    """Base ticks after which the blocks, and the outputs that they read, tick together again."""
    read = {source for (target, _), source in plan.schedule.drivers.items() if target in blocks}
    strides = {plan.stride(node) for node in (*read, *ends) if node[0] in blocks or node in ends}
    ticks = math.lcm(*strides, *(plan.schedule.divisors[name] for name in blocks))
    if ticks > LONGEST_PERIOD:
        message = "the blocks tick together too rarely to be linearised over one common period"
        expected, hint = f"at most {LONGEST_PERIOD:,} base ticks", "make the rates ratios of small numbers"
        raise Problem(message=message, key="rate", got=f"{ticks:,}", expected=expected, hint=hint).error
    return ticks
