"""Values of parameters: what is taken, what is refused, and in which words."""

import math
from fractions import Fraction
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.declaration.declare import Block, param
from proofmass.blocks.declaration.parameter import LARGEST_INTEGER, fill
from proofmass.blocks.declaration.problem import ModelError, Refusal
from proofmass.blocks.declaration.units import convert_exactly

NAN, INFINITY = math.nan, math.inf


class Sample(Block):
    """One parameter of every type."""

    mass: float = param("kg", "A bounded number.", default=2.0, above=0.0, at_most=10.0)
    angle: float = param("rad", "A number without bounds.", default=0.0)
    ratio: float = param("1", "A plain number.", default=0.5, at_least=0.0, below=1.0)
    bits: int = param("bit", "An integer.", default=8, at_least=2, at_most=32)
    taps: int = param("1", "A large integer.", default=1)
    enabled: bool = param("", "A truth value.", default=True)
    shape: str = param("", "A choice.", default="sine", choices=("sine", "square"))
    label: str = param("", "Any text.", default="")
    gain: float = param("({output_unit})/({input_unit})", "A number in units of its own.", default=1.0)
    knots: tuple[float, ...] = param("s", "A list.", default=(0.0, 1.0), at_least=0.0)
    input_unit: str = param("", "A unit.", default="1")
    output_unit: str = param("", "Another unit.", default="1")


def refusal(**values: Any) -> str:
    with pytest.raises(ModelError) as error:
        Sample(**values)
    return str(error.value)


MASS = "\n  expected: a number > 0 and <= 10, in kg"
BITS = "\n  expected: an integer >= 2 and <= 32, in bit"
POINT = "\n  hint:     write it without a decimal point"
EMPTY = "\n  got:      ''\n  expected: a unit\n  hint:     write \"1\" for a plain number"


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("mass", -1.0, "must be > 0 and <= 10\n  got:      -1.0 kg" + MASS),
        ("mass", 0, "must be > 0 and <= 10\n  got:      0 kg" + MASS),
        ("mass", 10.000000000000002, "must be > 0 and <= 10\n  got:      10.000000000000002 kg" + MASS),
        ("mass", NAN, "must be finite\n  got:      nan kg" + MASS),
        ("mass", INFINITY, "must be finite\n  got:      inf kg" + MASS),
        ("mass", True, "must be a number\n  got:      True" + MASS),
        ("mass", None, "must be a number\n  got:      None" + MASS),
        ("mass", 1j, "must be a number\n  got:      1j" + MASS),
        ("mass", [1.0], "must be a number\n  got:      [1.0]" + MASS),
        ("mass", 10**400, "is too large for a number\n  got:      an integer of over 30 digits kg" + MASS),
        ("mass", "3 N", "N is m*kg/s^2, not kg\n  got:      '3 N'" + MASS + "\n  hint:     give it in kg"),
        ("mass", "12 kg", "must be > 0 and <= 10\n  got:      '12 kg'" + MASS),
        ("mass", "1e400 kg", "is too large for a number\n  got:      '1e400 kg'" + MASS),
        ("mass", "1e999999 kg", "an exponent of ten beyond 400\n  got:      '1e999999 kg'" + MASS),
        ("mass", "1/0 kg", "a division by zero\n  got:      '1/0 kg'" + MASS),
        (
            "mass",
            "heavy",
            "not a number followed by a unit\n  got:      'heavy'"
            + MASS
            + '\n  hint:     write a number and a unit, such as "1.5 kg"',
        ),
        ("ratio", 1.0, "must be >= 0 and < 1\n  got:      1.0\n  expected: a number >= 0 and < 1"),
        ("bits", 33, "must be >= 2 and <= 32\n  got:      33 bit" + BITS),
        (
            "bits",
            8.0,
            "must be an integer\n  got:      8.0 bit" + BITS + POINT,
        ),
        (
            "bits",
            NAN,
            "must be an integer\n  got:      nan bit" + BITS + POINT,
        ),
        ("bits", True, "must be an integer\n  got:      True" + BITS),
        ("bits", "8.5", "must be an integer\n  got:      '8.5'" + BITS),
        ("taps", 2**62 + 1, "is beyond 62 bits\n  got:      4611686018427387905\n  expected: an integer"),
        ("taps", "1e300", "is beyond 62 bits\n  got:      '1e300'\n  expected: an integer"),
        ("enabled", 1, "must be true or false\n  got:      1\n  expected: true or false"),
        ("enabled", "true", "must be true or false\n  got:      'true'\n  expected: true or false"),
        ("shape", "triangle", "is not one of the choices\n  got:      'triangle'\n  expected: one of sine, square"),
        ("label", 5, "must be a string\n  got:      5\n  expected: a string"),
        ("knots", 1.0, "must be a list of numbers\n  got:      1.0 s\n  expected: a list of numbers >= 0, in s"),
        ("knots", "12", "must be a list of numbers\n  got:      '12'\n  expected: a list of numbers >= 0, in s"),
        ("knots", [], "must not be empty\n  got:      []\n  expected: a list of numbers >= 0, in s"),
        ("knots", [1.0, NAN], "must be finite\n  got:      [1.0, nan]\n  expected: a list of numbers >= 0, in s"),
        ("knots", [1.0, -1], "must be >= 0\n  got:      [1.0, -1]\n  expected: a list of numbers >= 0, in s"),
        ("knots", [False], "must be a number\n  got:      [False]\n  expected: a list of numbers >= 0, in s"),
        ("knots", [10**5000], "is too large for a number\n  got:      a list that cannot be shown\n"),
        (
            "input_unit",
            "",
            "an empty unit\n  got:      ''\n  expected: a unit\n  hint:     write \"1\" for a plain number",
        ),
        ("input_unit", 5, "must be a string\n  got:      5\n  expected: a string"),
    ],
)
def test_text_of_a_refusal(name: str, value: object, text: str) -> None:
    assert refusal(**{name: value}).startswith(f"Sample.{name}: {text}")


def test_every_wrong_value_in_one_error() -> None:
    text = refusal(mass=-1.0, bits=8.5, enabled=0, shape="round", knots=[NAN], output_unit="furlong", weight=3)
    heads = [line for line in text.splitlines() if not line.startswith(" ")]
    assert heads == [
        "Sample.weight: Sample has no such parameter",
        "Sample.mass: must be > 0 and <= 10",
        "Sample.bits: must be an integer",
        "Sample.enabled: must be true or false",
        "Sample.shape: is not one of the choices",
        "Sample.knots: must be finite",
        "Sample.output_unit: unknown unit 'furlong'",
    ]


@pytest.mark.parametrize(
    ("name", "value", "read"),
    [
        ("mass", "50.43 ug", 50.43e-9),
        ("mass", "2", 2.0),
        ("mass", 3, 3.0),
        ("mass", 10.0, 10.0),
        ("angle", "180 deg", math.pi),
        ("angle", -1e308, -1e308),
        ("ratio", "200 ppm", 2e-4),
        ("ratio", "1/3", 1.0 / 3.0),
        ("bits", "12 bit", 12),
        ("taps", "1e3", 1000),
        ("taps", -LARGEST_INTEGER, -LARGEST_INTEGER),
        ("shape", "square", "square"),
        ("label", "Ω\n", "Ω\n"),
        ("knots", [0, "1 ms", 2.5], (0.0, 1e-3, 2.5)),
        ("knots", (7,), (7.0,)),
        ("output_unit", "kg*m/s^2", "kg*m/s^2"),
    ],
)
def test_what_is_taken(name: str, value: object, read: object) -> None:
    found = getattr(Sample(**{name: value}), name)
    assert found == read
    assert type(found) is type(read)


def test_a_gain_is_converted_by_the_units_given_beside_it() -> None:
    assert Sample(gain="5 mV/um", input_unit="m", output_unit="V").gain == 5000.0
    assert Sample(gain="5 mV/um", input_unit="um", output_unit="mV").gain == 5.0
    text = refusal(gain="5 V/A", input_unit="m", output_unit="V")
    assert text.startswith("Sample.gain: V/A is ")
    assert text.endswith('  expected: a number, in V/m\n  hint:     set input_unit = "A", or give it in V/m')


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_decimal_with_a_unit_is_the_same_float(value: float) -> None:
    assert Sample(angle=f"{value!r} rad").angle == value


@given(st.text(max_size=40) | st.from_regex(r"-?[0-9]{1,3}(\.[0-9]*)?(e-?[0-9]{1,3})? ?(kg|g|mg|N|1)?", fullmatch=True))
def test_any_text_is_read_exactly_or_refused(text: str) -> None:
    try:
        exact = convert_exactly(text, "kg")
    except Refusal:
        exact = Fraction(-1)
    if 0 < exact <= 10 and float(exact) > 0.0:
        assert Sample(mass=text).mass == float(exact)
    else:
        assert refusal(mass=text).startswith("Sample.mass: ")


def test_fill_puts_in_every_name() -> None:
    assert fill("({a})*({b})/({a})", {"a": "V", "b": "m", "c": "s"}) == "(V)*(m)/(V)"
