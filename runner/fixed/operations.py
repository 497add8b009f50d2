"""The integer operations of a traced step: each one's value, interval and texts in one table.

A proof reads none of it: what operations mean to a solver stands apart, so that a fault here is
found there.
"""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any, Literal

from proofmass.runner.fixed.integer_interval import (
    Interval,
    bitwise,
    comparison,
    conjunction,
    corners,
    equality,
    inequality,
    selection,
)

OperationName = Literal[
    "constant",
    "input",
    "narrow",
    "pipe",
    "add",
    "subtract",
    "multiply",
    "negate",
    "shift_left",
    "shift_right",
    "and",
    "or",
    "xor",
    "less",
    "less_equal",
    "equal",
    "not_equal",
    "minimum",
    "maximum",
    "select",
    "rest",
]


@dataclass(frozen=True, kw_only=True)
class OperationKind:
    """One operation on integers; its texts name the operands {0}, {1}, {2}."""

    evaluate: Callable[..., Any]
    interval: Callable[..., Interval]  # of the result, from those of the operands
    word: str  # first part of the names of wires that hold a result
    python: str
    verilog: str = ""  # Python's unless it is given
    amaranth: str = ""  # Python's unless it is given
    commutative: bool = False
    adder: bool = False  # in hardware a carry chain
    comparison: bool = False  # the result is 0 or 1; its text in Python is a truth value
    neutral: int | None = None  # the second operand with which the first is the result; where commutative, either
    of_equals: int | Literal["operand"] | None = None  # the result of equal operands

    def in_verilog(self, *operands: str) -> str:
        """The text in Verilog."""
        return (self.verilog or self.python).format(*operands)

    def in_amaranth(self, *operands: str) -> str:
        """The text in Amaranth."""
        return (self.amaranth or self.python).format(*operands)


def _arithmetic(evaluate: Callable[..., Any], word: str, python: str, **more: Any) -> OperationKind:
    """An operation that takes its extremes where every operand does."""
    return OperationKind(evaluate=evaluate, interval=partial(corners, evaluate), word=word, python=python, **more)


def _bitwise(interval: Callable[..., Interval], evaluate: Callable[..., Any], word: str, **more: Any) -> OperationKind:
    return OperationKind(evaluate=evaluate, interval=partial(interval, evaluate), word=word, commutative=True, **more)


def _comparison(test: Callable[..., bool], interval: Callable[..., Interval], word: str, sign: str, **more: Any) -> Any:
    """A comparison that holds for all values of two intervals, or for none, where they say so."""
    more |= {"evaluate": lambda a, b: int(test(a, b)), "interval": interval, "python": f"{{0}} {sign} {{1}}"}
    return OperationKind(word=word, comparison=True, **more)


OPERATIONS: Mapping[OperationName, OperationKind] = MappingProxyType(
    {
        # the same value, of which more is known
        "narrow": _arithmetic(operator.pos, "low_bits", "{0}"),
        # the same value, in hardware a tick later
        "pipe": _arithmetic(operator.pos, "cut", "{0}"),
        "add": _arithmetic(operator.add, "sum", "{0} + {1}", commutative=True, adder=True, neutral=0),
        "subtract": _arithmetic(operator.sub, "difference", "{0} - {1}", adder=True, neutral=0, of_equals=0),
        "multiply": _arithmetic(operator.mul, "product", "{0} * {1}", commutative=True, neutral=1),
        "negate": _arithmetic(operator.neg, "negated", "-{0}", adder=True),
        "shift_left": _arithmetic(operator.lshift, "shifted", "{0} << {1}", verilog="{0} <<< {1}", neutral=0),
        # arithmetic: the sign bit is repeated
        "shift_right": _arithmetic(operator.rshift, "shifted", "{0} >> {1}", verilog="{0} >>> {1}", neutral=0),
        "and": _bitwise(conjunction, operator.and_, "both", python="{0} & {1}", of_equals="operand"),
        "or": _bitwise(bitwise, operator.or_, "either", python="{0} | {1}", neutral=0, of_equals="operand"),
        "xor": _bitwise(bitwise, operator.xor, "unlike", python="{0} ^ {1}", neutral=0, of_equals=0),
        "less": _comparison(operator.lt, partial(comparison, operator.lt), "less", "<", of_equals=0),
        "less_equal": _comparison(operator.le, partial(comparison, operator.le), "at_most", "<=", of_equals=1),
        "equal": _comparison(operator.eq, equality, "equal", "==", commutative=True, of_equals=1),
        "not_equal": _comparison(operator.ne, inequality, "differs", "!=", commutative=True, of_equals=0),
        "minimum": _arithmetic(
            min,
            "smaller",
            "{0} if {0} < {1} else {1}",
            verilog="({0} < {1}) ? {0} : {1}",
            amaranth="Mux({0} < {1}, {0}, {1})",
            commutative=True,
            of_equals="operand",
        ),
        "maximum": _arithmetic(
            max,
            "larger",
            "{0} if {0} > {1} else {1}",
            verilog="({0} > {1}) ? {0} : {1}",
            amaranth="Mux({0} > {1}, {0}, {1})",
            commutative=True,
            of_equals="operand",
        ),
        # the second operand where the first is not 0, else the third
        "select": OperationKind(
            evaluate=lambda condition, chosen, otherwise: chosen if condition else otherwise,
            interval=selection,
            word="chosen",
            python="{1} if {0} else {2}",
            verilog="{0} ? {1} : {2}",
            amaranth="Mux({0}, {1}, {2})",
        ),
        # 0, what a search by signs leaves over; where slopes are followed, with that of third * first / second
        "rest": OperationKind(
            evaluate=lambda part, whole, scale: 0,
            interval=lambda part, whole, scale: (0, 0),
            word="rest",
            python="0 * ({0} + {1} + {2})",
        ),
    }
)
COMPARISONS = frozenset(name for name, operation in OPERATIONS.items() if operation.comparison)
BITWISE = frozenset({"and", "or", "xor"})


def interval_of(operation: OperationName, operands: Sequence[Interval]) -> Interval:
    """Interval of the result where every operand takes any value of its interval, independently."""
    return OPERATIONS[operation].interval(*operands)
