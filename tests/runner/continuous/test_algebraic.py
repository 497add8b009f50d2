"""Newton's method on algebraic loops: bits of linear ones, scipy.optimize.brentq for others."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import brentq

from proofmass.runner.continuous.algebraic import scratch, solve


def solved(equations: Any, guess: list[float]) -> list[float]:
    unknown = list(guess)
    solve(equations, None, unknown, tuple([0.0] * n for n in scratch(len(guess))))
    return unknown


finite = st.floats(-100.0, 100.0, allow_nan=False)


@given(st.lists(finite, min_size=4, max_size=4), st.lists(finite, min_size=2, max_size=2), st.integers(-300, 300))
def test_linear_loops_scale_by_powers_of_two_and_change_sign_to_the_bit(
    matrix: list[float], right: list[float], power: int
) -> None:
    """So a group with a linear loop is found to be linear."""

    def loop(factor: float) -> list[float]:
        def equations(context: None, u: list[float], found: list[float]) -> None:
            for i in range(2):
                found[i] = matrix[2 * i] * u[0] + matrix[2 * i + 1] * u[1] + factor * right[i]

        return solved(equations, [0.0, 0.0])

    once = loop(1.0)
    if not math.isnan(once[0]) and min((abs(v) for v in (*matrix, *right, *once) if v != 0.0), default=1.0) > 1e-6:
        for factor in (-1.0, 2.0**power):
            assert loop(factor) == [factor * value for value in once]


@given(st.floats(-1e3, 1e3), st.floats(0.1, 10.0), st.floats(-50.0, 50.0))
def test_a_cubic_from_any_guess(right: float, factor: float, guess: float) -> None:
    def equations(context: None, u: list[float], found: list[float]) -> None:
        found[0] = right - factor * u[0] * u[0] * u[0]

    (value,) = solved(equations, [guess])
    expected = brentq(lambda u: right - factor * u**3 - u, -1e5, 1e5, xtol=1e-15, rtol=1e-15)
    assert value == pytest.approx(expected, rel=1e-12, abs=1e-14 * (1.0 + abs(right) + factor * abs(guess) ** 3))


@pytest.mark.parametrize("size", [1e-12, 1.0, 1e12])
def test_a_value_that_is_zero_at_first(size: float) -> None:
    """u = s + 3 v and v = 3 u: both are known only together."""

    def equations(context: None, u: list[float], found: list[float]) -> None:
        found[:] = size + 3.0 * u[1], 3.0 * u[0]

    assert solved(equations, [0.0, 0.0]) == pytest.approx([-size / 8.0, -3.0 * size / 8.0], rel=1e-12)


@pytest.mark.parametrize("beside", [0.0, 1e3])
def test_slopes_are_those_at_the_size_of_a_value(beside: float) -> None:
    """Of u = 1 + 3 tanh u in small units it is the root to which its slope at zero leads, beside a large value too."""
    unit = 1e-10

    def equations(context: None, u: list[float], found: list[float]) -> None:
        steep = 3.0 * unit * math.tanh(u[1] / unit)
        found[:] = (beside, unit + steep) if beside else (unit, u[0] + steep)

    root = brentq(lambda u: 1.0 + 3.0 * math.tanh(u) - u, -1.0, -0.1)
    assert solved(equations, [0.0, 0.0])[1] == pytest.approx(unit * root, rel=1e-9)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_loop_may_have_no_value_beyond_zero(sign: float) -> None:
    """u = 1 + u^1.5 / 4 from zero, or of the opposite sign: no power of what is below."""

    def equations(context: None, u: list[float], found: list[float]) -> None:
        found[0] = sign * (1.0 + (sign * u[0]) ** 1.5 / 4.0) if sign * u[0] >= 0.0 else math.nan

    root = brentq(lambda u: 1.0 + u**1.5 / 4.0 - u, 1.0, 2.0, xtol=1e-15)
    assert solved(equations, [0.0]) == pytest.approx([sign * root], rel=1e-12)


def test_a_solution_that_is_a_small_difference_of_large_numbers() -> None:
    """Its last digits are rounding of what it is made of; it is found all the same."""

    def equations(context: None, u: list[float], found: list[float]) -> None:
        found[0] = (1.0 + 1e-9 - 0.5 * u[0]) - 1.0

    (value,) = solved(equations, [1e-9])
    assert value == pytest.approx(1e-9 / 1.5, rel=1e-6)
