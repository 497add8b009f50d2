"""Derivatives of elementary functions, as plain functions: dual numbers and programs of tangents
read the same ones.

Where a function has no finite derivative, as the square root at 0, plain Python raises and a
program gives no finite number.
"""

import math
from collections.abc import Callable
from typing import Any

from proofmass.blocks.arithmetic import elementary


def _sqrt(x: float) -> float:
    return 0.5 / math.sqrt(x)


def _cbrt(x: float) -> float:
    return math.cbrt(x) / (3.0 * x)


def _exp2(x: float) -> float:
    return math.log(2.0) * math.exp2(x)


def _log(x: float) -> float:
    return 1.0 / x


def _log2(x: float) -> float:
    return 1.0 / (math.log(2.0) * x)


def _log10(x: float) -> float:
    return 1.0 / (math.log(10.0) * x)


def _log1p(x: float) -> float:
    return 1.0 / (1.0 + x)


def _cos(x: float) -> float:
    return -math.sin(x)


def _tan(x: float) -> float:
    return 1.0 + math.tan(x) * math.tan(x)


def _asin(x: float) -> float:
    return 1.0 / math.sqrt(1.0 - x * x)


def _acos(x: float) -> float:
    return -1.0 / math.sqrt(1.0 - x * x)


def _atan(x: float) -> float:
    return 1.0 / (1.0 + x * x)


def _tanh(x: float) -> float:
    value = math.tanh(x)
    return 1.0 - value * value


def _asinh(x: float) -> float:
    return 1.0 / math.sqrt(1.0 + x * x)


def _acosh(x: float) -> float:
    return 1.0 / math.sqrt(x * x - 1.0)


def _atanh(x: float) -> float:
    return 1.0 / (1.0 - x * x)


def _erf(x: float) -> float:
    return 2.0 / math.sqrt(math.pi) * math.exp(-x * x)


def _erfc(x: float) -> float:
    return -2.0 / math.sqrt(math.pi) * math.exp(-x * x)


def _degrees(x: float) -> float:
    return 180.0 / math.pi


def _radians(x: float) -> float:
    return math.pi / 180.0


def _sine_of_turns(x: float) -> float:
    return math.tau * elementary.cosine_of_turns(x)


def _cosine_of_turns(x: float) -> float:
    return -math.tau * elementary.sine_of_turns(x)


def _cosine(x: float) -> float:
    return -elementary.sine(x)


def _tangent(x: float) -> float:
    return 1.0 + elementary.tangent(x) * elementary.tangent(x)


def _hyperbolic_tangent(x: float) -> float:
    return 1.0 / (elementary.hyperbolic_cosine(x) * elementary.hyperbolic_cosine(x))


def _arctangent2(y: float, x: float) -> tuple[float, float]:
    square = x * x + y * y
    return x / square, -y / square


def _hypotenuse(x: float, y: float) -> tuple[float, float]:
    length = elementary.hypotenuse(x, y)
    return x / length, y / length


def _power(base: float, exponent: float) -> tuple[float, float]:
    """Return the derivatives of a power; that by the exponent is zero where the base stays zero."""
    if exponent == 0.0:
        by_base = 0.0
    elif base == 0.0 and exponent < 1.0:
        by_base = exponent / base
    else:
        by_base = exponent * elementary.power(base, exponent - 1.0)
    by_exponent = 0.0
    if base != 0.0:
        by_exponent = elementary.power(base, exponent) * elementary.logarithm(base)
    return by_base, by_exponent


SlopeOfOne = Callable[[float], float]
SLOPES_OF_ONE: dict[Any, SlopeOfOne] = {
    math.sqrt: _sqrt,
    math.cbrt: _cbrt,
    math.exp: math.exp,
    math.exp2: _exp2,
    math.expm1: math.exp,
    math.log: _log,
    math.log2: _log2,
    math.log10: _log10,
    math.log1p: _log1p,
    math.sin: math.cos,
    math.cos: _cos,
    math.tan: _tan,
    math.asin: _asin,
    math.acos: _acos,
    math.atan: _atan,
    math.sinh: math.cosh,
    math.cosh: math.sinh,
    math.tanh: _tanh,
    math.asinh: _asinh,
    math.acosh: _acosh,
    math.atanh: _atanh,
    math.erf: _erf,
    math.erfc: _erfc,
    math.degrees: _degrees,
    math.radians: _radians,
    elementary.sine_of_turns: _sine_of_turns,
    elementary.cosine_of_turns: _cosine_of_turns,
    elementary.sine: elementary.cosine,
    elementary.cosine: _cosine,
    elementary.tangent: _tangent,
    elementary.arctangent: _atan,
    elementary.arcsine: _asin,
    elementary.arccosine: _acos,
    elementary.exponential: elementary.exponential,
    elementary.exponential_less_one: elementary.exponential,
    elementary.logarithm: _log,
    elementary.logarithm_of_fraction: _log,
    elementary.logarithm_of_one_plus: _log1p,
    elementary.binary_logarithm: _log2,
    elementary.decimal_logarithm: _log10,
    elementary.hyperbolic_sine: elementary.hyperbolic_cosine,
    elementary.hyperbolic_cosine: elementary.hyperbolic_sine,
    elementary.hyperbolic_tangent: _hyperbolic_tangent,
}
WIDE_SLOPES = SLOPES_OF_ONE | {elementary.hyperbolic_tangent: _tanh}  # of intervals: 1 / cosh^2 may have no bound there
SLOPES_OF_TWO: dict[Any, Callable[[float, float], tuple[float, float]]] = {
    elementary.arctangent2: _arctangent2,
    elementary.power: _power,
    elementary.hypotenuse: _hypotenuse,
}
