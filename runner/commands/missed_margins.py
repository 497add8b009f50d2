"""Margins that a graph requires of its loops, as `check` looks at them."""

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import all_margins, missed
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan


def missed_margins(graph: Graph) -> list[Problem]:
    """Return the problems and notes of loops with requirements, linearised at tick 0."""
    planned = plan(graph)
    loops: dict[str, Margins] = {}
    for name, loop in planned.graph.loops.items():
        if loop.requirements:
            loops |= all_margins(planned, name)
    notes = [_note(planned, margins, text) for margins in loops.values() for text in margins.system.map.notes]
    return [*missed(planned, loops), *notes]


def _note(planned: Plan, margins: Margins, text: str) -> Problem:
    key, path = f"loops.{margins.loop}", ("loops", margins.loop)
    return planned.graph.placed(Problem(message=text, key=key, note=True, path=path))
