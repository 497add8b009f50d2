"""Exact intervals of integer operations: the least and the greatest result for operands of given intervals."""

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, Literal

Interval = tuple[int, int]
Operation = Literal[
    "constant",
    "input",
    "narrow",  # the same value, of which more is known
    "pipe",  # the same value, in hardware a tick later
    "add",
    "subtract",
    "multiply",
    "negate",
    "shift_left",
    "shift_right",  # arithmetic: the sign bit is repeated
    "and",
    "or",
    "xor",
    "less",
    "less_equal",
    "equal",
    "not_equal",
    "minimum",
    "maximum",
    "select",  # the second operand where the first is not 0, else the third
]

_TRUTHS = ((0, 0), (0, 1), (1, 1))
COMPARISONS = frozenset({"less", "less_equal", "equal", "not_equal"})
COMMUTATIVE = frozenset({"add", "multiply", "and", "or", "xor", "equal", "not_equal", "minimum", "maximum"})

EVALUATE: Mapping[str, Callable[..., Any]] = {
    "narrow": lambda a: a,
    "pipe": lambda a: a,
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "negate": operator.neg,
    "shift_left": operator.lshift,
    "shift_right": operator.rshift,
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
    "less": lambda a, b: int(a < b),
    "less_equal": lambda a, b: int(a <= b),
    "equal": lambda a, b: int(a == b),
    "not_equal": lambda a, b: int(a != b),
    "minimum": min,
    "maximum": max,
    "select": lambda condition, a, b: a if condition else b,
}


def signed_width(low: int, high: int) -> int:
    """Bits of the two's complement that holds every integer of the interval.

    >>> signed_width(-128, 127), signed_width(0, 255)
    (8, 9)
    """
    return max(low.bit_length() if low >= 0 else (-low - 1).bit_length(), high.bit_length() if high >= 0 else 0) + 1


def interval_of(operation: str, operands: Sequence[Interval]) -> Interval:
    """Interval of the result where every operand takes any value of its interval, independently."""
    if operation in COMPARISONS:
        return _comparison(operation, *operands)
    if operation in ("and", "or", "xor"):
        return _bitwise(operation, *operands)
    if operation == "select":
        (condition_low, condition_high), chosen, otherwise = operands
        if condition_low > 0 or condition_high < 0:
            return chosen
        if condition_low == condition_high:
            return otherwise
        return min(chosen[0], otherwise[0]), max(chosen[1], otherwise[1])
    return _corners(operation, operands)


def _corners(operation: str, operands: Sequence[Interval]) -> Interval:
    """These operations take their extremes where every operand does."""
    evaluate = EVALUATE[operation]
    if len(operands) == 1:
        values = [evaluate(end) for end in operands[0]]
    else:
        values = [evaluate(a, b) for a in operands[0] for b in operands[1]]
    return min(values), max(values)


def _comparison(operation: str, a: Interval, b: Interval) -> Interval:
    disjoint = a[1] < b[0] or b[1] < a[0]
    same = a == b and a[0] == a[1]
    always, never = {
        "less": (a[1] < b[0], a[0] >= b[1]),
        "less_equal": (a[1] <= b[0], a[0] > b[1]),
        "equal": (same, disjoint),
        "not_equal": (disjoint, same),
    }[operation]
    return int(always), int(not never)


@lru_cache(maxsize=4096)
def _bitwise(operation: str, a: Interval, b: Interval) -> Interval:
    """Greedy from the sign bit down; an operand is held by its bounds only while all its bits so far equal theirs.

    That takes time, so the usual cases, truth values and a mask of low bits, are seen to first.
    """
    if operation == "and" and a[0] == a[1] >= 0 and a[0] & (a[0] + 1) == 0:
        a, b = b, a
    if a in _TRUTHS and b in _TRUTHS:
        return _corners(operation, (a, b))
    if operation == "and" and b[0] == b[1] >= 0 and b[0] & (b[0] + 1) == 0:
        one_block = a[0] | b[0] == a[1] | b[0]  # the bits above the mask are the same in the whole interval
        return (a[0] & b[0], a[1] & b[0]) if one_block else (0, b[0])
    return _extreme(operation, a, b, greatest=False), _extreme(operation, a, b, greatest=True)


def _extreme(operation: str, a: Interval, b: Interval, *, greatest: bool) -> int:
    evaluate = EVALUATE[operation]
    width = max(signed_width(*a), signed_width(*b))
    sign = width - 1
    states = {(True, True, True, True)}  # whether the bits so far are those of a's low, a's high, b's low, b's high
    result = 0
    for place in range(sign, -1, -1):
        reached: dict[int, set[tuple[bool, bool, bool, bool]]] = {0: set(), 1: set()}
        for state in states:
            for bit_a, low_a, high_a in _bits(a, place, state[:2], is_sign=place == sign):
                for bit_b, low_b, high_b in _bits(b, place, state[2:], is_sign=place == sign):
                    reached[evaluate(bit_a, bit_b)].add((low_a, high_a, low_b, high_b))
        wanted = int(greatest) if place != sign else int(not greatest)  # a set sign bit makes the number smaller
        bit = wanted if reached[wanted] else 1 - wanted
        result += (-bit if place == sign else bit) << place
        states = reached[bit]
    return result


def _bits(interval: Interval, place: int, held: tuple[bool, ...], *, is_sign: bool) -> list[tuple[int, bool, bool]]:
    """Bits that a number of the interval may have in a place, and whether each bound still holds it then."""
    at_low, at_high = held
    low, high = ((end >> place) & 1 for end in interval)
    found = []
    for bit in (0, 1):
        order, first, last = (1 - bit, 1 - low, 1 - high) if is_sign else (bit, low, high)
        if (not at_low or order >= first) and (not at_high or order <= last):
            found.append((bit, at_low and bit == low, at_high and bit == high))
    return found
