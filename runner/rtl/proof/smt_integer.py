"""Integers as SMT words: a step function that runs on them becomes the specification of a proof.

An `SmtInteger` is two's complement, as wide as its bounds need, so that no operation can overflow.
It implements all of `Mantissa` and shares nothing with the tracer: it has its own bounds, branches
and folding, so that a proof finds a fault of the tracer and does not repeat it. A plain `if` is
followed both ways, and the results are merged.
"""

import operator
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NoReturn

from proofmass.blocks.arithmetic.fixed_format import MOST_BITS
from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.arithmetic.mantissa import Mantissa
from proofmass.runner.fixed.integer_interval import signed_width

MOST_PATHS = 1024


class Specification:
    """SMT-LIB definitions in order, each value once, and the conditions of their validity."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.obligations: list[str] = []  # conditions that must always hold
        self.cuts: list[SmtInteger] = []  # words worth proving on their own: products and choices
        self._names: dict[str, str] = {}
        self._script: Sequence[bool] = ()
        self._taken: list[tuple[SmtInteger, bool]] = []
        self._paths = 0

    def constant(self, value: int) -> "SmtInteger":
        """The word of a Python integer."""
        width = signed_width(value, value)
        return SmtInteger(self, f"(_ bv{value % (1 << width)} {width})", value, value)

    def lift(self, value: Any) -> "SmtInteger":
        """Return the word of a number of a step; raises TypeError for anything else."""
        if isinstance(value, SmtInteger):
            return value
        if isinstance(value, int):
            return self.constant(int(value))
        raise TypeError(f"a {type(value).__name__} among integers")

    def word(self, body: str, low: int, high: int) -> "SmtInteger":
        """A value of a term, which has the width of its bounds."""
        if low == high:
            return self.constant(low)
        made = len(self.lines)
        found = SmtInteger(self, self._named(body, f"(_ BitVec {signed_width(low, high)})"), low, high)
        if len(self.lines) > made and body.startswith(("(bvmul", "(ite")):
            self.cuts.append(found)
        return found

    def truth(self, body: str) -> "SmtInteger":
        """1 where a Boolean term holds, else 0."""
        return self.word(f"(ite {self._named(body, 'Bool')} #b01 #b00)", 0, 1)

    def decide(self, condition: "SmtInteger") -> bool:
        """Outcome of a condition on the present path."""
        if condition.low > 0 or condition.high < 0 or condition.low == condition.high:
            return condition.low != 0
        for known, outcome in self._taken:
            if known.text == condition.text:
                return outcome
        i = len(self._taken)
        outcome = self._script[i] if i < len(self._script) else True
        self._taken.append((condition, outcome))
        return outcome

    def merged(self, run: Callable[[], list[Any]], script: Sequence[bool] = ()) -> list["SmtInteger"]:
        """Results of all paths through a function that begin with the script, merged into one."""
        self._paths += 1
        if self._paths > MOST_PATHS:
            raise ValueError(f"more than {MOST_PATHS} paths through the branches")
        self._script, self._taken = script, []
        results = [self.lift(value) for value in run()]
        taken = self._taken
        for i in range(len(taken) - 1, len(script) - 1, -1):
            others = self.merged(run, [*(outcome for _, outcome in taken[:i]), False])
            results = [taken[i][0].select(a, b) for a, b in zip(results, others, strict=True)]
        self._taken = []
        return results

    def demand(self, condition: str) -> None:
        """Note a condition that must hold on the present path."""
        path = conjunction(c.holds if outcome else f"(not {c.holds})" for c, outcome in self._taken)
        obligation = f"(=> {path} {condition})"
        if obligation not in self.obligations:
            self.obligations.append(obligation)

    def _named(self, body: str, sort: str) -> str:
        if body not in self._names:
            name = f"spec{len(self._names)}"
            self._names[body] = name
            self.lines.append(f"(define-fun {name} () {sort} {body})")
        return self._names[body]


def _operators(way: Callable[..., Any], operation: str, evaluate: Callable[[int, int], int]) -> tuple[Any, Any]:
    """Return the operator that is written in a way, and the same with its operands turned round."""
    return (
        lambda self, other: way(self, operation, self, other, evaluate),
        lambda self, other: way(self, operation, other, self, evaluate),
    )


def _comparison(operation: str, always: Callable[..., bool], never: Callable[..., bool]) -> Any:
    """Return the operator of a comparison that the bounds of its operands may decide."""

    def compared(self: "SmtInteger", other: Any) -> Any:
        if isinstance(other, FixedValue):
            return NotImplemented
        other = self.specification.lift(other)
        if always(self, other) or never(self, other):
            return self.specification.constant(int(always(self, other)))
        width = max(self.width, other.width)
        return self.specification.truth(f"({operation} {self.resized(width)} {other.resized(width)})")

    return compared


def _same(a: "SmtInteger", b: "SmtInteger") -> bool:
    return a.text == b.text or (a.low == a.high == b.low == b.high)


def _apart(a: "SmtInteger", b: "SmtInteger") -> bool:
    return a.high < b.low or b.high < a.low


class SmtInteger(Mantissa):
    """An integer between two bounds, as the SMT term `text` of their width."""

    __slots__ = ("high", "low", "specification", "text")

    def __init__(self, specification: Specification, text: str, low: int, high: int) -> None:
        self.specification = specification
        self.text = text
        self.low = low
        self.high = high

    @property
    def width(self) -> int:
        """Bits of the word."""
        return signed_width(self.low, self.high)

    @property
    def holds(self) -> str:
        """Boolean term: the value is not 0."""
        return f"(distinct {self.text} (_ bv0 {self.width}))"

    def resized(self, width: int) -> str:
        """The term at another width: the sign repeated, or the low bits alone."""
        return resized(self.text, self.width, width)

    def within(self, low: int, high: int) -> str:
        """Boolean term: the value lies between two bounds."""
        width = max(self.width, signed_width(low, high))
        least, greatest = (self.specification.constant(end).resized(width) for end in (low, high))
        above = [f"(bvsle {least} {self.resized(width)})"] * (self.low < low)
        return conjunction([*above, *[f"(bvsle {self.resized(width)} {greatest})"] * (self.high > high)])

    # -- arithmetic --------------------------------------------------------------------------------

    def __mul__(self, other: Any) -> Any:
        if isinstance(other, int) and other > 0 and other & (other - 1) == 0:
            return self << (other.bit_length() - 1)
        return self._ring("bvmul", self, other, operator.mul)

    __rmul__ = __mul__

    def __neg__(self) -> Any:
        return 0 - self

    def __abs__(self) -> Any:
        return (self < 0).select(-self, self)

    def _ring(self, operation: str, a: Any, b: Any, evaluate: Callable[[int, int], int]) -> Any:
        """Sum, difference or product: the low bits of the result need no more of the operands than their low bits."""
        if isinstance(a, FixedValue) or isinstance(b, FixedValue):
            return NotImplemented
        a, b = self.specification.lift(a), self.specification.lift(b)
        corners = [evaluate(x, y) for x in (a.low, a.high) for y in (b.low, b.high)]
        low, high = min(corners), max(corners)
        width = signed_width(low, high)
        return self.specification.word(f"({operation} {a.resized(width)} {b.resized(width)})", low, high)

    __add__, __radd__ = _operators(_ring, "bvadd", operator.add)
    __sub__, __rsub__ = _operators(_ring, "bvsub", operator.sub)

    # -- bits --------------------------------------------------------------------------------------

    def __and__(self, other: Any) -> Any:
        other = self.specification.lift(other)
        positive = [each.high for each in (self, other) if each.low >= 0]
        return self._bits("bvand", other, (0, min(positive)) if positive else None)

    def __or__(self, other: Any) -> Any:
        return self._bits("bvor", self.specification.lift(other), None)

    def __xor__(self, other: Any) -> Any:
        return self._bits("bvxor", self.specification.lift(other), None)

    __rand__, __ror__, __rxor__ = __and__, __or__, __xor__

    def _bits(self, operation: str, other: "SmtInteger", bounds: tuple[int, int] | None) -> "SmtInteger":
        width = max(self.width, other.width)
        highest = (1 << (width - 1)) - 1
        low, high = bounds or (0 if self.low >= 0 and other.low >= 0 else -highest - 1, highest)
        return self._fitted(f"({operation} {self.resized(width)} {other.resized(width)})", width, low, high)

    def _shifted(self, operation: str, value: Any, places: Any, evaluate: Callable[[int, int], int]) -> Any:
        if isinstance(value, FixedValue):
            return NotImplemented
        value, places = self.specification.lift(value), self.specification.lift(places)
        if places.low < 0:
            self.specification.demand(f"(bvsge {places.text} (_ bv0 {places.width}))")
        if places.low == places.high == 0:
            return value
        ends = max(places.low, 0), min(max(places.high, 0), MOST_BITS)
        corners = [evaluate(x, y) for x in (value.low, value.high) for y in ends]
        low, high = min(corners), max(corners)
        width = max(value.width, places.width, signed_width(low, high))
        return self._fitted(f"({operation} {value.resized(width)} {places.resized(width)})", width, low, high)

    __lshift__, __rlshift__ = _operators(_shifted, "bvshl", operator.lshift)
    __rshift__, __rrshift__ = _operators(_shifted, "bvashr", operator.rshift)

    def _fitted(self, term: str, width: int, low: int, high: int) -> "SmtInteger":
        """A term whose value is known to lie within bounds of a smaller width."""
        return self.specification.word(resized(term, width, signed_width(low, high)), low, high)

    def __floordiv__(self, divisor: Any) -> Any:
        return self >> _power_of_two(divisor)

    def __mod__(self, divisor: Any) -> Any:
        return self & ((1 << _power_of_two(divisor)) - 1)

    # -- comparisons and branches ------------------------------------------------------------------

    __lt__ = _comparison("bvslt", lambda a, b: a.high < b.low, lambda a, b: a.low >= b.high)
    __le__ = _comparison("bvsle", lambda a, b: a.high <= b.low, lambda a, b: a.low > b.high)
    __gt__ = _comparison("bvsgt", lambda a, b: a.low > b.high, lambda a, b: a.high <= b.low)
    __ge__ = _comparison("bvsge", lambda a, b: a.low >= b.high, lambda a, b: a.high < b.low)
    __eq__ = _comparison("=", _same, _apart)
    __ne__ = _comparison("distinct", _apart, _same)
    __hash__ = object.__hash__

    def __bool__(self) -> bool:
        return self.specification.decide(self)

    def __index__(self) -> NoReturn:
        raise TypeError("a signal bounds a loop or indexes a list")

    __int__ = __float__ = __index__

    def __repr__(self) -> str:
        return f"{self.text} in [{self.low}, {self.high}]"

    # -- what a mantissa does in a way of its own --------------------------------------------------

    def select(self, chosen: Any, otherwise: Any) -> "SmtInteger":
        """`chosen` where the value is not 0, else `otherwise`."""
        first, second = self.specification.lift(chosen), self.specification.lift(otherwise)
        if self.low > 0 or self.high < 0 or self.low == self.high:
            return first if self.low else second
        if first.text == second.text:
            return first
        low, high = min(first.low, second.low), max(first.high, second.high)
        width = signed_width(low, high)
        return self.specification.word(f"(ite {self.holds} {first.resized(width)} {second.resized(width)})", low, high)

    def minimum(self, other: Any) -> Any:
        """The smaller of the two."""
        other = self.specification.lift(other)
        low, high = min(self.low, other.low), min(self.high, other.high)
        return self._chosen(self <= other, other, low, high)

    def maximum(self, other: Any) -> Any:
        """The greater of the two."""
        other = self.specification.lift(other)
        low, high = max(self.low, other.low), max(self.high, other.high)
        return self._chosen(self >= other, other, low, high)

    def _chosen(self, condition: Any, other: "SmtInteger", low: int, high: int) -> "SmtInteger":
        both: SmtInteger = condition.select(self, other)
        return both if (both.low, both.high) == (low, high) else self._fitted(both.text, both.width, low, high)

    def held(self, low: int, high: int, expected: str) -> "SmtInteger":
        """The value itself; the proof must show that it stays between the bounds."""
        if low <= self.low and self.high <= high:
            return self
        self.specification.demand(self.within(low, high))
        return self._fitted(self.text, self.width, max(low, self.low), min(high, self.high))


def resized(term: str, width: int, target: int) -> str:
    """A term at another width: the sign repeated, or the low bits alone.

    >>> resized("x", 8, 10), resized("x", 8, 4)
    ('((_ sign_extend 2) x)', '((_ extract 3 0) x)')
    """
    if target > width:
        return f"((_ sign_extend {target - width}) {term})"
    return f"((_ extract {target - 1} 0) {term})" if target < width else term


def conjunction(conditions: Iterable[str]) -> str:
    """Boolean term: all conditions hold.

    >>> conjunction([]), conjunction(["a", "b"])
    ('true', '(and true a b)')
    """
    all_of = " ".join(conditions)
    return f"(and true {all_of})" if all_of else "true"


def _power_of_two(divisor: Any) -> int:
    if not isinstance(divisor, int) or divisor < 1 or divisor & (divisor - 1):
        raise TypeError(f"a division by {divisor!r}, which is not a constant power of two")
    return divisor.bit_length() - 1
