"""Whiteness of residuals, and what recordings say of unknowns, worked out by hand."""

import math
from typing import Any

import numpy as np
import pytest

from proofmass.runner.design.identification.identifiable import certainty
from proofmass.runner.design.identification.unknowns import Unknown
from proofmass.runner.design.identification.whiteness import Whiteness, whiteness


def test_autocorrelations_of_a_saw() -> None:
    """1, -1, 1 ... about its mean: -7 / 8 and 6 / 8 of eight values, and the statistic 8 * 10 (49 / 448 + 36 / 384)."""
    found = whiteness(10.0 + np.array([1.0, -1.0] * 4))
    assert found.autocorrelation == pytest.approx([-7.0 / 8.0, 6.0 / 8.0])
    assert found.chance == pytest.approx(math.exp(-0.5 * 80.0 * (49.0 / 448.0 + 36.0 / 384.0)))  # two degrees


@pytest.mark.parametrize(("rows", "lags"), [(3, 0), (4, 1), (7, 1), (79, 19), (80, 20), (84, 20)])
def test_a_quarter_of_the_rows_are_lags_twenty_at_most(rows: int, lags: int) -> None:
    assert len(whiteness(np.arange(float(rows))).autocorrelation) == lags


def test_nothing_left_is_white() -> None:
    nothing = whiteness(np.full(80, 2.5))
    assert (len(nothing.autocorrelation), nothing.chance, nothing.white) == (0, 1.0, True)


def test_standard_errors_are_too_small_by_the_sum_of_all_correlations() -> None:
    positive, negative = np.array([0.75, 0.75]), np.array([-0.75, -0.25])
    assert Whiteness(positive, 0.0099).widening == 2.0
    assert Whiteness(negative, 0.0099).widening == 1.0
    assert Whiteness(positive, 0.01).widening == 1.0, "white at the level itself"


def unknowns(*starts: float) -> list[Unknown]:
    return [Unknown(name, f"{name}!", "1", start) for name, start in zip("abc", starts, strict=False)]


def said(jacobian: Any, *values: float) -> tuple[list[float], list[str]]:
    found = certainty(np.array(jacobian, dtype=float), np.array(values), unknowns(*values))
    return found.errors.tolist(), list(found.findings)


def test_errors_and_correlations_of_two_unknowns() -> None:
    """(J'J)^-1 of [[10, 0], [10, 20]] is [[400, -200], [-200, 200]] / 40000."""
    found = certainty(np.array([[10.0, 0.0], [10.0, 20.0]]), np.array([1.0, -2.0]), unknowns(1.0, -2.0))
    assert found.errors == pytest.approx([0.1, math.sqrt(0.005)])
    assert found.correlation == pytest.approx(np.array([[1.0, -1.0 / math.sqrt(2.0)], [-1.0 / math.sqrt(2.0), 1.0]]))
    assert found.findings == ()


def test_a_value_of_zero_is_measured_by_the_scale_of_its_unknown() -> None:
    found = certainty(np.array([[4.0]]), np.array([0.0]), [Unknown("a", "a", "1", 3.0)])
    assert found.errors == pytest.approx([0.25])


@pytest.mark.parametrize(
    ("jacobian", "errors", "finding"),
    [
        ([[10.0, 0.0], [0.0, 0.0]], [0.1, math.inf], "b! changes nothing in these recordings"),
        ([[10.0, 0.0], [0.0, 1.5]], [0.1, math.inf], "b! is known to 67 % of its size only in these recordings"),
        ([[10.0, 0.0], [0.0, 0.5]], [0.1, math.inf], "b! is known to 2e+02 % of its size only in these recordings"),
        ([[10.0, 0.0], [0.0, 2.1]], [0.1, 1.0 / 2.1], ""),
        ([[1e5, 0.0], [0.0, 5.0]], [1e-5, 0.2], ""),
        ([[1e12, 0.0], [0.0, 50.0]], [1e-12, math.inf], "b! is known to 2 % of its size only in these recordings"),
        (
            [[9.58, -10.0]],  # parts of 0.722 and 0.692 differ by 0.03
            [math.inf] * 2,
            "a! and b! together; changing a! by +100 %, b! by +96 % changes nothing",
        ),
        ([[10.0, 10.0]], [math.inf] * 2, "raising a! and lowering b! by the same factor changes nothing"),
        (
            [[10.0, -10.0]],
            [math.inf] * 2,
            "a! and b!, all raised by the same factor, change nothing: only their ratio is determined",
        ),
        (
            [[10.0, -20.0]],
            [math.inf] * 2,
            "a! and b! together; changing a! by +100 %, b! by +50 % changes nothing",
        ),
        (
            [[10.0, -10.0, 0.0], [0.0, 10.0, -10.0]],
            [math.inf] * 3,
            "a!, b! and c!, all raised by the same factor, change nothing: only their ratios are determined",
        ),
    ],
)
def test_combinations_that_recordings_do_not_determine(
    jacobian: list[list[float]], errors: list[float], finding: str
) -> None:
    rows = np.vstack([jacobian, np.zeros((len(jacobian[0]) - len(jacobian), len(jacobian[0])))])
    found, findings = said(rows, *[1.0] * len(errors))
    assert found == pytest.approx(errors)
    told = [" ".join(sorted(one.split())) for one in findings]
    assert told == ([" ".join(sorted(f"not identifiable: {finding}".split()))] if finding else [])


def test_only_unknowns_with_a_fifth_of_a_combination_take_part() -> None:
    """Of (1, -0.15, 0) the second has 0.148; of (1, -0.25, 0) it has 0.243."""
    for part, members in ((0.15, 1), (0.25, 2)):
        normal = np.array([[part, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
        errors, findings = said(100.0 * normal, 1.0, 1.0, 1.0)
        assert [math.isinf(error) for error in errors] == [True, members == 2, False]
        assert errors[2] == pytest.approx(0.01)
        assert len(findings) == 1
