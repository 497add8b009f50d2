"""Dual numbers against closed forms, complex steps of polynomials and each other's nesting."""

import math
import operator
from typing import get_args

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.arithmetic.mantissa import Drop, Rounding, rounded
from proofmass.runner.derivatives.dual import Dual, dual, plain, slopes_of, value_of, with_errors

numbers = st.floats(-100.0, 100.0).filter(lambda v: abs(v) > 1e-3)


@given(numbers, numbers)
def test_the_four_operations(a: float, b: float) -> None:
    x, y = dual(a, {"x": 1.0}), dual(b, {"y": 1.0})
    expected = {
        operator.add: (a + b, 1.0, 1.0),
        operator.sub: (a - b, 1.0, -1.0),
        operator.mul: (a * b, b, a),
        operator.truediv: (a / b, 1.0 / b, -a / b**2),
    }
    for operation, (value, by_x, by_y) in expected.items():
        found = operation(x, y)
        assert plain(found) == value
        assert slopes_of(found) == pytest.approx({"x": by_x, "y": by_y}, rel=1e-14)
        for left, right in ((a, y), (x, b)):  # a plain number on one side
            mixed = operation(left, right)
            assert plain(mixed) == pytest.approx(value, rel=1e-15)
            (name,) = slopes_of(mixed)
            assert slopes_of(mixed)[name] == pytest.approx({"x": by_x, "y": by_y}[name], rel=1e-14)


@given(numbers)
def test_powers_and_signs(a: float) -> None:
    x = dual(a, {"x": 1.0})
    assert slopes_of(x**3)["x"] == pytest.approx(3.0 * a * a)
    assert slopes_of(-x)["x"] == -1.0
    assert +x is x
    assert plain(abs(x)) == abs(a)
    assert slopes_of(abs(x))["x"] == (1.0 if a > 0.0 else -1.0)
    with pytest.raises(TypeError, match="integer exponent"):
        x**0.5


def test_what_depends_on_nothing_is_plain() -> None:
    x = dual(2.0, {"x": 1.0})
    assert type(x - x) is float
    assert type(0.0 * x) is float
    assert dual(3, {}) == 3
    assert not isinstance(dual(3, {"x": 0.0}), Dual)


def test_comparisons_are_of_values() -> None:
    x, y = dual(2.0, {"x": 1.0}), dual(3.0, {"y": 1.0})
    assert x < y
    assert x <= 2.0
    assert y > 2
    assert y >= x
    assert x == 2.0
    assert x != y
    assert bool(x)
    assert not dual(0.0, {"x": 1.0})


def test_integers_stay_dual_and_quantisers_count_as_their_input() -> None:
    code = dual(21, {"x": 2.0})
    assert slopes_of(code << 3) == {"x": 16.0}
    assert slopes_of(code >> 2) == {"x": 0.5}
    assert plain(code >> 2) == 21 / 4
    assert slopes_of(code // 4) == {"x": 0.5}
    assert slopes_of(round(code / 4)) == {"x": 0.5}
    assert plain(code % 8) == 5
    assert slopes_of(code % 8) == {"x": 2.0}
    assert (plain(code ^ 0), slopes_of(code ^ 0)) == (21, {"x": 2.0})
    assert (plain(code ^ -1), slopes_of(code ^ -1)) == (21 ^ -1, {"x": -2.0})
    assert (plain(~code), slopes_of(~code)) == (~21, {"x": -2.0})
    assert (code & 0, slopes_of(code & -1), -1 | code, slopes_of(0 | code)) == (0, {"x": 2.0}, -1, {"x": 2.0})
    for operation in (operator.and_, operator.or_, operator.lshift, operator.rshift):
        for pair in ((code, 3), (3, code))[operation in (operator.lshift, operator.rshift) :]:
            with pytest.raises(TypeError, match="bits"):
                operation(*pair)
    with pytest.raises(TypeError, match="bits"):
        code ^ 5
    with pytest.raises(TypeError):
        [0, 1, 2][dual(1, {"x": 1.0})]  # an index has no derivative


@given(numbers, numbers)
def test_levels_give_mixed_second_derivatives(a: float, b: float) -> None:
    p = dual(a, {"p": 1.0}, 0)
    x = dual(b, {"x": 1.0}, 1)
    f = x * x * p / (1.0 + p * p) + x * p
    by_x = slopes_of(f, 1)["x"]
    assert plain(by_x) == pytest.approx(2.0 * b * a / (1.0 + a * a) + a, rel=1e-12, abs=1e-12)
    mixed = 2.0 * b * (1.0 - a * a) / (1.0 + a * a) ** 2 + 1.0
    assert slopes_of(by_x, 0)["p"] == pytest.approx(mixed, rel=1e-9, abs=1e-9)
    by_p = slopes_of(f, 0)["p"]
    assert by_p == pytest.approx(b * b * (1.0 - a * a) / (1.0 + a * a) ** 2 + b, rel=1e-9, abs=1e-9)
    assert plain(value_of(f, 1)) == plain(f)
    assert slopes_of(value_of(f, 1), 0) == slopes_of(f, 0)
    assert not isinstance(value_of(f, 0), Dual)


def test_remainders_of_a_plain_number() -> None:
    """7 % x = 7 - 3 x close to x = 2: the count of wholes stands still."""
    found = 7.0 % dual(2.25, {"x": 1.0})
    assert (plain(found), slopes_of(found)) == (0.25, {"x": -3.0})


@pytest.mark.parametrize(("value", "lowest", "highest", "held"), [(9, -8, 7, -7), (9, 0, 15, 9), (-9.5, -8, 7, 6.5)])
def test_a_register_that_wraps_takes_off_whole_turns(value: float, lowest: int, highest: int, held: float) -> None:
    found = dual(value, {"x": 2.0}).wrapped(lowest, highest)
    assert (plain(found), slopes_of(found)) == (held, {"x": 2.0})


@pytest.mark.defect("C2", before="ZeroDivisionError", after="powers of 0 have slopes")
def test_powers_of_zero() -> None:
    x = dual(0.0, {"x": 1.0})
    assert x**0 == 1.0
    assert slopes_of(x**1) == {"x": 1.0}
    assert slopes_of(x**2) == {}


def test_a_corner_has_no_slope_until_it_is_multiplied_by_zero() -> None:
    x = dual(0.0, {"x": 1.0})
    assert math.isnan(slopes_of(abs(x))["x"])
    assert slopes_of(0.0 * abs(x)) == {}
    assert slopes_of(x * abs(x)) == {}  # x |x| has the slope 2 |x|


@pytest.mark.parametrize("rounding", get_args(Rounding))
@pytest.mark.parametrize("dropped", [1, 2, 3, 8])
def test_a_rounding_tells_what_it_drops(rounding: Rounding, dropped: int) -> None:
    seen: list[Drop] = []

    def noted(value: Dual, drop: Drop) -> Dual:
        seen.append(Drop.of_code(drop.code))
        return value

    with with_errors(noted):
        found = rounded(dual(3.0 * 2**dropped, {"x": 2.0}), dropped, rounding)
    assert (plain(found), slopes_of(found)) == (3.0, {"x": 2.0 / 2**dropped})
    assert seen == [Drop(dropped, rounding)]
