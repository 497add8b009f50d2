"""Variable projection: residual, gradient and optimum against definitions, Prony's start against exact laws."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.runner.design.fit.projection import (
    CONSTANT,
    DOUBLE,
    DOUBLE_AND_CONSTANT,
    DOUBLE_ROOT,
    LARGEST_EXPONENT,
    SINGLE,
    ExponentialFamily,
    Projected,
    _stationary,
    best,
    project,
    prony,
    refine,
)

X = np.linspace(-1.0, 1.0, 50)
FAMILIES = (CONSTANT, SINGLE, DOUBLE_ROOT, DOUBLE, DOUBLE_AND_CONSTANT)
NOISE = np.random.default_rng(3).standard_normal(50)
exponents = st.floats(-4.0, 4.0)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_residual_is_that_of_least_squares(family: ExponentialFamily) -> None:
    at = (-2.0, 1.5)[: family.exponents]
    waves = [np.exp(b * X) for b in at]
    columns = [X**power * (1.0 if of is None else waves[of]) for of, power in family.terms]
    expected = np.linalg.lstsq(np.stack(columns, axis=1), NOISE, rcond=None)[1][0]
    assert project(family, at, X, NOISE).squares == pytest.approx(expected, rel=1e-12)
    assert family.coefficients == len(at) + len(columns)


@given(exponents, exponents)
def test_gradient_against_differences(first: float, second: float) -> None:
    if abs(first - second) < 0.2:
        return
    v, step = np.cos(2.0 * X) + 0.1 * NOISE, 1e-5
    here = project(DOUBLE, (first, second), X, v)
    for k in range(2):
        ends = [project(DOUBLE, (first + s * (k == 0), second + s * (k == 1)), X, v).squares for s in (step, -step)]
        slope = (ends[0] - ends[1]) / (2.0 * step)
        assert -2.0 * here.jacobian[:, k] @ here.residual == pytest.approx(slope, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("family", FAMILIES[1:], ids=lambda family: family.name)
def test_no_start_nearby_is_lower_than_the_best(family: ExponentialFamily) -> None:
    v = 1.0 + X**2 - 0.3 * X**3 + 0.02 * NOISE
    lowest = best(family, X, v).at.squares
    dice = np.random.default_rng(4)
    for _ in range(20):
        start = np.sort(dice.uniform(-6.0, 6.0, family.exponents))
        assert refine(family, start.tolist(), X, v).at.squares >= lowest * (1.0 - 1e-9)


def test_many_rows_have_the_optimum_of_all_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    v = 1.0 + X**2 - 0.3 * X**3 + 0.05 * NOISE
    whole = best(DOUBLE, X, v)
    monkeypatch.setattr("proofmass.runner.design.fit.projection.CHOOSING", 12)
    chosen = best(DOUBLE, X[::-1], v[::-1])
    assert chosen.at.squares == pytest.approx(whole.at.squares, rel=1e-12)
    assert len(chosen.at.residual) == 50


def test_never_beyond_the_bound() -> None:
    step = np.where(X > 0.97, 1.0, 0.0)
    found = best(DOUBLE, X, step)
    assert max(map(abs, found.at.exponents)) <= LARGEST_EXPONENT


def test_says_when_it_is_not_there() -> None:
    far = refine(DOUBLE, (-LARGEST_EXPONENT, -LARGEST_EXPONENT + 1.0), X, np.exp(3.0 * X) + 0.1 * NOISE)
    near = refine(DOUBLE, (-1.0, 2.0), X, np.exp(3.0 * X) + np.exp(-X))
    assert near.converged
    assert near.at.exponents == pytest.approx((-1.0, 3.0), rel=1e-9)
    assert far.at.squares > near.at.squares


@given(st.floats(-5.0, -0.5), st.floats(0.5, 5.0), st.floats(0.1, 10.0), st.floats(0.1, 10.0))
def test_prony_finds_an_exact_law(falling: float, rising: float, first: float, second: float) -> None:
    x = np.linspace(-1.0, 1.0, 1025)
    found = prony(x, first * np.exp(falling * x) + second * np.exp(rising * x))
    assert found is not None
    assert found == pytest.approx((falling, rising), rel=2e-2)


def test_prony_knows_when_exponents_are_not_real() -> None:
    assert prony(X, np.cos(6.0 * X)) is None
    assert prony(X, np.zeros(50)) is None


def test_prony_takes_rows_in_any_order_and_twice() -> None:
    v = np.exp(-2.0 * X) + np.exp(X)
    twice = np.concatenate([X[::-1], X]), np.concatenate([v[::-1], v])
    straight, doubled = prony(X, v), prony(*twice)
    assert straight is not None
    assert doubled == pytest.approx(straight, rel=1e-12)
    assert math.isclose(straight[0], -2.0, rel_tol=0.02)


@pytest.mark.parametrize("size", [1.0, 1e-6, 1e6])
def test_where_an_iteration_has_arrived(size: float) -> None:
    """Nothing is left of the data, or what is left is at a right angle to what the exponents do."""

    def arrived(left: float, slack: float, cosine: float = 1.0) -> bool:
        residual = np.array([left * size, 0.0])
        column = 5.0 * np.array([[cosine], [np.sqrt(1.0 - cosine**2)]])
        return _stationary(Projected((1.0,), np.ones(1), residual, column), size, slack)

    assert arrived(0.9e-13, 1.0)
    assert not arrived(1.1e-13, 1.0)
    assert arrived(0.9e-12, 100.0), "ten times as much with a hundredfold slack, which is one of squares"
    assert not arrived(1.1e-12, 100.0)
    assert arrived(0.1, 1.0, 0.9e-8)
    assert not arrived(0.1, 1.0, 1.1e-8)
    assert arrived(0.1, 100.0, 0.9e-6)
