"""Every pair of 16-bit words, 2^32 of them, through the compiled integer code of sums, products, comparisons and casts.

The oracle is floating-point arithmetic, in which products of 16-bit words, and their quotients by powers of two, are
exact. Other casts see every single word, and a million products, in `test_fixed_point.py`.
"""

import math
from typing import Any

import pytest

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue
from proofmass.runner.targets.machine_code import ALONE
from tests.by_hand.compiled import compiled
from tests.by_hand.integer_code import compile_step

WORD = Fixed(16, 12)
SUM, PRODUCT, TRUTH = Fixed(17, 12), Fixed(32, 24), Fixed(1, 0, signed=False)
RESULTS = (SUM, SUM, PRODUCT, TRUTH, TRUTH, TRUTH, WORD, WORD)


def operations(a: FixedValue, b: FixedValue) -> tuple[Any, ...]:
    """Sum, difference, product, comparisons, casts of the product."""
    product = a * b
    return (
        a + b,
        a - b,
        product,
        a < b,
        a <= b,
        a == b,
        product.to(WORD, "half_even", "saturate"),
        product.to(WORD, "half_up", "wrap"),
    )


step = compile_step(operations, {"a": WORD, "b": WORD, "return": RESULTS}).step(0, 0)


def wrapped(value: float) -> float:
    return value - 65536.0 * float(math.floor((value + 32768.0) * (1.0 / 65536.0)))


def held(value: float) -> float:
    return -32768.0 if value < -32768.0 else (32767.0 if value > 32767.0 else value)


def nearest(value: float) -> float:
    return (value + 6755399441055744.0) - 6755399441055744.0  # ties to even, as the addition rounds


def different(first: int, last: int, apart: int) -> int:
    """Pairs whose result is not that of the oracle, of each `apart`-th first word up to, not including, `last`."""
    count = 0
    for a in range(first, last, apart):
        for b in range(-32768, 32768):
            r = step(a, b)
            x, y = float(a), float(b)
            p = x * y
            q = p * (1.0 / 4096.0)
            wrong = (r[0] != x + y) | (r[1] != x - y) | (r[2] != p)
            wrong |= ((r[3] != 0) != (x < y)) | ((r[4] != 0) != (x <= y)) | ((r[5] != 0) != (x == y))
            wrong |= r[6] != held(nearest(q))
            wrong |= r[7] != wrapped(float(math.floor(q + 0.5)))
            count += wrong
    return count


@pytest.mark.parametrize("apart", [257, pytest.param(1, marks=pytest.mark.exhaustive)])
def test_every_pair_of_16_bit_words(apart: int) -> None:
    """A prime number apart, first words with and without each of their bits meet every second word."""
    assert compiled(different, ALONE)(-32768, 32768, apart) == 0
