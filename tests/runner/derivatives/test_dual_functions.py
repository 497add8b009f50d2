"""Elementary functions on dual numbers, against mpmath, and what has no slope."""

import math
from typing import Any

import mpmath
import pytest

from proofmass.blocks.arithmetic import elementary, rounding
from proofmass.runner.derivatives.dual import SIGNALS, dual, plain, slopes_of
from proofmass.runner.derivatives.dual_functions import dual_math, for_duals


@pytest.mark.parametrize(
    ("function", "exact", "arguments"),
    [
        (elementary.sine_of_turns, lambda x: mpmath.sin(2 * mpmath.pi * x), (0.0, 0.2, 0.25, 0.6, -0.37, 1000.125)),
        (elementary.cosine_of_turns, lambda x: mpmath.cos(2 * mpmath.pi * x), (0.1, 0.25, 0.6, -0.37, 1000.125)),
        (elementary.logarithm_of_fraction, mpmath.log, (1e-18, 1e-6, 0.3, 0.71, 0.999)),
        (elementary.logarithm_of_one_plus, lambda x: mpmath.log(1 + x), (1e-12, 1e-3, 0.4, 1.7, 1e5, 1e15)),
        (elementary.exponential, mpmath.exp, (-300.0, -1.0, 0.0, 1e-9, 0.4, 20.0, 300.0)),
        (elementary.exponential_less_one, mpmath.expm1, (-3.0, 1e-9, 0.4, 20.0)),
        (elementary.sine, mpmath.sin, (0.2, -4.0, 1e7)),
        (elementary.cosine, mpmath.cos, (0.2, -4.0, 1e7)),
        (elementary.tangent, mpmath.tan, (0.2, -4.0)),
        (elementary.arctangent, mpmath.atan, (-2.0, 0.3)),
        (elementary.arcsine, mpmath.asin, (-0.9, 0.3)),
        (elementary.arccosine, mpmath.acos, (-0.9, 0.3)),
        (elementary.logarithm, mpmath.log, (1e-3, 0.4, 1e5)),
        (elementary.binary_logarithm, lambda x: mpmath.log(x, 2), (0.4, 1e5)),
        (elementary.decimal_logarithm, mpmath.log10, (0.4, 1e5)),
        (elementary.hyperbolic_sine, mpmath.sinh, (-0.3, 2.0)),
        (elementary.hyperbolic_cosine, mpmath.cosh, (-0.3, 2.0)),
        (elementary.hyperbolic_tangent, mpmath.tanh, (-0.3, 2.0)),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_elementary_functions_and_two_derivatives(function: Any, exact: Any, arguments: tuple[float, ...]) -> None:
    with mpmath.workdps(60):
        for x in arguments:
            found = for_duals(function)(dual(dual(x, {"x": 1.0}, 0), {"x": 1.0}, 1))
            first, second = mpmath.diff(exact, mpmath.mpf(x)), mpmath.diff(exact, mpmath.mpf(x), 2)
            assert plain(found) == function(x)
            assert plain(slopes_of(found, 1).get("x", 0.0)) == pytest.approx(float(first), rel=1e-14, abs=1e-13)
            got = slopes_of(slopes_of(found, 1).get("x", 0.0), 0).get("x", 0.0)
            assert got == pytest.approx(float(second), rel=1e-11, abs=1e-11)


@pytest.mark.parametrize(
    ("function", "exact", "x", "y"),
    [
        (elementary.arctangent2, mpmath.atan2, 0.3, -2.0),
        (elementary.arctangent2, mpmath.atan2, -3.0, -0.2),
        (elementary.hypotenuse, mpmath.hypot, 3.0, -0.4),
        (elementary.power, mpmath.power, 1.7, -2.3),
        (elementary.power, mpmath.power, 0.2, 3.0),
    ],
)
def test_elementary_functions_of_two_numbers(function: Any, exact: Any, x: float, y: float) -> None:
    """Slopes by both numbers, and the mixed one of two levels."""
    found = for_duals(function)(dual(x, {"x": 1.0}, 0), dual(y, {"y": 1.0}, 1))
    with mpmath.workdps(60):
        at = (mpmath.mpf(x), mpmath.mpf(y))
        assert plain(found) == function(x, y)
        assert slopes_of(found)["x"] == pytest.approx(float(mpmath.diff(exact, at, (1, 0))), rel=1e-13)
        assert plain(slopes_of(found, 1)["y"]) == pytest.approx(float(mpmath.diff(exact, at, (0, 1))), rel=1e-13)
        mixed = slopes_of(slopes_of(found, 1)["y"])["x"]
        assert mixed == pytest.approx(float(mpmath.diff(exact, at, (1, 1))), rel=1e-12)
    one_level = for_duals(function)(dual(x, {"x": 1.0}), dual(y, {"y": 1.0}))
    assert slopes_of(one_level) == {"x": slopes_of(found)["x"], "y": plain(slopes_of(found, 1)["y"])}


ARGUMENTS = {"acosh": (1.5, 30.0), "default": (0.2, 0.7), "sin": (0.2, -4.0), "exp": (-3.0, 5.0), "atan": (-2.0, 0.3)}
FUNCTIONS = (
    "sqrt cbrt exp exp2 expm1 log log2 log10 log1p sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh erf erfc"
)


@pytest.mark.parametrize("name", [*FUNCTIONS.split(), "degrees", "radians"])
def test_functions_of_math(name: str) -> None:
    exact: Any = getattr(mpmath, name, None) or {
        "log2": lambda x: mpmath.log(x, 2),
        "exp2": lambda x: mpmath.mpf(2) ** x,
        "asin": mpmath.asin,
    }.get(name)
    for x in ARGUMENTS.get(name, ARGUMENTS["default"]):
        found = getattr(dual_math, name)(dual(x, {"x": 1.0}))
        assert plain(found) == getattr(math, name)(x)
        assert getattr(dual_math, name)(x) == getattr(math, name)(x)
        assert slopes_of(found)["x"] == pytest.approx(float(mpmath.diff(exact, x)), rel=1e-12)


@pytest.mark.parametrize(
    ("name", "x", "y"),
    [("atan2", 0.3, -2.0), ("atan2", -3.0, -0.2), ("hypot", 3.0, -0.4), ("pow", 1.7, -2.3), ("fmod", 7.3, 2.0),
     ("copysign", 2.0, -1.0)],
)  # fmt: skip
def test_functions_of_two_numbers(name: str, x: float, y: float) -> None:
    function = getattr(math, name)
    found = getattr(dual_math, name)(dual(x, {"x": 1.0}), dual(y, {"y": 1.0}))
    assert plain(found) == pytest.approx(function(x, y), rel=1e-15)
    h = 1e-6
    by_x = (function(x + h, y) - function(x - h, y)) / (2 * h)
    assert slopes_of(found)["x"] == pytest.approx(by_x, rel=1e-8)
    if name != "fmod":
        by_y = (function(x, y + h) - function(x, y - h)) / (2 * h)
        assert slopes_of(found).get("y", 0.0) == pytest.approx(by_y, rel=1e-8, abs=1e-9)
    assert getattr(dual_math, name)(x, y) == function(x, y)


def test_scaling_and_counting() -> None:
    x = dual(-2.75, {"x": 1.0})
    assert [f(x) for f in (dual_math.floor, dual_math.ceil)] == [-3, -2]
    assert dual_math.trunc(x) is x
    mantissa, exponent = dual_math.frexp(x)
    assert (plain(mantissa), exponent) == math.frexp(-2.75)
    assert slopes_of(mantissa) == {"x": 0.25}
    assert slopes_of(dual_math.ldexp(x, 4)) == {"x": 16.0}
    assert slopes_of(dual_math.fsum([x, 1.0, x])) == {"x": 2.0}
    assert dual_math.fsum([0.1] * 10) == 1.0
    assert slopes_of(dual_math.fabs(x)) == {"x": -1.0}
    assert dual_math.isfinite(x)
    assert not dual_math.isfinite(dual(math.inf, {"x": 1.0}))


def test_quantisers_and_counts_are_told_apart() -> None:
    def quantised(value: float) -> int:
        return int(rounding.round_half_even(value))

    def turns(value: float) -> float:
        return value - rounding.nearest_integer(value)

    x = dual(2.6, {"x": 3.0})
    assert for_duals(quantised)(2.6) == 3
    assert repr(for_duals(quantised)(x)) == "Dual(3.0, {'x': 3.0})"  # as in the run: a parameter moves it
    signal = dual(x, {"y": 1.0}, SIGNALS)
    assert repr(for_duals(quantised)(signal)) == repr(signal)
    assert slopes_of(for_duals(turns)(x)) == {"x": 3.0}
    assert plain(for_duals(turns)(x)) == pytest.approx(-0.4)


def test_helpers_recursion_defaults_and_inner_functions() -> None:
    def power(base: float, exponent: int) -> float:
        return base * power(base, exponent - 1) if exponent else 1.0

    globals()["power"] = power

    def through(value: float, *, times: int = 3) -> float:
        return sum(math.exp(v) for v in [power(value, times)])

    found = for_duals(through)(dual(0.5, {"x": 1.0}))
    assert slopes_of(found)["x"] == pytest.approx(3 * 0.25 * math.exp(0.125))


@pytest.mark.defect("C2", before="ZeroDivisionError or ValueError", after="a value without a slope")
@pytest.mark.parametrize(
    ("name", "arguments"),
    [("sqrt", (0.0,)), ("cbrt", (0.0,)), ("asin", (1.0,)), ("acos", (1.0,)), ("acosh", (1.0,)), ("pow", (0.0, 0.5)),
     ("atan2", (0.0, 0.0)), ("hypot", (0.0, 0.0)), ("fabs", (0.0,))],
)  # fmt: skip
def test_where_there_is_no_slope(name: str, arguments: tuple[float, ...]) -> None:
    function, x = getattr(dual_math, name), dual(arguments[0], {"x": 1.0})
    found = function(x, *arguments[1:])
    assert plain(found) == getattr(math, name)(*arguments)
    assert math.isnan(slopes_of(found)["x"])
    assert slopes_of(0.0 * found) == {}  # what is multiplied by nothing does nothing
    nested = function(dual(x, {"y": 1.0}, 1), *arguments[1:])
    assert math.isnan(plain(slopes_of(nested, 1)["y"]))


@pytest.mark.parametrize(
    ("function", "arguments"),
    [(elementary.arcsine, (1.0,)), (elementary.arccosine, (2.0,)), (elementary.power, (0.0, 0.5)),
     (elementary.arctangent2, (0.0, 0.0)), (elementary.hypotenuse, (0.0, 0.0)), (elementary.logarithm, (0.0,))],
)  # fmt: skip
def test_where_elementary_functions_have_no_slope(function: Any, arguments: tuple[float, ...]) -> None:
    found = for_duals(function)(dual(arguments[0], {"x": 1.0}), *arguments[1:])
    assert repr(plain(found)) == repr(function(*arguments))
    assert math.isnan(slopes_of(found)["x"])


def test_powers_of_ours_at_zero() -> None:
    power, x, y = for_duals(elementary.power), dual(0.0, {"x": 1.0}), dual(1.5, {"y": 1.0})
    assert power(x, 1.5) == 0.0
    assert slopes_of(power(x, 1.0)) == {"x": 1.0}
    assert power(x, 0.0) == 1.0
    assert slopes_of(power(0.0, y)) == {}


@pytest.mark.defect("C2", before="ValueError: math domain error", after="slopes of 0**1.5, 0**1, x**0, 0**y")
def test_powers_at_zero() -> None:
    x, y = dual(0.0, {"x": 1.0}), dual(1.5, {"y": 1.0})
    assert dual_math.pow(x, 1.5) == 0.0
    assert slopes_of(dual_math.pow(x, 1.0)) == {"x": 1.0}
    assert dual_math.pow(x, 0.0) == 1.0
    assert slopes_of(dual_math.pow(0.0, y)) == {}
