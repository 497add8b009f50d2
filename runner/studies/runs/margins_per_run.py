"""Margins as measures of a study: each run is linearised with its own parameters, at a stated operating point.

A loop that is not stable has no margins (NaN, which no limit lets pass), one without limit an
infinite one. `stable` is 1 of a stable loop, 0 of an unstable one, 0.5 if rounding decides:
`at_least` of a limit says which of them pass.
"""

from collections.abc import Iterator
from contextlib import suppress

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.loops import MARGIN_MEASURES
from proofmass.runner.plan.planned import Plan, PlannedMeasure
from proofmass.runner.planning.plan import plan


def margin_measures(planned: Plan, at: str) -> tuple[PlannedMeasure, ...]:
    """Return the measures of all named loops, such as "main.gain_margin"; none if `at` is empty."""
    return tuple(
        PlannedMeasure(f"{name}.{margin}", loop.open_at, margin, unit, split(loop.open_at), False, 0)
        for name, loop in planned.graph.loops.items()
        for margin, unit in MARGIN_MEASURES.items()
        if at
    )


def notes_on_margins(graph: Graph, at: str) -> Iterator[Problem]:
    """Yield a note for each block at a corner about which loops are linearised in the sensor as it is."""
    if not (at and graph.loops):
        return
    # start-up time: only studies with margins need them
    from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
    from proofmass.runner.analysis.linearisation.linearise import loop_nodes

    points = OperatingPoints(plan(graph), at)
    for name, node in loop_nodes(points.plan).items():
        with suppress(ModelError):  # each run says why it has none
            about, system = points.about_loop(node)
            for note in about.corners_of(system, node):
                yield graph.placed(Problem(message=note, note=True, path=("loops", name)))


def margins_at(planned: Plan, at: str) -> tuple[float, ...]:
    """Return their values for one plan, in the same order, the least over the phases of what oscillates.

    Raises `ModelError` if a loop cannot be linearised.
    """
    if not at:
        return ()
    # start-up time: only studies with margins need them
    from proofmass.runner.analysis.margins.many import margins_alone

    values = margins_alone(planned, at, over=True)
    if isinstance(values, ModelError):
        raise values
    return values
