"""Slopes in registers against least squares by NumPy and against the estimator in floating point."""

import numpy as np
import pytest

from proofmass.blocks import FixedSlopeEstimator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import drive_fixed

ONE = 1 << 20


def rows(responses: list[int]) -> list[dict[str, int]]:
    """Each response held for three ticks, of which the last is read."""
    return [{"response": value, "read": tick == 2} for value in responses for tick in range(3)]


@pytest.mark.parametrize(
    ("points", "step", "slope"), [(16, 0.125, 1.0002), (2, 0.5, 0.7), (7, 0.25, 1.31), (9, 0.1, 1.0)]
)
def test_the_deviation_is_that_of_a_least_squares_line(points: int, step: float, slope: float) -> None:
    draws = np.random.default_rng(points)
    numbers = step * np.arange(points)
    responses = np.rint((0.3 + slope * numbers + draws.normal(0.0, 0.01, points)) * ONE).astype(int)
    block = FixedSlopeEstimator(points=points, step=step, scale_format=Fixed(32, 28))
    found = drive_fixed(block, [*rows(responses.tolist()), {"response": 0, "read": False}])
    expected = np.polyfit(numbers, responses / ONE, 1)[0] - 1.0
    assert found[-2]["deviation"] == 0
    assert found[-1]["deviation"] / 2**23 == pytest.approx(expected, abs=3e-7)


def test_a_reference_scales_and_an_offset_drops_out() -> None:
    line = [2 * 13107 * i for i in range(16)]  # 0.2 of slope 0.1 a step of 0.125
    block = FixedSlopeEstimator(reference=0.25, scale_format=Fixed(26, 28))
    sweeps = [[y + offset for y in line] for offset in (0, -99_999, 3_000_000)]
    found = [drive_fixed(block, [*rows(sweep), *rows([0])])[-1]["deviation"] for sweep in sweeps]
    assert found[0] == found[1] == found[2]
    assert found[0] / 2**23 == pytest.approx(26214 / ONE / 0.125 / 0.25 - 1.0, abs=1e-6)


def test_each_sweep_begins_anew_and_is_told_once() -> None:
    first, second = ([k * (i << 15) for i in range(4)] for k in (4, 5))
    block = FixedSlopeEstimator(points=4, scale_format=Fixed(32, 28))
    found = drive_fixed(block, [*rows(first), *rows(second), *rows([0])])
    told = [tick for tick, row in enumerate(found) if row["estimated"]]
    assert told == [12, 24]
    assert [found[tick]["deviation"] / 2**23 for tick in told] == pytest.approx([0.0, 0.25], abs=1e-6)


def test_the_largest_responses_do_not_overflow_the_sum() -> None:
    block = FixedSlopeEstimator(points=8, step=16.0, scale_format=Fixed(32, 34), output_format=Fixed(32, 24))
    extremes = [-(1 << 23)] * 4 + [(1 << 23) - 1] * 4
    found = drive_fixed(block, [*rows(extremes), *rows([0])])[-1]["deviation"]
    expected = np.polyfit(16.0 * np.arange(8), np.array(extremes) / ONE, 1)[0] - 1.0
    assert found / 2**24 == pytest.approx(expected, abs=1e-6)
