"""Degrees of numbers in a factor: against plain numbers at some factors, and matrix exponentials of scipy."""

from collections.abc import Callable
from fractions import Fraction
from typing import Any

import flint
import numpy as np
import pytest
import scipy.linalg

from proofmass.blocks.arithmetic import elementary
from proofmass.runner.derivatives.ball import Ball, UndecidedError, arb_of, ball, enclosing, of_balls
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.homogeneous import (
    Homogeneous,
    degree_of,
    homogeneous_exponential,
    loop_degree,
)

FACTOR = ball(0.5, 2.0).arb
FACTORS = (0.5, 0.9, 1.0, 1.7, 2.0)


def number(part: float, degree: int = 1) -> Any:
    return Homogeneous(flint.arb(part), degree, FACTOR)


X, Y = number(3.0), number(-0.25, -2)


@pytest.mark.parametrize(
    ("count", "degree"),
    [
        (lambda x, y: x * y, -1),
        (lambda x, y: 4.0 * x, 1),
        (lambda x, _: x / 8, 1),
        (lambda x, y: y / x, -3),
        (lambda x, y: 2.0 / y, 2),
        (lambda x, y: x * x * y, 0),
        (lambda x, y: x - 5.0 * x, 1),
        (lambda x, y: -x + 0.0, 1),
        (lambda x, y: 0.0 - x, 1),
        (lambda x, y: x**3, 3),
        (lambda x, y: y**-2, 4),
        (lambda x, y: abs(y), -2),
        (lambda x, y: x + y, None),
        (lambda x, y: x + 1.0, None),
        (lambda x, y: 1.0 - x, None),
        (lambda x, y: (x + 1.0) * y, None),
        (lambda x, y: (x + 1.0) ** 2, None),
        (lambda x, y: 1.0 / (x + 1.0), None),
        (lambda x, y: -(x + 1.0), None),
        (lambda x, y: abs(x + 1.0), None),
        (lambda x, y: (x + 1.0) - x, None),
        (lambda x, y: x % 16.0, 1),
        (lambda x, y: elementary.exponential(x), None),
        (lambda x, y: elementary.arctangent2(1.0, x), None),
        (lambda x, y: elementary.sine(x * x * y), 0),
    ],
)
def test_a_degree_is_that_of_the_factor_and_what_is_enclosed_is_there(
    count: Callable[[Any, Any], Any], degree: int | None
) -> None:
    copied = for_duals(count)
    with enclosing():
        found = copied(X, Y)
        assert degree_of(found) == degree
        low, high = Ball(arb_of(found)).ends()
        for s in FACTORS:
            truth = count(3.0 * s, -0.25 * s**-2)
            assert low - 1e-12 <= truth <= high + 1e-12
            if degree is not None:
                part = found.part if isinstance(found, Homogeneous) else found.arb
                assert float(part.mid()) * s**degree == pytest.approx(truth, rel=1e-12)


@pytest.mark.parametrize("places", [(0, 1), (1, 0)])
@pytest.mark.parametrize("function", [elementary.arctangent2, elementary.power])
def test_a_function_of_two_numbers_has_no_degree_if_one_of_them_has(
    function: Callable[..., Any], places: tuple[int, int]
) -> None:
    numbers = X, Ball(flint.arb(2))
    with enclosing():
        assert degree_of(of_balls(function, *(numbers[place] for place in places))) is None
        assert degree_of(of_balls(function, numbers[1], numbers[1])) == 0


def test_zero_has_every_degree() -> None:
    zero = X * Ball(flint.arb(0))
    assert degree_of(zero + Y) == -2
    assert degree_of(Y - zero) == -2
    assert degree_of(X + Ball(flint.arb(0))) == 1
    assert X * 0.0 == 0.0


def test_comparisons_hold_for_every_factor_or_are_not_decided() -> None:
    """x is from 1.5 to 6."""
    assert X > 1.4
    assert not X >= 6.1
    for unknown in (lambda: X > 2.0, lambda: round(X), lambda: 1.0 / (X - 2.0), lambda: number(0.0) ** -1):
        with pytest.raises(UndecidedError):
            unknown()


@pytest.mark.parametrize("degrees", [(0, 1, -2), (2, 2, 0)])
def test_the_exponential_of_a_matrix_in_units_of_a_factor_has_these_units(degrees: tuple[int, ...]) -> None:
    """S exp(A) S^-1 = exp(S A S^-1), with powers of the factor in S."""
    a = np.array([[-1.0, 0.5, 0.0], [0.25, -0.5, 0.125], [0.0, 2.0, -3.0]])
    rows = [
        [number(a[i, j], degrees[i] - degrees[j]) if i != j else a[i, i] for j in range(3)] for i in range(2)
    ]  # the last is an input
    with enclosing():
        found = homogeneous_exponential(rows, 0.5)
    for s in FACTORS:
        units = np.power(s, np.array(degrees, dtype=float))
        truth = scipy.linalg.expm(0.5 * np.vstack([(a * units[:, None] / units)[:2], np.zeros(3)]))
        for i, row in enumerate(found[:2]):
            for j, value in enumerate(row):
                part = value.part if isinstance(value, Homogeneous) else value.arb
                assert degree_of(value) == degrees[i] - degrees[j]
                assert float(part.mid()) * s ** (degrees[i] - degrees[j]) == pytest.approx(truth[i, j], rel=1e-12)


def test_the_exponential_of_a_matrix_without_units_is_known_as_balls_alone() -> None:
    """exp of [[x, 1], [0, 0]] has (e^x - 1) / x beside e^x."""
    with enclosing():
        ((power, beside), _) = homogeneous_exponential([[number(1.0), 1.0]], 1.0)
    for value, least, most in ((power, np.exp(0.5), np.exp(2.0)), (beside, np.expm1(0.5) / 0.5, np.expm1(2.0) / 2.0)):
        assert degree_of(value) is None
        assert value.ends()[0] <= least
        assert most <= value.ends()[1]


ONE = Ball(flint.arb(1))


@pytest.mark.parametrize(
    ("rows", "order", "degree"),
    [
        ([[1.0, number(3.0)], [2.0, 0.0]], 1, 1),  # x' = x + 3 s u, y = 2 x
        ([[1.0, number(3.0)], [number(2.0, -1), 0.0]], 1, 0),  # what multiplies there divides here
        ([[1.0, number(3.0)], [number(2.0, 2), number(1.0, 3)]], 1, 3),  # beside the state straight through
        ([[1.0, number(3.0)], [number(2.0, 2), number(1.0, 2)]], 1, None),
        ([[number(0.5), 1.0], [1.0, 0.0]], 1, None),  # a pole that moves
        ([[0.5, number(1.0), 1.0], [number(0.1, -1), 0.5, 0.0], [1.0, 0.0, 0.0]], 2, 0),  # units of a state
        ([[0.5, number(1.0), 1.0], [number(0.1, 1), 0.5, 0.0], [1.0, 0.0, 0.0]], 2, None),
        ([[0.0, number(1.0), 1.0], [1.0, 0.0, 0.0], [number(1.0, -1), number(1.0, 1), 0.0]], 2, None),
        ([[1.0, X + 1.0], [1.0, 0.0]], 1, None),
        ([[1.0, ONE], [0.0, 0.0]], 1, None),  # a loop that is open
        ([[0.0, number(2.0)], [1.0, 0.0]], 0, Fraction(1, 2)),  # once in two turns
    ],
)
def test_the_degree_of_a_loop_is_that_of_all_ways_round(
    rows: list[list[Any]], order: int, degree: Fraction | None
) -> None:
    assert loop_degree(rows, order) == degree
