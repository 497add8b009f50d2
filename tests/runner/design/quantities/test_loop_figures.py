"""Slopes of figures that have none in closed form, by differences of exact matrices."""

import math

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.margins.margins import margins_of
from proofmass.runner.design.quantities.loop_figures import read_figure

WIRE = (("plant", "output", 0),)


def test_slopes_of_a_step_are_those_of_its_closed_form() -> None:
    """K / (s / 10 + 1) settles after log(50) / (10 + 10 K) s, and never rises above its end."""
    matrix, by_gain = np.array([[-10.0, 10.0, 0.0], [-3.0, 0.0, 0.0]]), np.array([[0.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
    moved = PeriodMap((("plant", "x", -1),), WIRE, WIRE, matrix, {"gain": by_gain}, 0.0)
    loop = OpenLoop(moved, continuous=True)
    margins = margins_of(loop, "main", "plant.output")
    found = read_figure(margins, loop, "settling_time", {"gain": 3.0, "other": 1.0})
    assert found.slopes == {"gain": pytest.approx(-10.0 * math.log(50.0) / 40.0**2, rel=1e-3)}
    assert read_figure(margins, loop, "overshoot", {"gain": 3.0}).slopes == {"gain": 0.0}
