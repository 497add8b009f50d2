"""Tuned loops beside grids of controllers found in lanes; `benchmarks/tuned_loops.py` prints the whole."""

import pytest

from benchmarks.tuned_loops import CASES, compared


@pytest.mark.exhaustive
@pytest.mark.parametrize("points", [64, 10_000])
def test_the_quartz_loop_is_no_worse_than_a_grid(points: int) -> None:
    case = CASES["quartz"]()
    tuned, noise, of_grid, count = compared(case, points, *((4, 1) if points < 1000 else (32, 2)))
    assert tuned.met
    assert count > 0
    assert noise <= of_grid * (1.0 + 1e-6)
    assert noise > 0.5 * of_grid, "the grid is near: both have the same noise"


@pytest.mark.exhaustive
def test_the_rebalance_loop_is_no_worse_than_a_grid_and_a_conflict_is_named() -> None:
    case = CASES["gyroscope"]()
    tuned, noise, of_grid, count = compared(case, 10_000)
    assert tuned.met
    assert count > 1000
    assert 0.9 * of_grid < noise <= of_grid * (1.0 + 1e-6)
    answer = case.tuned(16, 1, {"still": {"noise": case.output, "at_most": 0.5 * noise}})
    assert not answer.met
    assert [goal.name for goal in answer.goals if goal.binds] == ["phase", "wide", "still"]
