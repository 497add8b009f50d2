"""Margins as measures of a study: each run is linearised with its own parameters, at a stated operating point.

A loop that is not stable has no margins (NaN, which no limit lets pass), one without limit an
infinite one. `stable` is 1 of a stable loop, 0 of an unstable one, 0.5 if rounding decides:
`at_least` of a limit says which of them pass.
"""

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.loops import MARGIN_MEASURES
from proofmass.runner.plan.planned import Plan, PlannedMeasure


def margin_measures(plan: Plan, at: str) -> tuple[PlannedMeasure, ...]:
    """Return the measures of all named loops, such as "main.gain_margin"; none if `at` is empty."""
    return tuple(
        PlannedMeasure(f"{name}.{margin}", loop.open_at, margin, unit, split(loop.open_at), False, 0)
        for name, loop in plan.graph.loops.items()
        for margin, unit in MARGIN_MEASURES.items()
        if at
    )


def margins_at(plan: Plan, at: str) -> tuple[float, ...]:
    """Return their values for one plan, in the same order; raises `ModelError` if a loop cannot be linearised."""
    if not at:
        return ()
    # start-up time: only studies with margins need them
    from proofmass.runner.analysis.margins.many import margins_alone

    values = margins_alone(plan, at)
    if isinstance(values, ModelError):
        raise values
    return values
