"""A function of Python, lowered, verified and interpreted: what it gives for values of Python."""

import math
import struct
from typing import Any

from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, Function, Program, Storage, Value
from proofmass.runner.program.lower import lower, program
from tests.by_hand.evaluate_program import evaluate
from tests.by_hand.verify_program import verify

KINDS = {float: FLOAT, int: INTEGER, bool: TRUTH}
HOSTILE_NUMBERS = [
    *(0.0, -0.0, 1.0, -1.0, 0.5, -0.5, 2.5, -2.5, 3.0, 1e308, -1e308, 5e-324, -5e-324, 1e-300, math.inf, -math.inf),
    *(math.nan, 2.0**63, -(2.0**63), 2.0**52 + 0.5, 2.0**53),
]
HOSTILE_INTEGERS = [
    *(0, 1, -1, 2, -2, 3, 7, 63, 64, -63, 2**31, 2**53, 2**53 + 1, -(2**53) - 1, 2**62),
    *(2**63 - 1, -(2**63), -(2**63) + 1),
]
_verified = set[Function]()


def example(value: Any) -> Any:
    """What stands in a program for a value of Python."""
    if isinstance(value, list):
        return Storage(FLOAT if not value or isinstance(value[0], float) else INTEGER, len(value), True)
    if isinstance(value, tuple):
        parts = map(example, value)
        return type(value)._make(parts) if hasattr(value, "_make") else tuple(parts)  # type: ignore[attr-defined]
    return Value(KINDS[type(value)]) if type(value) in KINDS else value


def flat(value: Any) -> Any:
    """Numbers and lists of a value, one after the other."""
    if isinstance(value, tuple):
        return [part for entry in value for part in flat(entry)]
    return [value] if isinstance(value, float | int | list) else []


def run(function: Any, *arguments: Any) -> Any:
    """What the lowered function gives."""
    made = lower(function, [example(argument) for argument in arguments])
    if made.function not in _verified:
        verify(Program({**program(made.function).functions, "entry": Function("entry", (), ())}))
        _verified.add(made.function)
    return _filled(made.result, iter(evaluate(made.function, *flat(tuple(arguments)))))


def _filled(result: Any, values: Any) -> Any:
    if isinstance(result, tuple):
        parts = [_filled(part, values) for part in result]
        return type(result)._make(parts) if hasattr(result, "_make") else tuple(parts)  # type: ignore[attr-defined]
    return next(values) if result in (FLOAT, INTEGER, TRUTH) else result


def same(one: Any, other: Any) -> bool:
    """Whether values are of one type and one pattern of bits; one NaN is as another."""
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        nan = math.isnan(one) and math.isnan(other)
        return isinstance(other, float) and (nan or struct.pack("d", one) == struct.pack("d", other))
    return type(one) is type(other) and bool(one == other)
