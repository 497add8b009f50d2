"""Points of a search for parameters, with goals written down by hand."""

import numpy as np

from proofmass.runner.design.quantities.loop_figures import Reading
from proofmass.runner.design.tune.goals_at import GoalRow, TriedPoint


def row(goal: str, value: float, *gradient: float) -> GoalRow:
    """A slack or an objective with its gradient."""
    return GoalRow(goal, "", value, np.array(gradient))


def tried(
    parts: tuple[float, float],
    slacks: tuple[GoalRow, ...] = (),
    objectives: tuple[GoalRow, ...] = (),
    known: bool = True,
) -> TriedPoint:
    """A point within its bounds, whose quantities are known or not."""
    readings = {"": {"phase": Reading(1.0, {}) if known else None}}
    return TriedPoint(np.array(parts), {}, readings, slacks, objectives, None, True)
