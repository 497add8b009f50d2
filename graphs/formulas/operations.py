"""Operations of formulas: what each does to numbers, to dimensions and to derivatives.

Functions are those of `blocks.arithmetic.elementary`: the same bits on every machine, for one
number and for arrays. None of them raises: without a value the result is infinite or NaN.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache

from proofmass.blocks.arithmetic import elementary
from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.unit_expressions import BASE, Unit, unit

Dimension = tuple[Fraction, ...]  # exponents of the base units
NUMBER: Dimension = (Fraction(0),) * len(BASE)
LARGEST_EXPONENT = 100  # of a base unit
KNOWN = "known of"  # no operation that a formula has: what a measure that follows from others ends with

SlopeFunction = Callable[..., tuple[float, ...]]  # partial derivatives at the arguments


@dataclass(frozen=True)
class FormulaOperation:
    """An operator or a function; `dimension` raises `Refusal` if the units of its arguments do not go together."""

    name: str
    arity: int
    function: Callable[..., float]
    slopes: SlopeFunction
    dimension: Callable[[str, Sequence[Dimension]], Dimension]


def dimension_text(dimension: Dimension) -> str:
    """Return a dimension in words: `a plain number`, or its unit."""
    return "a plain number" if dimension == NUMBER else coherent_unit(dimension)


@cache
def coherent_unit(dimension: Dimension) -> str:
    """Return the coherent SI unit of a dimension, by its name or a quotient of names if any.

    >>> coherent_unit(unit("mV").exponents), coherent_unit(unit("kg/s^2").exponents), coherent_unit(NUMBER)
    ('V', 'N/m', '1')
    """
    if sum(map(abs, dimension)) <= 2 and max(dimension) <= 1:
        return Unit(Fraction(1), dimension).in_base_units()
    quotients = (f"{name}/{below}" for below in _BELOW for name in (*_NAMED, *BASE))
    reciprocals = (f"1/{name}" for name in _NAMED)
    candidates = (*_NAMED, *reciprocals, *quotients, *(f"{name}*{other}" for name in _NAMED for other in ("m", "s")))
    fits = (name for name in candidates if unit(name).exponents == dimension)
    return next(fits, Unit(Fraction(1), dimension).in_base_units())


def multiplied(dimension: Dimension, factor: Fraction | int, other: Dimension = NUMBER) -> Dimension:
    """Return the dimension of a power of a quantity times another quantity; raises `Refusal` beyond all use."""
    result = tuple(a * factor + b for a, b in zip(dimension, other, strict=True))
    if any(abs(e) > LARGEST_EXPONENT or e.denominator > LARGEST_EXPONENT for e in result):
        raise Refusal(f"has a unit with an exponent beyond {LARGEST_EXPONENT}")
    return result


def _same(name: str, dimensions: Sequence[Dimension]) -> Dimension:
    first, *others = dimensions
    for other in others:
        if other != first:
            raise Refusal(f"{_WORDS.get(name, name)} takes {dimension_text(first)} and {dimension_text(other)}")
    return first


def _numbers(name: str, dimensions: Sequence[Dimension]) -> Dimension:
    for dimension in dimensions:
        if dimension != NUMBER:
            hint = "divide by a unit or a value of the same dimension"
            raise Refusal(f"{name} takes a plain number or an angle, not {dimension_text(dimension)}", hint)
    return NUMBER


def _ratio(name: str, dimensions: Sequence[Dimension]) -> Dimension:
    _same(name, dimensions)
    return NUMBER


def divided(first: float, second: float) -> float:
    """Return the quotient, infinite or NaN where the divisor is zero."""
    if second == 0.0:
        return (
            math.nan if first == 0.0 or math.isnan(first) else math.copysign(math.inf, first) * math.copysign(1, second)
        )
    return first / second


def root(value: float) -> float:
    """Return the square root, NaN of a negative number."""
    return math.sqrt(value) if value >= 0.0 else math.nan


def smaller(first: float, second: float) -> float:
    """Return the smaller one, NaN where one is."""
    if first < second:
        return first
    return second if second <= first else first + second


def larger(first: float, second: float) -> float:
    """Return the larger one, NaN where one is."""
    if first > second:
        return first
    return second if second >= first else first + second


def known(value: float, of: float) -> float:
    """Return a value that follows from another one, NaN where one of both is infinite or NaN."""
    return value if value - value == of - of else math.nan


def size(value: float) -> float:
    """Return the absolute value."""
    return abs(value)


_NAMED = ("N", "V", "ohm", "W", "J", "C", "F", "H", "T", "Pa", "S")
_BELOW = ("m", "s", "V", "A", "K", "m^2", "s^2", "m^3", "sqrt(Hz)", "(m/s^2)")
_WORDS = {"+": "a sum", "-": "a difference"}


def _operations() -> dict[str, FormulaOperation]:
    of = elementary
    rows: list[
        tuple[str, int, Callable[..., float], SlopeFunction, Callable[[str, Sequence[Dimension]], Dimension]]
    ] = [
        ("+", 2, lambda a, b: a + b, lambda a, b: (1.0, 1.0), _same),
        ("-", 2, lambda a, b: a - b, lambda a, b: (1.0, -1.0), _same),
        ("*", 2, lambda a, b: a * b, lambda a, b: (b, a), lambda _, d: multiplied(d[0], 1, d[1])),
        ("/", 2, divided, _quotient_slopes, lambda _, d: multiplied(d[1], -1, d[0])),
        ("negative", 1, lambda a: -a, lambda a: (-1.0,), _same),
        ("sqrt", 1, root, lambda a: (divided(0.5, root(a)),), lambda _, d: multiplied(d[0], Fraction(1, 2))),
        ("abs", 1, size, lambda a: (math.copysign(1.0, a),), _same),
        ("min", 2, smaller, lambda a, b: (1.0, 0.0) if a < b else (0.0, 1.0), _same),
        ("max", 2, larger, lambda a, b: (1.0, 0.0) if a > b else (0.0, 1.0), _same),
        (
            "hypot",
            2,
            of.hypotenuse,
            lambda a, b: (divided(a, of.hypotenuse(a, b)), divided(b, of.hypotenuse(a, b))),
            _same,
        ),
        ("atan2", 2, of.arctangent2, lambda y, x: (divided(x, x * x + y * y), -divided(y, x * x + y * y)), _ratio),
        ("exp", 1, of.exponential, lambda a: (of.exponential(a),), _numbers),
        ("log", 1, of.logarithm, lambda a: (divided(1.0, a),), _numbers),
        ("log2", 1, of.binary_logarithm, lambda a: (divided(1.0, a * math.log(2.0)),), _numbers),
        ("log10", 1, of.decimal_logarithm, lambda a: (divided(1.0, a * math.log(10.0)),), _numbers),
        ("sin", 1, of.sine, lambda a: (of.cosine(a),), _numbers),
        ("cos", 1, of.cosine, lambda a: (-of.sine(a),), _numbers),
        ("tan", 1, of.tangent, lambda a: (1.0 + of.tangent(a) ** 2,), _numbers),
        ("asin", 1, of.arcsine, lambda a: (divided(1.0, root(1.0 - a * a)),), _numbers),
        ("acos", 1, of.arccosine, lambda a: (-divided(1.0, root(1.0 - a * a)),), _numbers),
        ("atan", 1, of.arctangent, lambda a: (1.0 / (1.0 + a * a),), _numbers),
        ("sinh", 1, of.hyperbolic_sine, lambda a: (of.hyperbolic_cosine(a),), _numbers),
        ("cosh", 1, of.hyperbolic_cosine, lambda a: (of.hyperbolic_sine(a),), _numbers),
        ("tanh", 1, of.hyperbolic_tangent, lambda a: (1.0 - of.hyperbolic_tangent(a) ** 2,), _numbers),
        ("power", 2, of.power, _power_slopes, _numbers),
        (KNOWN, 2, known, lambda a, b: (1.0, 0.0), lambda _, d: d[0]),
    ]
    return {row[0]: FormulaOperation(*row) for row in rows}


def _quotient_slopes(dividend: float, divisor: float) -> tuple[float, float]:
    return divided(1.0, divisor), -divided(divided(dividend, divisor), divisor)


def _power_slopes(base: float, exponent: float) -> tuple[float, float]:
    power = elementary.power(base, exponent)
    return exponent * elementary.power(base, exponent - 1.0), power * elementary.logarithm(base) if power else 0.0


OPERATIONS = _operations()
FUNCTIONS = sorted(name for name in OPERATIONS if name.isalnum() and name not in ("negative", "power"))
CONSTANTS = {"pi": math.pi}
