"""Regressions and Sobol indices of a few runs, worked out by hand."""

import itertools
import math
from typing import Any

import numpy as np
import pytest

from proofmass.runner.studies.shown.sensitivities import Columns, _orthogonal, regression, sobol_indices
from tests.by_hand.study_results import SWEPT, study_result

# all combinations of four signs: their columns and products are at right angles
X, Z, U, W = np.array(list(itertools.product((-1.0, 1.0), repeat=4))).T
SIZE = math.sqrt(16.0 / 15.0)  # standard deviation of each


def test_effects_of_factors_at_right_angles() -> None:
    """Of y = x - 6 z + 2 u, with half u as factor c: slopes 1 and -6, the strongest first; 41 squares, 37 explained."""
    y = X - 6.0 * Z + 2.0 * U
    found = regression({"a": X, "b": 2.0 * Z, "w": 0.25 * W}, y)
    assert found is not None
    b, a, w = found.influences
    assert [one.parameters for one in (b, a)] == [("b",), ("a",)]
    assert [one.slope for one in (b, a)] == pytest.approx([-3.0, 1.0])
    assert [one.effect for one in (b, a)] == pytest.approx([-6.0 * SIZE, SIZE])
    assert [one.standardised for one in (b, a)] == pytest.approx([-6.0 / math.sqrt(41.0), 1.0 / math.sqrt(41.0)])
    assert [one.share for one in (b, a, w)] == pytest.approx([36.0 / 41.0, 1.0 / 41.0, 0.0])
    assert found.explained == pytest.approx(37.0 / 41.0)
    assert found.runs == 16
    # the rest is 2 u: squares 64 over 12 degrees, t = 2.178813, and 1 / 15 of each scaled column
    half = 2.178813 * math.sqrt(64.0 / 12.0 / 15.0)
    assert [one.effect_half for one in (b, a, w)] == pytest.approx([half] * 3, rel=1e-6)


def test_factors_that_move_together_have_one_effect_along_the_first() -> None:
    """Of y = -3 x + z; b moves against a. What does nothing has no effect, and no name of another."""
    found = regression({"a": X, "b": -2.0 * X, "c": Z, "d": U}, -3.0 * X + Z)
    assert found is not None
    both, c, d = found.influences
    assert (both.parameters, c.parameters, d.parameters) == (("a", "b"), ("c",), ("d",))
    assert [one.effect for one in (both, c, d)] == pytest.approx([-3.0 * SIZE, SIZE, 0.0])
    assert (both.slope, c.slope) == pytest.approx((-3.0, 1.0))
    assert [one.share for one in (both, c)] == pytest.approx([0.9, 0.1])
    still = regression({"c": Z, "a": X, "b": -2.0 * X}, 5.0 * Z)
    assert still is not None
    assert {one.parameters: round(one.effect / SIZE, 9) for one in still.influences} == {("c",): 5.0, ("a", "b"): 0.0}


def test_the_joint_effect_of_a_group_has_the_part_of_each() -> None:
    """2 a + b with a and b nearly alike: their own combination explains all, their mean would not."""
    a, b = X + 0.05 * Z, X - 0.05 * Z
    found = regression({"a": a, "b": b}, 2.0 * a + b)
    assert found is not None
    (both,) = found.influences
    assert both.parameters == ("a", "b")
    assert found.explained == pytest.approx(1.0, abs=1e-9)


def test_factors_prepared_once_serve_where_no_value_is_missing() -> None:
    prepared = Columns({"a": X, "still": np.ones(16)})
    y = 2.0 * X + Z
    assert regression({}, y, prepared) == regression({"a": X}, y)
    y[3] = math.nan
    some = regression({"a": X}, y, prepared)
    assert some is not None
    assert some.runs == 15
    assert regression({"a": X[6:10]}, W[6:10] + X[6:10]) is not None, "a line, its scatter and one more"
    assert regression({"a": X[6:9]}, X[6:9]) is None
    assert regression({"a": X[:0]}, X[:0]) is None


def test_orthogonal_columns_of_any_size() -> None:
    for size in (1e-8, 1.0, 1e8):
        q, r = _orthogonal(size * np.array([[3.0, 1.0], [4.0, 2.0]]))
        assert q == pytest.approx(np.array([[0.6, -0.8], [0.8, 0.6]]))
        assert r == pytest.approx(size * np.array([[5.0, 2.2], [0.0, 0.4]]))
    q, r = _orthogonal(np.array([[1.0, 1.0, 1.0], [0.0, 1e-9, 0.0], [0.0, 0.0, 1e-15]]))
    assert q.tolist() == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.0]]
    assert r == pytest.approx(np.array([[1.0, 1.0, 1.0], [0.0, 1e-9, 0.0], [0.0, 0.0, 0.0]]))


SALTELLI = 'design = "saltelli"\nspread = { "adc.reference" = { uniform = 0.1 }, "source.value" = { uniform = 0.1 } }\n'
PLAIN, SPECIAL = [0.0, 2.0, 2.0, 0.0], [0.0, 2.0, 1.0, 3.0]
# f_A, f_B, f with the first, with the second of B: about the mean 1 the variance is 1 of both groups.
# First order mean f_B (f_i - f_A): 1 * 2 and 0; then 1 and 3. Total: half the mean square of f_A - f_i: 2, 0; 0.5, 4.5


def test_indices_and_their_intervals_by_resampling() -> None:
    """Of two plain groups and one special. One resample of 27 is of the special one alone: more than 2.5 %, not 5 %."""
    values = [*PLAIN, *PLAIN, *SPECIAL, 9.0]
    first, second = sobol_indices(study_result(SALTELLI, {"bias": [[value] for value in values]}), "bias")
    assert (first.parameter, second.parameter) == ("adc.reference", "source.value")
    assert (first.first, first.total) == pytest.approx((5.0 / 3.0, 1.5))
    assert (second.first, second.total) == pytest.approx((1.0, 1.5))
    assert (first.first_interval, first.total_interval) == ((1.0, 2.0), (0.5, 2.0))
    assert (second.first_interval, second.total_interval) == ((0.0, 3.0), (0.0, 4.5))


def test_indices_of_one_point_of_a_sweep_at_one_epoch() -> None:
    """Two groups are enough, in any order of the runs; one is not. A constant resample has no indices."""
    ages = 'epochs = { ages = ["0 h", "1 year"] }\n'
    wanted = [*SPECIAL, 1.0, 1.0, 1.0, 1.0]
    values = np.full((16, 2), 7.0)
    values[1::2, 1] = wanted
    result = study_result(SALTELLI + ages + SWEPT, {"bias": values})
    turned: Any = result.some(np.arange(15, -1, -1))
    for made in (result, turned):
        first, second = sobol_indices(made, "bias", 1, 1)
        assert (first.first, first.total) == pytest.approx((1.0, 0.5))
        assert (second.first, second.total) == pytest.approx((3.0, 4.5))
        assert first.first_interval == (1.0, 1.0)
    assert sobol_indices(result, "bias", 1, 0) == []
    assert sobol_indices(result, "bias", 0, 1) == []
    assert sobol_indices(result.some(result.numbers < 14), "bias", 1, 1) == []
    alike = study_result(SALTELLI, {"bias": [[value] for value in (1, 1, 2, 3, 1, 1, 4, 5)]})
    assert sobol_indices(alike, "bias") == [], "nothing varies but what is mixed"
