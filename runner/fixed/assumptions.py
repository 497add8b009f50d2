"""What is known of the nodes of a step where its conditions came out one way: narrower intervals."""

from collections.abc import Iterator
from contextlib import contextmanager

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import Node
from proofmass.runner.fixed.operations import COMPARISONS, interval_of

NEVER = 1 << 62
REACH = 12  # how many operations an assumption is followed through: enough for a rounding and a sum


class Assumptions:
    """Intervals under the conditions assumed so far. Always sound; narrower only where that is easy to see."""

    def __init__(self) -> None:
        self._known: dict[Node, Interval] = {}
        self._found: dict[Node, Interval] = {}
        self._first = NEVER  # number of the first node of which anything is assumed: none before it depends on that

    def clear(self) -> None:
        """Assume nothing."""
        self._known, self._found, self._first = {}, {}, NEVER

    def interval(self, node: Node) -> Interval:
        """The interval of a node under the assumptions."""
        return self._interval(node, REACH) if self._known else (node.low, node.high)

    @contextmanager
    def also(self, condition: Node, outcome: bool) -> Iterator[None]:
        """Assume a condition inside the `with` block."""
        known, found, first = dict(self._known), dict(self._found), self._first
        self.assume(condition, outcome)
        try:
            yield
        finally:
            self._known, self._found, self._first = known, found, first

    def assume(self, condition: Node, outcome: bool) -> None:
        """From here on the condition is known to hold (`outcome` True), or not to."""
        if condition.operation == "narrow":
            condition = condition.operands[0]
        is_truth = condition.low == 0 and condition.high == 1
        if is_truth or not outcome:
            self._cut(condition, int(outcome), int(outcome))
        a, b = condition.operands if len(condition.operands) == 2 else (condition, condition)
        if condition.operation in COMPARISONS:
            self._compared(condition.operation, a, b, outcome)
        elif condition.operation == ("and" if outcome else "or") and all(n.low >= 0 and n.high <= 1 for n in (a, b)):
            self.assume(a, outcome)
            self.assume(b, outcome)

    def _compared(self, operation: str, a: Node, b: Node, outcome: bool) -> None:
        if operation in ("less", "less_equal"):
            apart = int(operation == "less")
            if not outcome:  # not a < b is b <= a
                a, b, apart = b, a, 1 - apart
            self._cut(a, None, self.interval(b)[1] - apart)
            self._cut(b, self.interval(a)[0] + apart, None)
        elif outcome == (operation == "equal"):
            self._cut(a, *self.interval(b))
            self._cut(b, *self.interval(a))
        else:
            for node, other in ((a, b), (b, a)):
                if other.constant is not None:
                    low, high = self.interval(node)
                    self._cut(node, low + (low == other.constant), high - (high == other.constant))

    def _cut(self, node: Node, low: int | None, high: int | None, reach: int = REACH) -> None:
        """Take what is below `low` and above `high` from a node, and from what it was made of where that is exact."""
        before = self.interval(node)
        low = before[0] if low is None else max(low, before[0])
        high = before[1] if high is None else min(high, before[1])
        if low > high or (low, high) == before or node.operation == "constant":
            return  # an empty interval: the assumptions contradict each other, and this path is never taken
        self._known[node] = low, high
        self._first = min(self._first, node.number)
        self._found = {}
        if not node.operands or not reach:
            return
        first, reach = node.operands[0], reach - 1
        if node.operation in ("narrow", "pipe"):
            self._cut(first, low, high, reach)
        elif node.operation == "negate":
            self._cut(first, -high, -low, reach)
        elif len(node.operands) == 2:
            second = node.operands[1]
            if node.operation == "add" and second.constant is not None:
                self._cut(first, low - second.constant, high - second.constant, reach)
            elif node.operation == "add" and first.constant is not None:
                self._cut(second, low - first.constant, high - first.constant, reach)
            elif node.operation == "subtract" and second.constant is not None:
                self._cut(first, low + second.constant, high + second.constant, reach)
            elif node.operation == "subtract" and first.constant is not None:
                self._cut(second, first.constant - high, first.constant - low, reach)
            elif node.operation == "shift_left" and second.constant is not None:
                self._cut(first, -(-low >> second.constant), high >> second.constant, reach)
            elif node.operation == "shift_right" and second.constant is not None:
                self._cut(first, low << second.constant, ((high + 1) << second.constant) - 1, reach)

    def _interval(self, node: Node, reach: int) -> Interval:
        """From the operands' intervals, as far as the reach goes."""
        if node.number < self._first:
            return node.low, node.high
        found = self._found.get(node)
        if found is not None:
            return found
        low, high = self._known.get(node, (node.low, node.high))
        if reach and node.operands:
            operands = [self._interval(operand, reach - 1) for operand in node.operands]
            by_operands = interval_of(node.operation, operands)
            if max(low, by_operands[0]) <= min(high, by_operands[1]):
                low, high = max(low, by_operands[0]), min(high, by_operands[1])
        self._found[node] = low, high
        return low, high
