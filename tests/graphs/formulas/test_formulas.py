"""Formulas against `math` and central differences: numbers, units, derivatives, bits."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.formulas.operations import FUNCTIONS, OPERATIONS, coherent_unit
from proofmass.graphs.formulas.tree import dimension_of, slopes

NUMBERS = {"mass": 5.043e-08, "f0": 8000.0, "q": 150.0, "x": 0.3, "y": -0.7}
DIMENSIONS = {name: unit({"mass": "kg", "f0": "Hz"}.get(name, "1")).exponents for name in NUMBERS}
m, f0, q, x, y = NUMBERS.values()

CASES = {  # text: value in SI units, unit
    "= mass": (5.043e-08, "kg"),
    "= 50.43 ug": (5.043e-08, "kg"),
    "= 2 * pi * f0 / q": (2 * math.pi * f0 / q, "1/s"),
    "= mass * (2 * pi * f0)^2": (m * (2 * math.pi * f0) ** 2, "N/m"),
    "= -2^2": (-4.0, "1"),
    "= (-2)^2": (4.0, "1"),
    "= 2^-1": (0.5, "1"),
    "= 2^3^2": (512.0, "1"),
    "= 2**10": (1024.0, "1"),
    "= 7 - 2 - 1": (4.0, "1"),
    "= 8 / 4 / 2": (1.0, "1"),
    "= 1 - -1": (2.0, "1"),
    "= 1/2 ms": (500.0, "1/s"),
    "= 9.81 m/s^2": (9.81, "m/s^2"),
    "= 20 nV/sqrt(Hz)": (20e-9, "V/sqrt(Hz)"),
    "= 5 N m s/rad": (5.0, "N*m*s"),
    "= 3 %": (0.03, "1"),
    "= 20 ppm/year": (20e-6 / 31557600.0, "1/s"),
    "= 1_000 * .5e-3": (0.5, "1"),
    "= 4.7 kΩ": (4700.0, "ohm"),
    "= 3 µm": (3e-06, "m"),
    "= sqrt(4 m^2)": (2.0, "m"),
    "= (8 m^3)^(1/3)": (2.0, "m"),
    "= hypot(3 V, 4 V)": (5.0, "V"),
    "= max(1 V, 20 mV) - min(1 V, 20 mV)": (0.98, "V"),
    "= abs(-3 A)": (3.0, "A"),
    "= sin(30 deg)": (math.sin(math.radians(30)), "1"),
    "= atan2(1 N, 1 N)": (math.atan2(1, 1), "1"),
    "= exp(x) * log(q) + log10(q) - log2(q)": (
        math.exp(x) * math.log(q) + math.log10(q) - math.log2(q), "1"),
    "= x^y": (x**y, "1"),
}  # fmt: skip


@pytest.mark.parametrize("text", CASES)
def test_value_and_unit(text: str) -> None:
    value, in_unit = CASES[text]
    assert Formula(text).quantity(NUMBERS, DIMENSIONS, in_unit) == pytest.approx(value, rel=4e-16)


def test_a_quantity_is_rounded_once() -> None:
    for text, number in (("50.43 ug", 50.43e-9), ("126.5 N/m", 126.5), ("3.14e-7 kg/s", 3.14e-7), ("0.1 us", 1e-7)):
        assert Formula(f"= {text}").number({}) == number


def test_a_result_may_be_wanted_in_other_units() -> None:
    assert Formula("= 30 deg").quantity({}, {}, "deg") == pytest.approx(30.0, rel=4e-16)
    assert Formula("= 1 V").quantity({}, {}, "mV") == 1000.0


POINTS = {"sqrt": (0.3,), "acos": (0.3,), "asin": (0.3,), "log": (0.3,), "log2": (0.3,), "log10": (0.3,)}


@pytest.mark.parametrize("name", [*FUNCTIONS, "+", "-", "*", "/", "^", "whole power", "negative power"])
def test_slopes_are_those_of_central_differences(name: str) -> None:
    two = {"atan2", "hypot", "max", "min"}
    body = f"{name}(u, v)" if name in two else f"{name}(u)" if name in FUNCTIONS else f"u {name} v"
    formula = Formula({"whole power": "= v^3", "negative power": "= v^-2"}.get(name, f"= {body}"))
    at = {"u": 0.3, "v": 0.8}
    exact = slopes(formula.tree, at)
    assert exact.keys() == formula.names & at.keys()
    for of, slope in exact.items():
        step = 1e-6
        above, below = (formula.number({**at, of: at[of] + sign * step}) for sign in (1, -1))
        assert slope == pytest.approx((above - below) / (2 * step), rel=1e-7, abs=1e-9)


def test_slopes_of_a_power_of_zero() -> None:
    """A square is flat at 0, and 0^v is 0 for every v above 0."""
    assert slopes(Formula("= u^v").tree, {"u": 0.0, "v": 2.0}) == {"u": 0.0, "v": 0.0}
    assert slopes(Formula("= u^v").tree, {"u": 0.0, "v": 1.0}) == {"u": 1.0, "v": 0.0}


def test_slopes_chain() -> None:
    tree = Formula("= sqrt(k / mass) / (2 * pi)").tree
    assert slopes(tree, {"k": 126.0, "mass": 5e-8}) == pytest.approx(
        {
            "k": 0.5 * math.sqrt(126 / 5e-8) / 126 / (2 * math.pi),
            "mass": -0.5 * math.sqrt(126 / 5e-8) / 5e-8 / (2 * math.pi),
        }
    )


def test_units_have_their_names() -> None:
    named = ("V", "N/m", "kg/s", "ohm", "V/m", "m/s^2", "N*m", "rad", "Hz")
    assert [coherent_unit(unit(text).exponents) for text in named] == [
        "V", "N/m", "kg/s", "ohm", "V/m", "m/s^2", "J", "1", "1/s",
    ]  # fmt: skip


def test_a_long_sum_is_no_deep_one() -> None:
    assert Formula("= " + "+".join("1" * 190)).number({}) == 190.0


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("= 1 V + 1 A", "a sum takes V and A", ""),
        ("= f0 - 1", "a difference takes 1/s and a plain number", ""),
        ("= sin(1 V)", "sin takes a plain number or an angle, not V", "divide by a unit"),
        ("= mass^q", "the exponent of a quantity with a unit must be written as a number", "x^2"),
        ("= mass^pi", "the exponent of a quantity with a unit must be a ratio of small numbers", "x^(3/2)"),
        ("= 2^mass", "an exponent must be a plain number", ""),
        ("= mas", "there is no value or unit mas", "did you mean mass?"),
        ("= 5 kHx", "unknown unit 'kHx'", "did you mean kHz?"),
        ("= sine(x)", "there is no function sine", "did you mean sin?"),
        ("= sin", "there is no value or unit sin", "write its argument in brackets: sin( )"),
        ("= sin(1, 2)", "sin takes 1 argument, not 2", ""),
        ("= hypot(1)", "hypot takes 2 arguments, not 1", ""),
        ("= sensor.mass", "a formula knows values, not parameters: sensor.mass", "mass = ..."),
        ("= 1 / 0", "has no finite value", "a division by zero"),
        ("= sqrt(-1)", "has no finite value", "a root"),
        ("= log(-1)", "has no finite value", "logarithm"),
        ("= f0", "is 1/s, not V", "the result must be in V"),
        ("= 2 * 3", "is a plain number, not V", "give its numbers units, as in 1.5 V"),
    ],
)
def test_what_is_said(text: str, message: str, hint: str) -> None:
    in_unit = "1" if "no finite" in message else "V"
    with pytest.raises(Refusal) as refused:
        Formula(text).quantity(NUMBERS, DIMENSIONS, in_unit)
    assert str(refused.value) == message
    assert hint in refused.value.hint


def test_exponents_of_units_stay_small() -> None:
    with pytest.raises(Refusal, match="an exponent beyond 100"):
        dimension_of(Formula("= ((1 m)^64)^64").tree, {})
    assert dimension_of(Formula("= ((1 m)^8)^(1/12)").tree, {})[0] == Fraction(2, 3)


@pytest.mark.defect(
    "S654",
    before="`= 19.62 m/s^2 / 9.81 m/s^2` is 2 s^-4, and `1 / 20 nV/sqrt(Hz)` divides by nV and by sqrt(Hz)",
    after="a divisor of several units is refused unless it stands in brackets",
)
@pytest.mark.parametrize(
    "text",
    ["= 19.62 m/s^2 / 9.81 m/s^2", "= x / 9.81 m / s^2", "= x / -9.81 m/s^2", "= x / 2 V * s", "= 1 / 20 nV/sqrt(Hz)"],
)
def test_a_divisor_of_several_units_stands_in_brackets(text: str) -> None:
    with pytest.raises(Refusal, match=r"after / the quantity .* ends before") as refused:
        dimension_of(Formula(text).tree, {"x": unit("1").exponents})
    assert "as in a / (9.8 m/s^2)" in refused.value.hint


def test_divisors_in_brackets_or_of_one_unit_are_what_they_are() -> None:
    for text, value, in_unit in (
        ("= 19.62 m/s^2 / (9.81 m/s^2)", 2.0, "1"),
        ("= 19.62 m/s^2 / 9.81 m s^-2", 2.0, "1"),
        ("= 6 / 2 ms / f0", 6.0 / 0.002 / f0, "1"),
        ("= 6 / 2 / 3 ms", 1000.0, "1/s"),
        ("= mass * 9.81 m/s^2", m * 9.81, "N"),
    ):
        assert Formula(text).quantity(NUMBERS, DIMENSIONS, in_unit) == pytest.approx(value, rel=1e-15)


def test_an_operation_has_a_slope_by_each_of_its_arguments() -> None:
    for name, operation in OPERATIONS.items():
        slopes_there = operation.slopes(*[0.5] * operation.arity)
        assert len(slopes_there) == operation.arity, name
    between = [OPERATIONS[name].slopes(*at) for name in ("min", "max") for at in ((1.0, 2.0), (2.0, 1.0))]
    assert between == [(1.0, 0.0), (0.0, 1.0), (0.0, 1.0), (1.0, 0.0)]


@pytest.mark.defect("H903", before="cannot be read at ·", after="formulas read printed signs, as units do")
@pytest.mark.parametrize(
    ("text", "value", "in_unit"),
    [
        ("= 5 m·s⁻²", 5.0, "m/s^2"),
        ("= 2 Ω² · 3", 6.0, "ohm^2"),
        ("= x² × 2", 2 * x * x, "1"),
        ("= 20 nV/√Hz", 20e-9, "V/sqrt(Hz)"),
        ("= -2²", -4.0, "1"),
        ("= 2⁻³", 0.125, "1"),
    ],
)
def test_a_formula_is_read_as_it_is_printed(text: str, value: float, in_unit: str) -> None:
    assert Formula(text).quantity(NUMBERS, DIMENSIONS, in_unit) == pytest.approx(value, rel=1e-15)


def test_a_number_behind_a_printed_power_is_refused() -> None:
    with pytest.raises(Refusal, match="an operator is missing before 3"):
        Formula("= x²3")


@pytest.mark.defect("S1039", before="a formula read 1e-320 fV as 0", after="too small for a number")
def test_a_number_that_a_float_has_not_is_refused() -> None:
    with pytest.raises(Refusal, match="too small for a number"):
        Formula("= 1e-320 fV")


@pytest.mark.defect(
    "S1064", before="0 of `1e-200 * 1e-200`, and 9.99989e-121 of `1e-160 * 1e-160 * 1e200`", after="refused"
)
@pytest.mark.parametrize("text", ["1e-200 * 1e-200", "1e-200 / 1e200", "a**2", "a**-2", "a * a * 1e200 + 1"])
def test_a_product_that_vanishes_is_refused(text: str) -> None:
    with pytest.raises(Refusal, match="too small for a number"):
        Formula(f"= {text}").number({"a": 1e160 if "**-2" in text else 1e-160})


def test_a_product_with_zero_is_zero() -> None:
    assert Formula("= (a - a) * 3 + 0 / a").number({"a": 1e-200}) == 0.0
