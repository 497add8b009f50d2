"""Integer code: what programs need of a traced step to compute it in integers of 64 bits.

A value that 64 bits do not hold is refused, never wrapped.
"""

from collections.abc import Sequence
from typing import NamedTuple

from proofmass.runner.fixed.integer_interval import Interval
from proofmass.runner.fixed.integer_ir import IntegerProgram, Operation, TraceError
from proofmass.runner.fixed.operations import interval_of
from proofmass.runner.fixed.trace import Traced

LOWEST, HIGHEST = -(1 << 63), (1 << 63) - 1


class IntegerCode(NamedTuple):
    """A traced step with the operations to compute, in order; it returns (result, value of each of `beside`...)."""

    traced: Traced
    beside: Sequence[Operation]
    live: Sequence[Operation]
    clamped: set[Operation]  # those narrowed operations that are not only known to be within bounds, but held there


def integer_code(traced: Traced, beside: Sequence[Operation] = ()) -> IntegerCode:
    """Return the integer code of a step; raises `TraceError` where 64 bits do not hold a value."""
    live = traced.program.live([*traced.results.values(), *traced.writes.values(), *beside])
    return IntegerCode(traced, beside, live, _clamped(live, traced.name))


def _clamped(live: list[Operation], name: str) -> set[Operation]:
    """The narrowed operations that must be clamped in the code, so that no 64-bit operation overflows.

    Straight-line code computes the values of branches that are not taken, too, where what the
    branch's condition says does not hold; and an overflow is undefined in compiled code even where
    its result is not used. So intervals are made again without those conditions, and where one
    leaves 64 bits the conditions that it needs are enforced.
    """
    clamped: set[Operation] = set()
    while True:
        always: dict[Operation, Interval] = {}
        enforced = len(clamped)
        for operation in live:
            always[operation] = _unconditional(operation, always, clamped)
            low, high = always[operation]
            if low < LOWEST or high > HIGHEST or _shifts_too_far(operation, always):
                above = IntegerProgram.live(operation.operands)
                needed = {n for n in above if n.kind == "narrow" and always[n] != (n.low, n.high)}
                if not needed:
                    _refuse(operation, name)
                clamped |= needed
                break
        if len(clamped) == enforced:
            return clamped


def _unconditional(operation: Operation, always: dict[Operation, Interval], clamped: set[Operation]) -> Interval:
    if not operation.operands or operation in clamped:
        return operation.low, operation.high
    operands = [always[operand] for operand in operation.operands]
    if operation.kind in ("shift_left", "shift_right"):  # a negative number of places is seen to by the caller
        operands[1] = max(operands[1][0], 0), max(operands[1][1], 0)
        if operands[1][1] > 1024:
            operands[1] = operands[1][0], 1024
    return interval_of(operation.kind, operands)


def _shifts_too_far(operation: Operation, always: dict[Operation, Interval]) -> bool:
    if operation.kind not in ("shift_left", "shift_right"):
        return False
    low, high = always[operation.operands[1]]
    constant_right = operation.kind == "shift_right" and operation.operands[1].constant is not None
    return low < 0 or (high > 63 and not constant_right)


def _refuse(operation: Operation, name: str) -> None:
    got = f"[{operation.low}, {operation.high}], {operation.width} bits"
    if operation.low >= LOWEST and operation.high <= HIGHEST:
        places = operation.operands[1]
        got = f"a shift by {places.low} to {places.high} places"
    hint = "round or clip the operands with .to(format) before, or take narrower formats"
    message = f"the {operation.kind.replace('_', ' ')} is wider than the 64 bits of compiled code"
    raise TraceError(message, operation.place, got=got, expected=f"[{LOWEST}, {HIGHEST}], 64 bits", hint=hint, key=name)
