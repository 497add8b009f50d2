"""A step function as a graph of integer operations: each value is made once, and has its exact interval.

Operations are hash-consed: one kind on the same operands is one operation. What is known beforehand
is folded. An operation's width follows from its interval, so that nothing can overflow unseen.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.digraph import with_following
from proofmass.runner.fixed.integer_interval import signed_width
from proofmass.runner.fixed.operations import OPERATIONS, OperationName, interval_of

MOST_OPERATIONS = 20_000  # a step of this size comes from a loop that was not meant to be unrolled


class SourceLine(NamedTuple):
    """The line of Python that made an operation."""

    path: str
    line: int

    @property
    def file(self) -> str:
        """The file without its folder."""
        return Path(self.path).name

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


class TraceError(ModelError):
    """A step function cannot become integer code; the problem has line, range and remedy."""

    def __init__(
        self, message: str, place: SourceLine | None, *, got: str = "", expected: str = "", hint: str, key: str = ""
    ) -> None:
        at = place or SourceLine("", 0)
        super().__init__(
            [Problem(message=message, file=at.file, line=at.line, key=key, got=got, expected=expected, hint=hint)]
        )


@dataclass(frozen=True, eq=False, slots=True)
class Operation:
    """One value of the step: an operation on earlier ones, and its least and greatest."""

    number: int  # in the order of making: operands have smaller ones
    kind: OperationName
    operands: tuple["Operation", ...]
    low: int
    high: int
    name: str  # of an input: how the step's arguments give it
    place: SourceLine | None

    @property
    def width(self) -> int:
        """Bits of two's complement."""
        return signed_width(self.low, self.high)

    @property
    def constant(self) -> int | None:
        """The value, where only one is possible, and nothing but a value is meant."""
        return self.low if self.low == self.high and self.kind != "rest" else None

    def __repr__(self) -> str:
        return f"<{self.kind} {self.number} in [{self.low}, {self.high}]>"


@dataclass
class IntegerProgram:
    """The operations of a step in the order of making; `place` tells the line of Python that is being traced."""

    place: Callable[[], SourceLine | None] = lambda: None
    name: str = ""
    operations: list[Operation] = field(default_factory=list)
    errors: dict[Operation, tuple[Drop, Operation]] = field(default_factory=dict)  # what each shift drops, and of what
    rests: bool = False  # whether what searches leave over is among them
    searches: bool = False  # whether some leave anything over
    _made: dict[tuple[object, ...], Operation] = field(default_factory=dict)

    def constant(self, value: int) -> Operation:
        """The operation of a constant."""
        return self._operation("constant", (), value, value)

    def input(self, name: str, low: int, high: int) -> Operation:
        """The operation of an argument's number, within the interval whenever the step runs."""
        if low == high:
            return self.constant(low)
        return self._operation("input", (), low, high, name)

    def narrow(self, operation: Operation, low: int, high: int) -> Operation:
        """Return the value with a narrower interval; the caller answers for the interval."""
        low, high = max(low, operation.low), min(high, operation.high)
        if (low, high) == (operation.low, operation.high) or low > high:
            return operation
        if low == high:
            return self.constant(low)
        whole = operation.operands[0] if operation.kind == "narrow" else operation
        return self._operation("narrow", (whole,), low, high)

    def make(self, kind: OperationName, *operands: Operation) -> Operation:
        """Return the operation on these operands, folded where such a value is known."""
        if OPERATIONS[kind].commutative and operands[0].number > operands[1].number:
            operands = operands[::-1]
        known = self._folded(kind, operands)
        if known is not None:
            return known
        low, high = _interval(kind, operands)
        return self.constant(low) if low == high and kind != "rest" else self._operation(kind, operands, low, high)

    @staticmethod
    def live(results: Iterable[Operation]) -> list[Operation]:
        """The operations that the results depend on, operands first."""
        live = with_following(results, lambda operation: operation.operands)
        return sorted(live, key=lambda operation: operation.number)

    def _operation(
        self, kind: OperationName, operands: tuple[Operation, ...], low: int, high: int, name: str = ""
    ) -> Operation:
        key = (kind, operands, low, high, name)
        if key not in self._made:
            place = self.place()
            if len(self.operations) >= MOST_OPERATIONS:
                hint = "a loop of a traced step is unrolled: make it shorter, or keep it in a block of plain integers"
                message = f"the step needs more than {MOST_OPERATIONS} operations"
                raise TraceError(message, place, hint=hint, key=self.name)
            self._made[key] = Operation(len(self.operations), kind, operands, low, high, name, place)
            self.operations.append(self._made[key])
        return self._made[key]

    def _folded(self, kind: OperationName, operands: tuple[Operation, ...]) -> Operation | None:
        values = [operation.constant for operation in operands]
        if kind == "select":
            return self._folded_select(*operands)
        if None not in values:
            return self.constant(OPERATIONS[kind].evaluate(*values))
        if len(operands) != 2:
            return None
        a, b = operands
        if a is b:
            known = OPERATIONS[kind].of_equals
            return a if known == "operand" else None if known is None else self.constant(known)
        neutral, commutative = OPERATIONS[kind].neutral, OPERATIONS[kind].commutative
        for value, other, second in ((values[0], b, False), (values[1], a, True)):
            if neutral is not None and value == neutral and (second or commutative):
                return other
            if kind == "multiply" and value is not None:
                if value == 0:
                    return self.constant(0)
                if value == -1:
                    return self.make("negate", other)
                if value & (value - 1) == 0:  # of no negative number
                    return self.make("shift_left", other, self.constant(value.bit_length() - 1))
            is_mask = kind == "and" and value is not None and value & (value + 1) == 0
            if is_mask and other.low >= 0 and other.high <= value:  # type: ignore[operator]
                return other
        if kind in ("minimum", "maximum"):
            below, above = (a, b) if a.high <= b.low else (b, a) if b.high <= a.low else (None, None)
            return below if kind == "minimum" else above
        return None

    def _folded_select(self, condition: Operation, chosen: Operation, otherwise: Operation) -> Operation | None:
        if chosen is otherwise:
            return chosen
        if condition.low > 0 or condition.high < 0:
            return chosen
        if condition.constant == 0:
            return otherwise
        is_truth = condition.low == 0 and condition.high == 1
        return condition if is_truth and (chosen.constant, otherwise.constant) == (1, 0) else None


def _interval(kind: OperationName, operands: tuple[Operation, ...]) -> tuple[int, int]:
    low, high = interval_of(kind, [(operation.low, operation.high) for operation in operands])
    if kind == "multiply" and operands[0] is operands[1]:  # a square
        ends = (operands[0].low ** 2, operands[0].high ** 2)
        return (0 if operands[0].low < 0 < operands[0].high else min(ends)), max(ends)
    return low, high
