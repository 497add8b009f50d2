"""Functions on integers, as far as 64 bits hold them, and on the entries of tuples and buffers."""

import math
from collections.abc import Sequence
from typing import TypeVar

from proofmass.blocks.language.arithmetic import (
    LOWEST,
    add_fails,
    floor_divide,
    floor_divide_fails,
    modulo,
    multiply_fails,
)

_Entry = TypeVar("_Entry", int, float)


def greatest_divisor(a: int, b: int) -> int:
    """Greatest common divisor."""
    return -_divisor_below_zero(a, b)


def _divisor_below_zero(a: int, b: int) -> int:
    """Negative of the greatest common divisor, by Euclid on the more numerous negative numbers."""
    a, b = min(a, -a), min(b, -b)
    while b != 0:
        a, b = b, modulo(a, b)
    return a


def greatest_divisor_fails(a: int, b: int) -> bool:
    """Return whether it is 2^63."""
    return (a == LOWEST and b in (0, LOWEST)) or (b == LOWEST and a == 0)


def least_multiple(a: int, b: int) -> int:
    """Least common multiple."""
    if a == 0 or b == 0:
        return 0
    return abs(floor_divide(a, _divisor_below_zero(a, b)) * b)


def least_multiple_fails(a: int, b: int) -> bool:
    """Return whether the least common multiple exceeds 64 bits."""
    if a == 0 or b == 0:
        return False
    divisor = _divisor_below_zero(a, b)
    if floor_divide_fails(a, divisor):
        return True
    times = floor_divide(a, divisor)
    return multiply_fails(times, b) or times * b == LOWEST


def factorial(n: int) -> int:
    """Product of the integers from 1 to n."""
    product = 1
    for k in range(2, min(n, 20) + 1):
        product *= k
    return product


def factorial_fails(n: int) -> bool:
    """Return whether the power has no value, or exceeds 64 bits."""
    return n < 0 or n > 20


def integer_root(a: int) -> int:
    """Square root, rounded down."""
    if a <= 0:
        return 0
    root = int(math.sqrt(float(a)))  # never too small: both roundings are monotone, and keep the root of a square
    while root > a // root:
        root -= 1
    return root


def integer_root_fails(a: int) -> bool:
    """Return whether there is none."""
    return a < 0


def least(entries: Sequence[_Entry]) -> _Entry:
    """The first of the least entries, compared as in Python; integers keep all digits."""
    best = entries[0]
    for entry in entries:
        best = entry if entry < best else best
    return best


def largest(entries: Sequence[_Entry]) -> _Entry:
    """The first of the largest entries."""
    best = entries[0]
    for entry in entries:
        best = entry if entry > best else best
    return best


def is_empty(entries: Sequence[float]) -> bool:
    """Return whether there is no entry."""
    return len(entries) == 0


def total(entries: Sequence[int]) -> int:
    """Sum of integers."""
    result = 0
    for entry in entries:
        result += entry
    return result


def total_fails(entries: Sequence[int]) -> bool:
    """Return whether the sum exceeds 64 bits, even for a while."""
    result, fails = 0, False
    for entry in entries:
        fails = fails or add_fails(result, entry)
        result += entry
    return fails


def product(entries: Sequence[int]) -> int:
    """Product of integers."""
    result = 1
    for entry in entries:
        result *= entry
    return result


def product_fails(entries: Sequence[int]) -> bool:
    """Return whether the product exceeds 64 bits, even for a while."""
    result, fails = 1, False
    for entry in entries:
        fails = fails or multiply_fails(result, entry)
        result *= entry
    return fails


def product_of_numbers(entries: Sequence[float]) -> float:
    """Product of numbers."""
    result = 1.0
    for entry in entries:
        result *= entry
    return result


def is_among(value: float, entries: Sequence[float]) -> bool:
    """Return whether a number equals an entry; unlike in Python, NaN is equal to nothing."""
    found = False
    for entry in entries:
        found = found or value == entry
    return found
