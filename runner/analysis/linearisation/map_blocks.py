"""The blocks of a map between wires, when they tick together again, and notes on them."""

import math
from collections.abc import Collection, Iterable, Sequence

from proofmass.blocks.declaration.problem import Problem, problem_of_output
from proofmass.graphs.model.digraph import reached, turned
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.derivatives.dual_noise import functions_in_loop
from proofmass.runner.plan.planned import Plan

LONGEST_PERIOD = 100_000  # base ticks
MOST_VALUES = 4_096  # of a wire that is cut, in a map
_OUTSIDE = "open the loop so that this block lies outside, or linearise at another time"


def blocks_of_map(
    plan: Plan, inputs: Sequence[Endpoint], outputs: Sequence[Endpoint], everything: bool, noise: Collection[str] = ()
) -> tuple[set[str], set[str]]:
    """Blocks that the outputs depend on, and those of them that the map has the states of."""
    upstream = upstream_of(plan, (name for name, _ in outputs))
    if everything:
        return upstream, upstream
    noisy = {*noise} | reached(plan.readers, noise)
    return upstream, upstream & (_downstream(plan, inputs) | noisy)


def upstream_of(plan: Plan, names: Iterable[str]) -> set[str]:
    """Return some blocks and those that they depend on."""
    own = {*names}
    return own | reached(turned(plan.readers), own)


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


def too_many(node: Endpoint, values: int) -> Problem:
    """Return the problem of a wire with so many values in a map."""
    return problem_of_output(
        node,
        message=f"the loop has too many values of {'.'.join(node)} in its common period",
        got=f"{values:,}",
        expected=f"at most {MOST_VALUES:,}",
        hint="open the loop at its slowest wire, where a period has few values",
    )


def not_linear(at: str, got: str, hint: str = _OUTSIDE) -> Problem:
    """Return the problem of a function or a state of a block, "block.what", that has no slope."""
    name, _, what = at.rpartition(".")
    return Problem(
        message=f"cannot be linearised: {what} has no derivative here",
        got=got,
        expected="arithmetic, comparisons and functions of math on values that signals change",
        hint=hint,
        path=("blocks", name),
    )


def coarse_blocks(plan: Plan, node: Endpoint) -> tuple[str, ...]:
    """Return a note for each block that chooses levels in the loops through an output."""
    ahead, behind = reached(plan.readers, {node[0]}), reached(turned(plan.readers), {node[0]})
    return tuple(
        f"{name} chooses one of some levels, and counts as a gain of one: slow signals see that;"
        " whether the choice itself is stable is told by a run alone"
        for name in sorted(ahead & behind)
        if any(reaches(each.function, LEVELS) for each in functions_in_loop(plan.blocks[name]).values())
    )
