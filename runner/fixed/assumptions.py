"""Narrower intervals of the operations of a step, where its conditions came out one way."""

from collections.abc import Iterator
from contextlib import contextmanager

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import Operation
from proofmass.runner.fixed.operations import COMPARISONS, interval_of

NEVER = 1 << 62
REACH = 12  # how many operations an assumption is followed through: enough for a rounding and a sum


class Assumptions:
    """Intervals under the conditions assumed so far. Always sound; narrower only where that is easy to see."""

    def __init__(self) -> None:
        self._known: dict[Operation, Interval] = {}
        self._found: dict[Operation, Interval] = {}
        self._first = NEVER  # number of the first operation with one: none earlier depends on it

    def clear(self) -> None:
        """Assume nothing."""
        self._known, self._found, self._first = {}, {}, NEVER

    def interval(self, operation: Operation) -> Interval:
        """The interval of an operation under the assumptions."""
        return self._interval(operation, REACH) if self._known else (operation.low, operation.high)

    @contextmanager
    def also(self, condition: Operation, outcome: bool) -> Iterator[None]:
        """Assume a condition inside the `with` block."""
        known_before, found_before, first_before = dict(self._known), dict(self._found), self._first
        self.assume(condition, outcome)
        try:
            yield
        finally:
            self._known, self._found, self._first = known_before, found_before, first_before

    def assume(self, condition: Operation, outcome: bool) -> None:
        """Take the condition to hold from here on (`outcome` True), or not to."""
        if condition.kind == "narrow":
            condition = condition.operands[0]
        is_truth = condition.low == 0 and condition.high == 1
        if is_truth or not outcome:
            self._cut(condition, int(outcome), int(outcome))
        a, b = condition.operands if len(condition.operands) == 2 else (condition, condition)
        if condition.kind in COMPARISONS:
            self._compared(condition.kind, a, b, outcome)
        elif condition.kind == ("and" if outcome else "or") and all(n.low >= 0 and n.high <= 1 for n in (a, b)):
            self.assume(a, outcome)
            self.assume(b, outcome)

    def _compared(self, kind: str, a: Operation, b: Operation, outcome: bool) -> None:
        if kind in ("less", "less_equal"):
            apart = int(kind == "less")
            if not outcome:  # not a < b is b <= a
                a, b, apart = b, a, 1 - apart
            self._cut(a, None, self.interval(b)[1] - apart)
            self._cut(b, self.interval(a)[0] + apart, None)
        elif outcome == (kind == "equal"):
            self._cut(a, *self.interval(b))
            self._cut(b, *self.interval(a))
        else:
            for operation, other in ((a, b), (b, a)):
                if other.constant is not None:
                    low, high = self.interval(operation)
                    self._cut(operation, low + (low == other.constant), high - (high == other.constant))

    def _cut(self, operation: Operation, low: int | None, high: int | None, reach: int = REACH) -> None:
        """Take what is below `low` and above `high` from an operation, and from its operands where that is exact."""
        before = self.interval(operation)
        low = before[0] if low is None else max(low, before[0])
        high = before[1] if high is None else min(high, before[1])
        if low > high or (low, high) == before or operation.kind == "constant":
            return  # an empty interval: assumptions contradict each other: never taken
        self._known[operation] = low, high
        self._first = min(self._first, operation.number)
        self._found = {}
        if not operation.operands or not reach:
            return
        first, reach = operation.operands[0], reach - 1
        if operation.kind in ("narrow", "pipe"):
            self._cut(first, low, high, reach)
        elif operation.kind == "negate":
            self._cut(first, -high, -low, reach)
        elif len(operation.operands) == 2:
            second = operation.operands[1]
            if operation.kind == "add" and second.constant is not None:
                self._cut(first, low - second.constant, high - second.constant, reach)
            elif operation.kind == "add" and first.constant is not None:
                self._cut(second, low - first.constant, high - first.constant, reach)
            elif operation.kind == "subtract" and second.constant is not None:
                self._cut(first, low + second.constant, high + second.constant, reach)
            elif operation.kind == "subtract" and first.constant is not None:
                self._cut(second, first.constant - high, first.constant - low, reach)
            elif operation.kind == "shift_left" and second.constant is not None:
                self._cut(first, -(-low >> second.constant), high >> second.constant, reach)
            elif operation.kind == "shift_right" and second.constant is not None:
                self._cut(first, low << second.constant, ((high + 1) << second.constant) - 1, reach)

    def _interval(self, operation: Operation, reach: int) -> Interval:
        """Return the interval that follows from those of the operands, as far as the reach goes."""
        if operation.number < self._first:
            return operation.low, operation.high
        found = self._found.get(operation)
        if found is not None:
            return found
        low, high = self._known.get(operation, (operation.low, operation.high))
        if reach and operation.operands:
            operands = [self._interval(operand, reach - 1) for operand in operation.operands]
            by_operands = interval_of(operation.kind, operands)
            if max(low, by_operands[0]) <= min(high, by_operands[1]):
                low, high = max(low, by_operands[0]), min(high, by_operands[1])
        self._found[operation] = low, high
        return low, high
