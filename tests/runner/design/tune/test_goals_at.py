"""The objective of a goal that is to be as low or as high as possible, by hand."""

import math

import numpy as np
import pytest

from proofmass.graphs.model.quantities import MeasureOf
from proofmass.graphs.tuning.tuning import Goal
from proofmass.runner.design.tune.goals_at import GoalRow, GoalsAt


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("value", "objective", "slope"),
    [
        (2.0, math.log(2.0 / 4.0), 3.0 / 2.0),  # a logarithm of the part of what it was
        (0.0, 0.0, 3.0 / 4.0),  # which 0 and what is below have none of
        (-2.0, -0.5, 3.0 / 4.0),
        (math.inf, None, 0.0),
    ],
)
def test_objectives_are_relative(value: float, objective: float | None, slope: float, sign: float) -> None:
    """Of a value of 4 at the start; one without limit is worse than all where it is to be low, and best else."""
    goals = object.__new__(GoalsAt)
    goals._sizes = {"end": 4.0}
    row = GoalRow("end", "", value, np.array([3.0]))
    found = goals._objective(Goal(MeasureOf("end", "1"), minimise=sign > 0.0, maximise=sign < 0.0), row)
    assert found.value == pytest.approx(-sign * 1e3 if objective is None else sign * objective)
    assert found.gradient == pytest.approx([sign * slope])
