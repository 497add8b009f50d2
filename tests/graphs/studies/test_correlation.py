"""Correlated spread against the matrix that was asked for, and matrices that are none."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks.arithmetic.counter_random import normal_deviate
from proofmass.blocks.declaration.problem import Refusal
from proofmass.graphs.studies.correlation import correlation_of
from proofmass.graphs.studies.distributions import Spread

SPREAD = {name: Spread("normal", 1.0) for name in "abcd"} | {
    "e": Spread("uniform", 1.0),
    "f": Spread("normal", 1, truncated=3),
}


def test_the_factor_is_that_of_cholesky() -> None:
    made = correlation_of([("c", "a", 0.5), ("b", "c", -0.25)], SPREAD)
    matrix = np.array([[1.0, 0.0, 0.5], [0.0, 1.0, -0.25], [0.5, -0.25, 1.0]])
    assert made.names == ("a", "b", "c")
    factor = np.array([[*row, *[0.0] * (3 - len(row))] for row in made.factor])
    assert factor == pytest.approx(np.linalg.cholesky(matrix), rel=1e-14)


def test_deviates_have_the_correlations() -> None:
    pairs = {("a", "b"): 0.9, ("a", "c"): -0.5, ("b", "c"): -0.6}
    made = correlation_of([(*pair, value) for pair, value in pairs.items()], SPREAD)
    rows = [made.applied({n: normal_deviate(1, k, i, 0) for i, n in enumerate("abc")}) for k in range(5000)]
    found = np.corrcoef(np.array([[row[n] for n in "abc"] for row in rows]).T)
    for (first, second), value in pairs.items():
        error = (1.0 - value**2) / np.sqrt(5000)
        assert found["abc".index(first), "abc".index(second)] == pytest.approx(value, abs=4.0 * error)
    assert np.std([row["c"] for row in rows]) == pytest.approx(1.0, rel=4.0 / np.sqrt(10000))


def test_parameters_that_are_one_are_equal_and_share_what_others_are_to_them() -> None:
    """One mass in three blocks, with a spring that follows it in part and a fourth that runs against it."""
    made = correlation_of([("a", "b", 1.0), ("b", "c", -1.0), ("a", "d", 0.5)], SPREAD)
    assert dict(zip([pair[:2] for pair in made.pairs], [pair[2] for pair in made.pairs], strict=True)) == {
        ("a", "b"): 1.0, ("a", "c"): -1.0, ("b", "c"): -1.0, ("a", "d"): 0.5, ("b", "d"): 0.5, ("c", "d"): -0.5,
    }  # fmt: skip
    rows = [made.applied({n: normal_deviate(1, k, i, 0) for i, n in enumerate("abcd")}) for k in range(2000)]
    for row in rows:
        assert row["a"] == row["b"] == -row["c"]
    found = np.corrcoef([row["a"] for row in rows], [row["d"] for row in rows])[0, 1]
    assert found == pytest.approx(0.5, abs=4.0 * 0.75 / np.sqrt(2000))


@pytest.mark.parametrize(
    ("pairs", "said"),
    [
        ([("a", "b", 0.9), ("b", "c", 0.9), ("a", "c", -0.9)], "not positive definite"),
        ([("a", "b", 1.0), ("a", "c", 0.5), ("b", "c", 0.4)], "not positive definite"),
        ([("a", "b", 1.0), ("b", "c", 1.0), ("a", "c", -1.0)], "not positive definite"),
        ([("a", "e", 0.5)], "cannot be correlated"),
        ([("a", "f", 0.5)], "cannot be correlated"),
        ([("a", "z", 0.5)], "cannot be correlated"),
        ([("a", "a", 0.5)], "with itself"),
        ([("a", "b", 0.5), ("b", "a", 0.4)], "two coefficients"),
    ],
)
def test_what_is_no_correlation_is_refused(pairs: Any, said: str) -> None:
    with pytest.raises(Refusal, match=said):
        correlation_of(pairs, SPREAD)
