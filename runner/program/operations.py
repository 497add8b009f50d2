"""Results of each operation for Python numbers: the meaning that folding and the tests of targets share.

Where `form.OPERATIONS` leaves the value open, these functions give zero.
"""

import math
import operator
import struct
from collections.abc import Callable
from typing import Any

_MODULUS = 1 << 64
_HALF = 1 << 63


def wrapped(value: int) -> int:
    """An integer modulo 2^64, with sign.

    >>> wrapped(2**63), wrapped(-1)
    (-9223372036854775808, -1)
    """
    return (value + _HALF) % _MODULUS - _HALF


def _divide(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    if a == 0.0 or math.isnan(a) or math.isnan(b):
        return math.nan
    return math.copysign(math.inf, math.copysign(1.0, a) * math.copysign(1.0, b))


def _whole(rounded: Callable[[float], int]) -> Callable[[float], float]:
    def function(a: float) -> float:
        return math.copysign(float(rounded(a)), a) if math.isfinite(a) else a

    return function


def _of_integers(function: Callable[[int, int], int]) -> Callable[[int, int], int]:
    return lambda a, b: wrapped(function(a, b))


def _overflows(function: Callable[[int, int], int]) -> Callable[[int, int], bool]:
    return lambda a, b: not -_HALF <= function(a, b) < _HALF


EVALUATE: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": _divide,
    "negate": operator.neg,
    "absolute": abs,
    "copy_sign": math.copysign,
    "square_root": lambda a: math.nan if a < 0.0 else math.sqrt(a),
    "floor": _whole(math.floor),
    "ceiling": _whole(math.ceil),
    "truncate": _whole(math.trunc),
    "round_half_even": _whole(round),
    "less": operator.lt,
    "less_equal": operator.le,
    "equal": operator.eq,
    "not_equal": operator.ne,
    "add_integers": _of_integers(operator.add),
    "subtract_integers": _of_integers(operator.sub),
    "multiply_integers": _of_integers(operator.mul),
    "add_overflows": _overflows(operator.add),
    "subtract_overflows": _overflows(operator.sub),
    "multiply_overflows": _overflows(operator.mul),
    "floor_divide": lambda a, b: wrapped(a // b) if b else 0,
    "modulo": lambda a, b: a % b if b else 0,
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
    "shift_left": lambda a, b: wrapped(a << b) if 0 <= b < 64 else 0,
    "shift_right": lambda a, b: a >> b if 0 <= b < 64 else 0,
    "less_integers": operator.lt,
    "less_equal_integers": operator.le,
    "equal_integers": operator.eq,
    "not_equal_integers": operator.ne,
    "both": lambda a, b: a and b,
    "either": lambda a, b: a or b,
    "differ": operator.ne,
    "not": operator.not_,
    "likely": lambda a: a,
    "select": lambda a, b, c: b if a else c,
    "float_of_integer": float,
    "integer_of_float": lambda a: int(a) if -_HALF <= a < _HALF else 0,
    "integer_of_truth": int,
    "float_of_truth": float,
    "bits_of_float": lambda a: struct.unpack("<q", struct.pack("<d", a))[0],
    "float_of_bits": lambda a: struct.unpack("<d", struct.pack("<q", a))[0],
}
