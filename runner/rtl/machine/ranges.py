"""Ranges of plain integers in registers: intervals that contain the start and that no step leaves.

An interval that a step leaves is widened: first to the values that the step reaches, then to the
next constant of the step or the next power of two. Once no step leaves it, steps from it narrow it
again. So a counter
`0 if n == 1022 else n + 1` has the range 0 to 1022, and a register after a mask the range of the
mask.
"""

from bisect import bisect_left
from collections.abc import Callable, Mapping
from typing import NoReturn

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation, TraceError

_POWERS = (1, 2, 3, 4, 6, 8, 10, 12, 14, 16, 20, 24, 32, 40, 48, 56, 62)
_EXACT = 2  # steps followed before intervals grow beyond the values reached
_NARROWINGS = 4

_Step = Callable[
    [Mapping[str, Interval]], tuple[IntegerProgram, Mapping[str, list[Operation]]]
]  # its values after a step


def register_ranges(name: str, starts: Mapping[str, Interval], step: _Step) -> dict[str, Interval]:
    """The interval of each register from that of its start; raises `TraceError` for one that grows without bound."""
    ranges = dict(starts)
    grown, steps = True, 0
    while grown:
        grown, steps = False, steps + 1
        program, following = step(ranges)
        lowest, highest = _thresholds(program)
        for text, operations in following.items():
            low, high = _union(starts[text], operations)
            before = ranges[text]
            down = -before[0] if low >= before[0] else _next(lowest, -low)
            up = before[1] if high <= before[1] else _next(highest, high)
            if down is None or up is None:
                _refuse(name, text, operations, before)
            ranges[text] = (min(low, before[0]), max(high, before[1])) if steps <= _EXACT else (-down, up)
            grown |= ranges[text] != before
    for _ in range(_NARROWINGS):
        _, following = step(ranges)
        inside = {text: _union(starts[text], operations) for text, operations in following.items()}
        if inside == ranges:
            break
        ranges = inside
    return ranges


def _union(start: Interval, operations: list[Operation]) -> Interval:
    return min(start[0], *(operation.low for operation in operations)), max(
        start[1], *(operation.high for operation in operations)
    )


def _thresholds(program: IntegerProgram) -> tuple[list[int], list[int]]:
    """Bounds to try: of the negative of the low end, and of the high end."""
    near = {
        operation.low + beside
        for operation in program.operations
        if operation.kind == "constant"
        for beside in (-1, 0, 1)
    }
    lowest = {-each for each in near} | {1 << power for power in _POWERS}
    highest = near | {(1 << power) - 1 for power in _POWERS}
    return sorted(lowest), sorted(highest)


def _next(thresholds: list[int], value: int) -> int | None:
    i = bisect_left(thresholds, value)
    return thresholds[i] if i < len(thresholds) else None


def _reach(operation: Operation) -> int:
    return max(abs(operation.low), abs(operation.high))


def _refuse(name: str, text: str, operations: list[Operation], before: Interval) -> NoReturn:
    furthest = max(operations, key=_reach)
    while furthest.kind in ("select", "narrow"):
        furthest = max(furthest.operands[furthest.kind == "select" :], key=_reach)
    raise TraceError(
        f"{text} grows without bound",
        furthest.place,
        got=f"[{furthest.low}, {furthest.high}] after a step from [{before[0]}, {before[1]}]",
        expected="a range that no step leaves",
        hint="hold it with clip() or a mask, or let it start again behind an `if`; or make it a FixedValue with a "
        "format",
        key=f"{name}: {text}",
    )
