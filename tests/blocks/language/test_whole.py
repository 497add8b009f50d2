"""Functions on integers against the library of Python, at and beyond the edges of 64 bits.

Compiled code is made of them. Here they run as they are written, where Python's own integers know no edge.
"""

import itertools
import math
import random
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from proofmass.blocks.language import arithmetic, whole

LOWEST, HIGHEST = -(2**63), 2**63 - 1
EDGES = (LOWEST, LOWEST + 1, -(2**62), -12, -8, -3, -1, 0, 1, 2, 6, 12, 35, 2**31, 3037000499, 2**62, HIGHEST)
PAIRS = list(itertools.product(EDGES, repeat=2))


def fits(value: int) -> bool:
    return LOWEST <= value <= HIGHEST


@pytest.mark.parametrize(
    ("ours", "fails", "oracle"),
    [
        (whole.greatest_divisor, whole.greatest_divisor_fails, math.gcd),
        (whole.least_multiple, whole.least_multiple_fails, math.lcm),
    ],
)
def test_divisors_and_multiples(
    ours: Callable[[int, int], int], fails: Callable[[int, int], bool], oracle: Callable[[int, int], int]
) -> None:
    for a, b in PAIRS:
        expected = oracle(a, b)
        assert fails(a, b) == (not fits(expected)), (a, b)
        if fits(expected):
            assert ours(a, b) == expected, (a, b)


@pytest.mark.parametrize(
    ("fails", "oracle"),
    [
        (arithmetic.add_fails, lambda a, b: a + b),
        (arithmetic.subtract_fails, lambda a, b: a - b),
        (arithmetic.multiply_fails, lambda a, b: a * b),
    ],
)
def test_sums_differences_and_products_that_do_not_fit(
    fails: Callable[[int, int], bool], oracle: Callable[[int, int], int]
) -> None:
    assert [fails(a, b) for a, b in PAIRS] == [not fits(oracle(a, b)) for a, b in PAIRS]


def test_factorials() -> None:
    assert [whole.factorial(n) for n in range(21)] == [math.factorial(n) for n in range(21)]
    assert [n for n in range(-2, 30) if not whole.factorial_fails(n)] == [
        n for n in range(30) if fits(math.factorial(n))
    ]


def test_roots() -> None:
    squares = [n * n + near for n in (1, 2, 94906265, 94906266, 94906267, 3037000499) for near in (-1, 0, 1, 2 * n)]
    squares += [n * n + near for n in random.Random(1).choices(range(2**26, 3037000500), k=2000) for near in (-1, 0, 1)]
    for a in (0, 1, 2, 3, *squares, 2**62, 2**53 - 1, 2**53, HIGHEST):
        assert whole.integer_root(a) == math.isqrt(a), a
        assert not whole.integer_root_fails(a)
    assert whole.integer_root_fails(-1)
    assert whole.integer_root(-1) == 0


@pytest.mark.parametrize("entries", [[3], [2, -1, 5, -1], [0.0, -0.0], [-0.0, 0.0], [math.nan, 1.0], [1.0, math.nan]])
def test_least_and_largest(entries: list[Any]) -> None:
    assert repr(whole.least(entries)) == repr(min(entries))
    assert repr(whole.largest(entries)) == repr(max(entries))


@given(st.lists(st.integers(), min_size=1))
def test_least_and_largest_of_integers(entries: list[int]) -> None:
    assert (whole.least(entries), whole.largest(entries)) == (min(entries), max(entries))


@pytest.mark.parametrize(
    "entries", [[], [5], [1, -2, 7], [HIGHEST, 1, -1], [2**62, -2, 1], [2**62, 2, 0], [-(2**62), 2]]
)
def test_sums_and_products(entries: list[int]) -> None:
    assert whole.is_empty(entries) == (not entries)
    assert whole.total(entries) == sum(entries)
    assert whole.product(entries) == math.prod(entries)
    assert whole.product_of_numbers([float(entry) for entry in entries]) == math.prod(map(float, entries))
    sums = list(itertools.accumulate(entries))
    products = [math.prod(entries[: n + 1]) for n in range(len(entries))]
    assert whole.total_fails(entries) == (not all(map(fits, sums)))
    assert whole.product_fails(entries) == (not all(map(fits, products)))


def test_membership() -> None:
    assert whole.is_among(2.0, [1.0, 2.0, 3.0])
    assert not whole.is_among(4.0, [1.0, 2.0, 3.0])
    assert not whole.is_among(math.nan, [math.nan])
