"""Python's operators and conversions on values of a program."""

import ast
import math
from typing import Any

from proofmass.blocks.language import arithmetic
from proofmass.runner.program.build import Builder, zero
from proofmass.runner.program.form import FLOAT, INTEGER, TRUTH, Immediate, Kind, Operand, Value

KINDS: dict[Any, Kind] = {float: FLOAT, int: INTEGER, bool: TRUTH}
_EXACT = 2**53  # integers up to there are numbers

OF_NUMBERS: dict[type[ast.operator], str] = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
}
OF_INTEGERS: dict[type[ast.operator], str] = {
    ast.Add: "add_integers",
    ast.Sub: "subtract_integers",
    ast.Mult: "multiply_integers",
    ast.FloorDiv: "floor_divide",
    ast.Mod: "modulo",
    ast.BitAnd: "and",
    ast.BitOr: "or",
    ast.BitXor: "xor",
    ast.LShift: "shift_left",
    ast.RShift: "shift_right",
}
OF_TRUTH: dict[type[ast.operator], str] = {ast.BitAnd: "both", ast.BitOr: "either", ast.BitXor: "differ"}
# Operators that are functions of ours, by whether both operands are integers.
FUNCTIONS: dict[tuple[type[ast.operator], bool], Any] = {
    (ast.Div, True): arithmetic.true_divide,
    (ast.Pow, True): arithmetic.power,
    (ast.Pow, False): arithmetic.c_power,
    (ast.FloorDiv, False): arithmetic.number_floor_divide,
    (ast.Mod, False): arithmetic.number_modulo,
}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, bool]] = {  # operation, and whether the operands change places
    ast.Lt: ("less", False),
    ast.LtE: ("less_equal", False),
    ast.Gt: ("less", True),
    ast.GtE: ("less_equal", True),
    ast.Eq: ("equal", False),
    ast.NotEq: ("not_equal", False),
}


def as_kind(builder: Builder, value: Operand, kind: Kind) -> Operand:
    """Convert a value to another kind as Python's `float`, `int` and `bool` do."""
    match value.kind, kind:
        case (Kind.INTEGER, Kind.FLOAT):
            rounded = builder.wholes.get(value) if isinstance(value, Value) else None
            if rounded:  # as Python does, also beyond 64 bits; an integer has no -0.0
                return builder.compute("add", builder.compute(*rounded), 0.0)
            return builder.compute("float_of_integer", value)
        case (Kind.TRUTH, Kind.FLOAT):
            return builder.compute("float_of_truth", value)
        case (Kind.TRUTH, Kind.INTEGER):
            return builder.compute("integer_of_truth", value)
        case (Kind.FLOAT, Kind.INTEGER):
            return rounded_to_integer(builder, "truncate", value)
        case (Kind.FLOAT | Kind.INTEGER, Kind.TRUTH):
            unequal = "not_equal" if value.kind is FLOAT else "not_equal_integers"
            return builder.compute(unequal, value, zero(value.kind))
    return value


def rounded_to_integer(builder: Builder, operation: str, value: Operand) -> Operand:
    """Round a number to an integer by an operation."""
    number = value if operation == "truncate" else builder.compute(operation, value)
    made = builder.compute("integer_of_float", number)
    if isinstance(made, Value):
        builder.wholes[made] = (operation, value)
    return made


def widest(*kinds: Kind) -> Kind:
    """Kind that can hold values of all these kinds."""
    return next(kind for kind in (FLOAT, INTEGER, TRUTH) if kind in kinds)


def agreed(builder: Builder, *values: Operand) -> list[Operand]:
    """Convert values to the one kind that can hold them all."""
    kind = widest(*(value.kind for value in values))
    return [as_kind(builder, value, kind) for value in values]


def operated(builder: Builder, operator: type[ast.operator], a: Operand, b: Operand) -> Operand | None:
    """Apply an operator to two numbers; None if that takes a function of `FUNCTIONS`."""
    if a.kind is b.kind is TRUTH and operator in OF_TRUTH:
        return builder.compute(OF_TRUTH[operator], a, b)
    if FLOAT not in (a.kind, b.kind):
        if operator not in OF_INTEGERS:
            return None
        return builder.compute(OF_INTEGERS[operator], as_kind(builder, a, INTEGER), as_kind(builder, b, INTEGER))
    if operator not in OF_NUMBERS:
        return None
    return builder.compute(OF_NUMBERS[operator], *agreed(builder, a, b))


def needs_comparing(a: Operand, b: Operand) -> bool:
    """Return whether one is a number and the other an integer that may be inexact as a number."""
    whole = a if b.kind is FLOAT else b
    if {a.kind, b.kind} != {FLOAT, INTEGER}:
        return False
    return not (isinstance(whole, Immediate) and abs(int(whole.value)) <= _EXACT)


def compared(builder: Builder, operator: type[ast.cmpop], a: Operand, b: Operand) -> Operand:
    """Compare two values that are exact in the wider kind."""
    if a.kind is b.kind is TRUTH and operator in (ast.Eq, ast.NotEq):
        unequal = builder.compute("differ", a, b)
        return unequal if operator is ast.NotEq else builder.compute("not", unequal)
    operation, turned = _COMPARISONS[operator]
    kind = FLOAT if FLOAT in (a.kind, b.kind) else INTEGER
    left, right = as_kind(builder, a, kind), as_kind(builder, b, kind)
    if turned:
        left, right = right, left
    return builder.compute(operation if kind is FLOAT else f"{operation}_integers", left, right)


def negated(builder: Builder, value: Operand) -> Operand:
    """Negate a number."""
    if value.kind is FLOAT:
        return builder.compute("negate", value)
    return builder.compute("subtract_integers", 0, as_kind(builder, value, INTEGER))


def absolute(builder: Builder, value: Operand) -> Operand:
    """Absolute value of a number."""
    if value.kind is FLOAT:
        return builder.compute("absolute", value)
    whole = as_kind(builder, value, INTEGER)
    return builder.compute("select", builder.compute("less_integers", whole, 0), negated(builder, whole), whole)


def nan() -> Immediate:
    """The constant NaN."""
    return Immediate(FLOAT, math.nan)


def as_index(value: Operand) -> int | None:
    """Return a known integer, or None."""
    return int(value.value) if isinstance(value, Immediate) and value.kind is not FLOAT else None
