"""Whether a factor's limits move with a loop that stands still for it: delayed integrators, whose limits are known."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.motion import _limits, moves_limits
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from tests.runner.analysis.linearisation.test_open_loop import opened

PERIOD = 1e-3


def delayed(k: float) -> PeriodMap:
    """k z^-1 / (z - 1) is -k at 60 degrees, and above zero at half the rate."""
    a, b, c = np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([[1.0], [0.0]]), np.array([[0.0, k]])
    return opened(a, b, c, np.zeros((1, 1)), PERIOD).map


def undelayed(k: float) -> PeriodMap:
    """k / (z - 1) is -k / 2 at half the rate."""
    return opened(np.ones((1, 1)), np.ones((1, 1)), np.full((1, 1), k), np.zeros((1, 1)), PERIOD).map


@pytest.mark.parametrize("of", [delayed, undelayed])
def test_a_loop_moves_its_limits_by_the_part_that_its_gain_changes(of: Callable[[float], PeriodMap]) -> None:
    first = of(0.5)
    assert not moves_limits(first, [of(0.5), of(0.5)], 1e-9)
    assert not moves_limits(first, [of(0.5), of(0.52)], 0.041)
    assert moves_limits(first, [of(0.5), of(0.52)], 0.039)
    assert moves_limits(first, [of(0.48)], 0.039)
    assert not moves_limits(first, [], 1e-9)


def test_limits_are_where_the_loop_is_negative() -> None:
    assert _limits(OpenLoop(delayed(0.5))) == pytest.approx([math.pi / 3.0 / PERIOD], rel=0.03)
    assert _limits(OpenLoop(undelayed(0.5))) == pytest.approx([math.pi / PERIOD], rel=1e-12)
    assert not len(_limits(OpenLoop(undelayed(-0.5)))), "it is above zero at half the rate, and never crosses before"
