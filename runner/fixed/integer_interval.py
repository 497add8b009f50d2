"""Exact intervals: the least and the greatest result of an operation for given intervals."""

from collections.abc import Callable
from functools import lru_cache

Interval = tuple[int, int]

_TRUTHS = ((0, 0), (0, 1), (1, 1))


def signed_width(low: int, high: int) -> int:
    """Bits of the two's complement that holds every integer of the interval.

    >>> signed_width(-128, 127), signed_width(0, 255)
    (8, 9)
    """
    return max(low.bit_length() if low >= 0 else (-low - 1).bit_length(), high.bit_length() if high >= 0 else 0) + 1


def corners(evaluate: Callable[..., int], *operands: Interval) -> Interval:
    """Interval of an operation of one or two operands that takes its extremes where every operand does.

    >>> corners(lambda a, b: a * b, (-2, 3), (4, 5))
    (-10, 15)
    """
    if len(operands) == 1:
        values = [evaluate(end) for end in operands[0]]
    else:
        values = [evaluate(a, b) for a in operands[0] for b in operands[1]]
    return min(values), max(values)


def comparison(test: Callable[[int, int], bool], a: Interval, b: Interval) -> Interval:
    """Interval of < or <=: always true if it is where operands are nearest the contrary."""
    return int(test(a[1], b[0])), int(test(a[0], b[1]))


def equality(a: Interval, b: Interval) -> Interval:
    """Interval of ==."""
    return int(a == b and a[0] == a[1]), int(a[0] <= b[1] and b[0] <= a[1])


def inequality(a: Interval, b: Interval) -> Interval:
    """Interval of !=."""
    never, always = equality(a, b)
    return 1 - always, 1 - never


def selection(condition: Interval, chosen: Interval, otherwise: Interval) -> Interval:
    """Interval of the second operand where the first is not 0, else of the third."""
    low, high = condition
    if low > 0 or high < 0:
        return chosen
    if low == high:
        return otherwise
    return min(chosen[0], otherwise[0]), max(chosen[1], otherwise[1])


def conjunction(evaluate: Callable[[int, int], int], a: Interval, b: Interval) -> Interval:
    """Return the interval of a bitwise and; a mask of low bits is a case of its own."""
    if a[0] == a[1] >= 0 and a[0] & (a[0] + 1) == 0:
        a, b = b, a
    mask = b[0]
    if b[0] == b[1] >= 0 and mask & (mask + 1) == 0 and not (a in _TRUTHS and b in _TRUTHS):
        one_block = a[0] | mask == a[1] | mask  # bits above the mask are the same in it
        return (a[0] & mask, a[1] & mask) if one_block else (0, mask)
    return bitwise(evaluate, a, b)


@lru_cache(maxsize=4096)
def bitwise(evaluate: Callable[[int, int], int], a: Interval, b: Interval) -> Interval:
    """Interval of an operation on bits: greedy from the sign bit down.

    An operand is held by its bounds only while all its bits so far equal theirs. That takes time,
    so the usual case of truth values is seen to first.
    """
    if a in _TRUTHS and b in _TRUTHS:
        return corners(evaluate, a, b)
    return _extreme(evaluate, a, b, greatest=False), _extreme(evaluate, a, b, greatest=True)


def _extreme(evaluate: Callable[[int, int], int], a: Interval, b: Interval, *, greatest: bool) -> int:
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
    """Bits that an interval's number may have in a place, and whether each bound still holds it."""
    at_low, at_high = held
    low, high = ((end >> place) & 1 for end in interval)
    ends = []
    for bit in (0, 1):
        order, first, last = (1 - bit, 1 - low, 1 - high) if is_sign else (bit, low, high)
        if (not at_low or order >= first) and (not at_high or order <= last):
            ends.append((bit, at_low and bit == low, at_high and bit == high))
    return ends
