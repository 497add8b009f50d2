"""Every operation of programs on hostile values: one program that computes all, and what plain Python says to them."""

import math
import struct
from collections.abc import Callable
from itertools import product
from typing import Any

import numpy as np

from proofmass.runner.program.form import FLOAT, INTEGER, OPERATIONS, TRUTH, Kind, Program, Storage, Value
from tests.by_hand.programs import Writer, program

LOWEST, HIGHEST, WORD = -(2**63), 2**63 - 1, 2**64
NAN, INFINITY = math.nan, math.inf
FLOATS = (
    0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 1.5, 2.5, -2.5, 3.0, 0.1, -7.3, 1e-320, -5e-324, 2.2250738585072014e-308,
    1.7976931348623157e308, -1e308, 4503599627370496.5, 4503599627370495.5, 9007199254740993.0, 9.223372036854775e18,
    -9.223372036854775808e18, 9.223372036854775808e18, 1e19, NAN, INFINITY, -INFINITY,
)  # fmt: skip
INTEGERS = (
    0, 1, -1, 2, -2, 3, -3, 7, -10, 63, 64, 65, 2**31, -(2**31), 2**32 - 1, 2**53 + 1, -(2**53) - 1, 2**62, -(2**62),
    HIGHEST, HIGHEST - 1, LOWEST, LOWEST + 1,
)  # fmt: skip
TRUTHS = (False, True)
VALUES: dict[Kind, tuple[Any, ...]] = {FLOAT: FLOATS, INTEGER: INTEGERS, TRUTH: TRUTHS}
DTYPES: dict[Kind, Any] = {FLOAT: np.float64, INTEGER: np.int64, TRUTH: np.bool_}
ANY = object()  # a value that the form leaves open


def wrapped(value: int) -> int:
    """An integer modulo 2^64, with sign."""
    return (value - LOWEST) % WORD + LOWEST


def divided(a: float, b: float) -> float:
    """A quotient as IEEE 754 has it."""
    if b != 0.0 or math.isnan(a):
        return a / b if b != 0.0 else NAN
    if a == 0.0:
        return NAN
    return math.copysign(INFINITY, a) * math.copysign(1.0, b)


def rounded(how: Callable[[float], int], a: float) -> float:
    """A whole number, with the sign of what it comes from."""
    return math.copysign(float(how(a)), a) if math.isfinite(a) else a


def bits(a: float) -> int:
    """The bits of a number."""
    return int(struct.unpack("<q", struct.pack("<d", a))[0])


PYTHON: dict[str, Callable[..., Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": divided,
    "negate": lambda a: -a,
    "absolute": abs,
    "copy_sign": math.copysign,
    "square_root": lambda a: math.sqrt(a) if a >= 0.0 or math.isnan(a) else NAN,
    "floor": lambda a: rounded(math.floor, a),
    "ceiling": lambda a: rounded(math.ceil, a),
    "truncate": lambda a: rounded(math.trunc, a),
    "round_half_even": lambda a: rounded(round, a),
    "less": lambda a, b: a < b,
    "less_equal": lambda a, b: a <= b,
    "equal": lambda a, b: a == b,
    "not_equal": lambda a, b: a != b,
    "add_integers": lambda a, b: wrapped(a + b),
    "subtract_integers": lambda a, b: wrapped(a - b),
    "multiply_integers": lambda a, b: wrapped(a * b),
    "add_overflows": lambda a, b: not LOWEST <= a + b <= HIGHEST,
    "subtract_overflows": lambda a, b: not LOWEST <= a - b <= HIGHEST,
    "multiply_overflows": lambda a, b: not LOWEST <= a * b <= HIGHEST,
    "floor_divide": lambda a, b: ANY if b == 0 or (a, b) == (LOWEST, -1) else a // b,
    "modulo": lambda a, b: ANY if b == 0 else a % b,
    "and": lambda a, b: a & b,
    "or": lambda a, b: a | b,
    "xor": lambda a, b: a ^ b,
    "shift_left": lambda a, b: wrapped(a << b) if 0 <= b < 64 else ANY,
    "shift_right": lambda a, b: a >> b if 0 <= b < 64 else ANY,
    "less_integers": lambda a, b: a < b,
    "less_equal_integers": lambda a, b: a <= b,
    "equal_integers": lambda a, b: a == b,
    "not_equal_integers": lambda a, b: a != b,
    "both": lambda a, b: a and b,
    "either": lambda a, b: a or b,
    "differ": lambda a, b: a != b,
    "not": lambda a: not a,
    "likely": lambda a: a,
    "float_of_integer": float,
    "integer_of_float": lambda a: int(a) if math.isfinite(a) and LOWEST <= int(a) <= HIGHEST else ANY,
    "integer_of_truth": int,
    "float_of_truth": float,
    "bits_of_float": bits,
    "float_of_bits": lambda a: struct.unpack("<d", struct.pack("<q", a))[0],
}
THIN, THINNER = 5, 35  # of so many cases with constants one is tried: where all is tried that may be, and otherwise
_EXACT = {"negate", "absolute", "copy_sign", "float_of_bits"}  # whose NaN keep their bits
CASES = {name: tuple(product(*(VALUES[kind] for kind in OPERATIONS[name].operands if kind))) for name in PYTHON}


def operations_program(constant_operand: int | None = None, thin: int = THINNER) -> Program:
    """A program that computes every operation for all its cases; arrays of each operation one behind the other.

    With `constant_operand` that operand is a constant of the program, in one of `thin` cases.
    """
    parameters: list[Storage] = []
    w = Writer("entry")
    for name, cases in CASES.items():
        kinds = [kind for kind in OPERATIONS[name].operands if kind]
        given = [Storage(kind, len(cases), False, name) for kind in kinds]
        result = OPERATIONS[name].result or FLOAT
        out = Storage(result, len(cases), True, f"{name}_out")
        parameters += [*given, out]
        w.function.parameters = tuple(parameters)
        if constant_operand is None or len(kinds) <= constant_operand:
            with w.count(0, len(cases)) as i:
                w.store(out, i, w.do(name, *(w.load(array, i) for array in given)))
            continue
        for place, case in list(enumerate(cases))[::thin]:
            read = [c if k == constant_operand else w.load(given[k], place) for k, c in enumerate(case)]
            w.store(out, place, w.do(name, *read))
    return program(w.function)


def operations_arrays() -> list[Any]:
    """Arrays for the program, filled with ones where it writes."""
    arrays = []
    for name, cases in CASES.items():
        kinds = [kind for kind in OPERATIONS[name].operands if kind]
        arrays += [np.array([case[k] for case in cases], dtype=DTYPES[kind]) for k, kind in enumerate(kinds)]
        arrays.append(np.ones(len(cases), dtype=DTYPES[OPERATIONS[name].result or FLOAT]))
    return arrays


def operations_wrong(arrays: list[Any], constant_operand: int | None = None, thin: int = THINNER) -> list[str]:
    """Cases in which the arrays hold something else than Python says."""
    wrong, place = [], 0
    for name, cases in CASES.items():
        place += len(cases[0]) + 1
        apart = 1 if constant_operand is None or len(cases[0]) <= constant_operand else thin
        for case, value in list(zip(cases, arrays[place - 1].tolist(), strict=True))[::apart]:
            expected = PYTHON[name](*case)
            if expected is not ANY and not _same(value, expected, name in _EXACT):
                wrong.append(f"{name}{case} = {value!r}, not {expected!r}")
    return wrong


def _same(value: Any, expected: Any, exact: bool) -> bool:
    if type(value) is not type(expected):
        return False
    if isinstance(value, float):
        return bits(value) == bits(expected) or (not exact and math.isnan(value) and math.isnan(expected))
    return bool(value == expected)


def select_program(likely: bool = False) -> Program:
    """A selection of each kind, of two values of the caller, by a condition that is said to be likely or not."""
    given = Value(TRUTH, "condition")
    w = Writer("entry", given)
    condition = w.do("likely", given) if likely else given
    for kind in Kind:
        array = Storage(kind, 3, True, kind.value)
        w.function.parameters += (array,)
        w.store(array, 2, w.do("select", condition, w.load(array, 0), w.load(array, 1)))
    return program(w.function)
