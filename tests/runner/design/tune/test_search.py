"""From which points a search begins, and what stands in the way of a better one: by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.quantities.loop_figures import Reading
from proofmass.runner.design.tune.goals_at import GoalRow, TriedPoint
from proofmass.runner.design.tune.search import _apart
from proofmass.runner.design.tune.tune import _multipliers

TUNING: Any = SimpleNamespace(free=("gain", "pole"))


def row(goal: str, value: float, *gradient: float) -> GoalRow:
    return GoalRow(goal, "", value, np.array(gradient))


def tried(
    parts: tuple[float, float],
    slacks: tuple[GoalRow, ...] = (),
    objectives: tuple[GoalRow, ...] = (),
    known: bool = True,
) -> TriedPoint:
    readings = {"": {"phase": Reading(1.0, {}) if known else None}}
    return TriedPoint(np.array(parts), {}, readings, slacks, objectives, None, True)


def test_starts_lie_apart_as_points_spread_evenly_do() -> None:
    """Sixteen points in a square are a quarter apart: those nearer than half of that count once."""
    places = [(0.5, 0.5), (0.6, 0.45), (0.5, 0.65), (0.45, 0.66), (0.9, 0.9), (0.1, 0.1)]
    points = [tried(place) for place in places + [(0.5, 0.5)] * 10]
    assert [tuple(at.parts) for at in _apart(points, 3)] == [places[0], places[2], places[4]]
    assert [tuple(at.parts) for at in _apart(points, 9)] == [places[0], places[2], places[4], places[5]]


def test_what_a_percent_of_a_limit_costs() -> None:
    """(3, 6) is three times (1, 2): by Lagrange, the objective falls by 3 for each 1 that the limit gives way."""
    limit, far = row("phase", 0.0, 1.0, 2.0), row("slow", 0.5, -1.0, 0.0)
    prices, bounds = _multipliers(tried((0.5, 0.5), (limit, far), (row("noise", 0.0, 3.0, 6.0),)), TUNING)
    assert prices == {"phase": pytest.approx(0.03)}
    assert bounds == {}


def test_bounds_that_a_better_point_lies_behind() -> None:
    """(2, 6) - 3 (0, 2) is left: the first parameter would go below its lower bound."""
    limit = row("phase", 0.0, 0.0, 2.0)
    prices, bounds = _multipliers(tried((0.0, 0.5), (limit,), (row("noise", 0.0, 2.0, 6.0),)), TUNING)
    assert prices == {"phase": pytest.approx(0.03)}
    assert bounds == {"gain": "lower"}
    _, bounds = _multipliers(tried((0.5, 1.0), (), (row("noise", 0.0, 0.0, -1.0),)), TUNING)
    assert bounds == {"pole": "upper"}


def test_goals_in_conflict_share_what_is_missed() -> None:
    """One slack grows by 1 where the other falls by 3: three parts of one and one of the other balance."""
    slacks = row("phase", -0.3, 1.0, 0.0), row("fast", -0.3, -3.0, 0.0), row("quiet", 0.1, 0.0, 1.0)
    prices, _ = _multipliers(tried((0.5, 0.5), slacks), TUNING)
    assert prices == {"phase": pytest.approx(0.75), "fast": pytest.approx(0.25)}


def test_without_goals_or_values_nothing_binds() -> None:
    assert _multipliers(tried((0.0, 0.5)), TUNING) == ({}, {})
    assert _multipliers(tried((0.0, 0.5), (row("phase", -0.3, 1.0, 0.0),), known=False), TUNING) == ({}, {})
