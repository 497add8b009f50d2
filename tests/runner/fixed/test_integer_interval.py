"""Intervals of operations on integers against every pair of operands, and against widths counted by hand."""

import itertools
import operator
from collections.abc import Callable

import pytest

from proofmass.runner.fixed.integer_interval import (
    bitwise,
    comparison,
    conjunction,
    corners,
    equality,
    inequality,
    selection,
    signed_width,
)

ENDS = range(-9, 9)
INTERVALS = [(low, high) for low in ENDS for high in range(low, 9)]
PAIRS = list(itertools.product([*INTERVALS[::7], (0, 0), (0, 1), (1, 1), (7, 7), (0, 7), (-1, -1)], INTERVALS[::5]))


def exact(function: Callable[[int, int], int], a: tuple[int, int], b: tuple[int, int]) -> tuple[int, int]:
    values = [function(x, y) for x in range(a[0], a[1] + 1) for y in range(b[0], b[1] + 1)]
    return min(values), max(values)


@pytest.mark.parametrize("function", [operator.and_, operator.or_, operator.xor])
def test_operations_on_bits(function: Callable[[int, int], int]) -> None:
    for a, b in PAIRS:
        assert bitwise(function, a, b) == exact(function, a, b), (a, b)
        assert bitwise(function, b, a) == exact(function, b, a), (b, a)


def test_a_bitwise_and_with_a_mask_is_bounded_tightly_enough() -> None:
    """Exact, but where a mask cuts an interval that passes its end: all of the mask is allowed then."""
    masks = {0, 1, 3, 7}
    for a, b in [*PAIRS, *((b, a) for a, b in PAIRS)]:
        low, high = conjunction(operator.and_, a, b)
        least, most = exact(operator.and_, a, b)
        assert low <= least <= most <= high, (a, b)
        with_mask = [end[0] for end in (a, b) if end[0] == end[1] and end[0] in masks]
        if not with_mask or (low, high) != (0, max(with_mask)):
            assert (low, high) == (least, most), (a, b)


def test_a_mask_takes_an_interval_within_one_of_its_blocks_as_it_is() -> None:
    assert conjunction(operator.and_, (17, 22), (15, 15)) == (1, 6)
    assert conjunction(operator.and_, (15, 15), (17, 22)) == (1, 6)
    assert conjunction(operator.and_, (-15, -10), (15, 15)) == (1, 6)
    assert conjunction(operator.and_, (14, 17), (15, 15)) == (0, 15)


@pytest.mark.parametrize("function", [operator.add, operator.sub, operator.mul])
def test_operations_with_their_extremes_at_corners(function: Callable[[int, int], int]) -> None:
    for a, b in PAIRS[::3]:
        assert corners(function, a, b) == exact(function, a, b)
    assert corners(operator.neg, (-3, 5)) == (-5, 3)


def test_comparisons_and_choices() -> None:
    for a, b in PAIRS[::3]:
        assert comparison(operator.lt, a, b) == exact(lambda x, y: int(x < y), a, b)
        assert comparison(operator.le, a, b) == exact(lambda x, y: int(x <= y), a, b)
        assert equality(a, b) == exact(lambda x, y: int(x == y), a, b)
        assert inequality(a, b) == exact(lambda x, y: int(x != y), a, b)
    for condition in INTERVALS:
        taken = {bool(value) for value in range(condition[0], condition[1] + 1)}
        ends = [end for value, end in ((True, (2, 5)), (False, (-4, 3))) if value in taken]
        expected = min(low for low, _ in ends), max(high for _, high in ends)
        assert selection(condition, (2, 5), (-4, 3)) == expected, condition


def test_a_width_holds_every_integer_and_one_bit_less_does_not() -> None:
    for low, high in [*INTERVALS, (-(2**62), 2**62), (-1, 2**63 - 1)]:
        width = signed_width(low, high)
        assert -(2 ** (width - 1)) <= low <= high < 2 ** (width - 1)
        half = 2 ** (width - 1) // 2
        assert width == 1 or not -half <= low <= high < half
