"""Polynomials of coordinates in balls, against exact fractions and functions of mpmath at random places."""

import itertools
import math
import random
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import flint
import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.elementary import sine_of_turns
from proofmass.blocks.arithmetic.rounding import nearest_integer
from proofmass.runner.derivatives.ball import Ball, UndecidedError, ball
from proofmass.runner.derivatives.dual import SIGNALS, dual, slopes_of
from proofmass.runner.derivatives.dual_functions import for_duals
from proofmass.runner.derivatives.dual_plan import dual_hold
from proofmass.runner.derivatives.polynomial import PolynomialBall, Turned
from proofmass.runner.derivatives.taylor_model import TaylorModel, monomials, order_kept
from tests.by_hand.taylor_models import number_at

X, Y = PolynomialBall.coordinate(1.0, 1.5, 0), PolynomialBall.coordinate(-3.0, -2.0, 1)


def places(seed: int) -> list[list[Fraction]]:
    draw = random.Random(seed)
    return [[Fraction(draw.randint(-64, 64), 64) for _ in range(2)] for _ in range(6)]


@pytest.mark.parametrize(
    "function",
    [
        lambda x, y: x * y - 3 + y * y * y,
        lambda x, y: (x - y) ** 3 * (x + 1) ** 4,  # beyond the order that is kept
        lambda x, y: (2 - x) / (y * y + x) - 1 / x,
        lambda x, y: abs(y) * abs(x) + x**0,
        lambda x, y: 1 / (x + 3 * y) ** 2 - (-x) ** -3,
    ],
)
def test_arithmetic_holds_the_exact_value(function: Callable[[Any, Any], Any]) -> None:
    found = function(X, Y)
    for d in places(1):
        exact = function(Fraction(5, 4) + d[0] / 4, Fraction(-5, 2) + d[1] / 2)
        assert number_at(found, d).contains(flint.arb(exact.numerator) / exact.denominator)


@pytest.mark.defect("C854", before="TypeError, which left claims about loops open", after="a quotient with its slope")
@pytest.mark.parametrize("number", [X, ball(1.0, 1.5)], ids=["polynomial", "ball"])
def test_a_dual_number_has_the_answer_to_its_left(number: Any) -> None:
    """A parameter over a signal, or beside one, follows the signal: d(x / s) = -x / s^2."""
    signal = dual(4.0, {"signal": 1.0}, SIGNALS)
    slopes = {
        "+": (number + signal, (1.0, 1.0)), "-": (number - signal, (-1.0, -1.0)), "*": (number * signal, (1.0, 1.5)),
        "/": (number / signal, (-1.5 / 16, -1.0 / 16)), "//": (number // signal, (-1.5 / 16, -1.0 / 16)),
        "%": (number % signal, (0.0, 0.0)),
    }  # fmt: skip
    for sign, (found, ends) in slopes.items():
        assert plain_ends(slopes_of(found, SIGNALS).get("signal", 0.0)) == pytest.approx(ends), sign
    assert number < signal
    assert number <= signal
    assert signal > number
    assert number != signal
    assert not number >= signal


def plain_ends(number: Any) -> tuple[float, float]:
    return number.ends() if isinstance(number, Ball) else (number, number)


def test_what_cancels_is_nothing() -> None:
    """A ball less itself is twice as wide, a polynomial is zero."""
    low, high = (X * Y - Y * X).ends()
    assert -1e-13 < low <= 0.0 <= high < 1e-13
    exact = Ball(flint.arb(3))
    assert all(isinstance(value, PolynomialBall) for value in (exact * X, exact + X, exact - X, exact / X, X * exact))
    assert X > 0
    assert Y * Y > X
    with pytest.raises(UndecidedError, match="comparison"):
        bool(X + Y / 2 > 0)


def oscillation(x: float, y: float) -> float:
    return math.sin(x * y) * math.exp(-x) / math.sqrt(-y) + math.log(x) * math.cbrt(x)


def test_functions_hold_their_values() -> None:
    found = for_duals(oscillation)(X, Y)
    for d in places(2):
        x, y = (
            mpmath.mpf(part.numerator) / part.denominator
            for part in (Fraction(5, 4) + d[0] / 4, Fraction(-5, 2) + d[1] / 2)
        )
        exact: Any = mpmath.sin(x * y) * mpmath.exp(-x) / mpmath.sqrt(-y) + mpmath.log(x) * mpmath.cbrt(x)
        assert number_at(found, d).contains(flint.arb(str(exact)))
    wide = for_duals(oscillation)(ball(1.0, 1.5), ball(-3.0, -2.0))
    assert number_at(found, [Fraction(0)] * 2).rad() < wide.arb.rad() / 2


def test_the_step_of_a_light_mode() -> None:
    """600 Hz within 1 %: known to a part in 1e8 at each place, where a ball has the whole range of phases."""
    stiffness, damping = PolynomialBall.coordinate(7.0e6, 7.2e6, 0), PolynomialBall.coordinate(1.5, 6.0, 1)
    rows: Any = [[0.0, 1.0], [stiffness * -2.0, damping * -2.0]]
    moved, entered = dual_hold(rows, [[0.0], [2.0]], 5e-4)
    for d in places(3):
        k, c = float(7.1e6 + 1e5 * d[0]), float(3.75 + 2.25 * d[1])
        exact = scipy.linalg.expm([[0.0, 5e-4, 0.0], [-1e-3 * k, -1e-3 * c, 1e-3], [0.0, 0.0, 0.0]])
        for i, (row, entry) in enumerate(zip(moved, entered, strict=True)):
            values = [number_at(value, d) for value in (*row, *entry)]
            unit = 3770.0**i  # rad/s
            assert [float(value.mid()) for value in values] == pytest.approx(exact[i].tolist(), abs=1e-9 * unit)
            assert all(float(value.rad()) < 1e-8 * unit for value in values)


def test_the_order_that_is_kept() -> None:
    """6 coordinates: two polynomials of order 5 have C(17, 5) = 6,188 pairs of terms up to there, of order 6 18,564."""
    assert [order_kept(count) for count in (0, 1, 5, 6, 8, 11, 30, 200)] == [6, 6, 6, 5, 4, 3, 2, 1]


def test_matrices_multiply_as_numbers_do() -> None:
    order = order_kept(2)
    left = TaylorModel(
        monomials([[0], [1]]), np.array([[[1.0, 2.0], [3.0, 4.0]], [[0.0, 1.0], [0.0, 0.0]]]), np.zeros((2, 2))
    )
    high = monomials([[0, 0], [order - 1, 0], [order - 1, 1]])
    right = TaylorModel(high, np.array([np.zeros((2, 2)), np.eye(2), [[2.0, 0.0], [0.0, 0.0]]]), np.zeros((2, 2)))
    found = left @ right
    terms = dict(zip(map(tuple, found.of.exponents.tolist()), found.coefficients.tolist(), strict=True))
    assert terms[order - 1, 0] == left.coefficients[0].tolist()
    assert terms[order, 0] == left.coefficients[1].tolist()
    assert terms[order - 1, 1] == [[2.0, 0.0], [6.0, 0.0]]
    assert found.radius == pytest.approx(np.zeros((2, 2)), abs=1e-13)
    last = TaylorModel(
        monomials([[0, 0], [0, order]]), np.array([np.zeros((2, 2)), [[0.0, 0.0], [2.0, 3.0]]]), np.zeros((2, 2))
    )
    beyond = left @ last
    assert beyond.radius[0] == pytest.approx([2.0, 3.0])  # |d_0 d_1^6| is at most 1
    assert beyond.radius[0].min() >= 2.0


@given(st.lists(st.floats(-1e3, 1e3), min_size=6, max_size=6), st.floats(0.0, 1.0))
def test_a_range_holds_all_values(coefficients: list[float], radius: float) -> None:
    """A square is never negative: 1 + d^2 lies between 1 and 2."""
    of = monomials([[0, 0], [0, 1], [1, 0], [0, 2], [1, 1], [2, 2]])
    low, high = PolynomialBall(TaylorModel(of, np.array(coefficients), radius)).ends()
    for d in itertools.product((-1.0, -0.375, 0.0, 0.5, 1.0), repeat=2):
        terms = (c * d[0] ** i * d[1] ** j for c, (i, j) in zip(coefficients, of.exponents.tolist(), strict=True))
        value = math.fsum(terms)
        assert low <= value - radius
        assert value + radius <= high
    square = PolynomialBall(TaylorModel(monomials([[0], [2]]), np.array([1.0, 1.0]), 0.0))
    assert square.ends() == pytest.approx((1.0, 2.0), rel=1e-8)


def test_sums_have_the_terms_of_both() -> None:
    """Also of coordinates that one of them does not know, in their order."""
    one, other = TaylorModel(monomials([[0], [2]]), np.array([1.0, 3.0]), 0.25), Y.model
    total = one + other
    assert total.of.exponents.tolist() == [[0, 0], [0, 1], [2, 0]]
    assert total.coefficients.tolist() == [1.0 + other.coefficients[0], other.coefficients[1], 3.0]
    assert total.radius == pytest.approx(0.25, rel=1e-11)
    assert total.radius >= 0.25
    assert (total - one).pruned.of is other.of


def test_what_has_no_bounds_is_refused() -> None:
    with pytest.raises(UndecidedError, match="may be zero"):
        1 / (X + Y / 2)
    with pytest.raises(UndecidedError, match="without bounds"):
        dual_hold([[X * 1e9]], [[0.0]], 1.0)
    with pytest.raises(UndecidedError, match="without bounds"):
        _ = (X + Ball(flint.arb("nan"))).arb
    with pytest.raises(TypeError, match="integer exponent"):
        _ = X**0.5
    assert isinstance(abs(X + Y / 2), Ball)
    assert PolynomialBall.coordinate(2.0, 2.0, 0).ends()[0] == pytest.approx(2.0)


def nearest_off(x: Any) -> Any:
    return x - nearest_integer(x)


def turned(x: Any) -> Any:
    return sine_of_turns(x)


def test_what_is_known_but_for_a_turn() -> None:
    """Half a turn or so: less the nearest whole number it is 0.45 to 0.5, or -0.5 to -0.4, and its sine is the same."""
    x = PolynomialBall.coordinate(0.45, 0.6, 0)
    left = for_duals(nearest_off)(x)
    assert isinstance(left, Turned)
    for place in (-1.0, -0.2, 0.7):
        value = 0.525 + 0.075 * place
        assert number_at(for_duals(turned)(left), [place]).contains(flint.arb(2 * value).sin_pi())
    for wrong in (
        lambda: left > 0.0,
        lambda: left * left,
        lambda: 1.0 / left,
        lambda: float(left.arb),
        lambda: abs(left),
    ):
        with pytest.raises(UndecidedError, match="known but for whole turns"):
            wrong()


def test_a_turn_that_is_missing_is_found_again() -> None:
    """Less 0.3 the number is 0.15 to 0.3 whichever turn was taken off; another number has another nearest one."""
    x = PolynomialBall.coordinate(0.45, 0.6, 0)
    again = for_duals(nearest_off)(for_duals(nearest_off)(x) - 0.3)
    assert isinstance(again, PolynomialBall)
    low, high = again.ends()
    assert (low, high) == pytest.approx((0.15, 0.3))
    assert isinstance(for_duals(nearest_off)(for_duals(nearest_off)(x) + 0.5), PolynomialBall)
    assert isinstance(for_duals(nearest_off)(for_duals(nearest_off)(x) + 1.0), Turned)
    nearest = for_duals(nearest_integer)(x)
    with pytest.raises(UndecidedError, match="in the middle between two whole ones"):
        nearest + 1.0
    with pytest.raises(UndecidedError, match="a whole number that is not known"):
        (x + 0.0) - nearest


def test_what_has_a_turn_of_its_own() -> None:
    """Two pi times the number is known but for two pi: no function of turns is known of it."""
    left = for_duals(nearest_off)(PolynomialBall.coordinate(0.45, 0.6, 0)) * (2.0 * math.pi)
    assert left.turn == 2.0 * math.pi
    with pytest.raises(UndecidedError):
        for_duals(turned)(left)
    with pytest.raises(UndecidedError):
        for_duals(nearest_off)(left)


def test_one_over_one_over_a_number_is_that_number() -> None:
    """Its series about the middle would be off by the sixth power of a quarter."""
    x = PolynomialBall.coordinate(0.75, 1.25, 0)
    assert 1.0 / (1.0 / x) is x
