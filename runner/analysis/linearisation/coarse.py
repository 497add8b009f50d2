"""Notes on blocks of a loop that choose one of some levels: of two levels the gain depends on what is chosen from."""

from collections.abc import Iterator

from proofmass.blocks.declaration.declare import BlockType
from proofmass.graphs.model.digraph import reached, turned
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.plan.planned import Plan


def coarse_blocks(plan: Plan, node: Endpoint) -> tuple[str, ...]:
    """Return a note for each block that chooses levels in the loops through an output."""
    ahead, behind = reached(plan.readers, {node[0]}), reached(turned(plan.readers), {node[0]})
    return tuple(
        f"{name} chooses one of some levels, and counts as a gain of one: slow signals see that;"
        " whether the choice itself is stable is told by a run alone"
        for name in sorted(ahead & behind)
        if any(reaches(function, LEVELS) for function in _functions(type(plan.blocks[name])))
    )


def _functions(kind: BlockType) -> Iterator[object]:
    yield from (behaviour.function for behaviour in kind.output_functions.values())
    if "update" in kind.functions:
        yield kind.functions["update"].function
