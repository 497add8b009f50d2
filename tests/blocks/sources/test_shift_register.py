"""Maximal-length sequences: the period of every length, autocorrelation, balance and runs."""

from itertools import groupby

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.sources.shift_register import PRIMITIVE_TAPS, ShiftRegister, State, bit, constants, update

PRIME_FACTORS = {  # of 2^length - 1
    2: (3,), 3: (7,), 4: (3, 5), 5: (31,), 6: (3, 7), 7: (127,), 8: (3, 5, 17), 9: (7, 73), 10: (3, 11, 31),
    11: (23, 89), 12: (3, 5, 7, 13), 13: (8191,), 14: (3, 43, 127), 15: (7, 31, 151), 16: (3, 5, 17, 257),
    17: (131071,), 18: (3, 7, 19, 73), 19: (524287,), 20: (3, 5, 11, 31, 41), 21: (7, 127, 337), 22: (3, 23, 89, 683),
    23: (47, 178481), 24: (3, 5, 7, 13, 17, 241),
}  # fmt: skip


def register(length: int, seed: int = 1) -> ShiftRegister:
    return ShiftRegister(length=length, taps=PRIMITIVE_TAPS[length], seed=seed)


def bits(block: ShiftRegister, count: int) -> list[int]:
    c, x, found = constants(block, 1.0), State(block.seed), []
    for _ in range(count):
        found.append(int(bit(c, x)))
        x = update(c, x)
    return found


def power_of_x(exponent: int, polynomial: int, length: int) -> int:
    """x^exponent modulo a polynomial over the field of two elements; bit i is the coefficient of x^i."""
    result = 1
    for digit in bin(exponent)[2:]:
        square = sum(1 << (2 * i) for i in range(length) if result >> i & 1)
        square <<= int(digit)
        for i in range(2 * length, length - 1, -1):
            if square >> i & 1:
                square ^= polynomial << (i - length)
        result = square
    return result


@pytest.mark.parametrize("length", PRIMITIVE_TAPS)
def test_polynomial_is_primitive(length: int) -> None:
    """x has the order 2^length - 1: x^N = 1, and x^(N/q) is not 1 for any prime q that divides N."""
    taps = [i + 1 for i in range(length) if PRIMITIVE_TAPS[length] >> i & 1]
    polynomial = (1 << length) | sum(1 << (length - tap) for tap in taps)
    period = 2**length - 1
    rest = period
    for prime in PRIME_FACTORS[length]:
        assert all(prime % d for d in range(2, int(prime**0.5) + 1))
        assert period % prime == 0
        while rest % prime == 0:
            rest //= prime
        assert power_of_x(period // prime, polynomial, length) != 1
    assert rest == 1
    assert power_of_x(period, polynomial, length) == 1


@pytest.mark.parametrize("length", PRIMITIVE_TAPS)
def test_recurrence_of_the_block(length: int) -> None:
    taps = [i + 1 for i in range(length) if PRIMITIVE_TAPS[length] >> i & 1]
    sequence = bits(register(length), 300)
    assert all(sequence[n] == sum(sequence[n - tap] for tap in taps) % 2 for n in range(length, 300))


@pytest.mark.parametrize("length", range(2, 17))
def test_period_by_brute_force(length: int) -> None:
    block = register(length)
    c = constants(block, 1.0)
    start = State(block.seed)
    x, period = update(c, start), 1
    while x != start:
        x, period = update(c, x), period + 1
    assert period == 2**length - 1


@pytest.mark.parametrize("length", range(2, 13))
def test_autocorrelation_is_n_and_minus_one(length: int) -> None:
    count = 2**length - 1
    chips = 2 * np.array(bits(register(length), count)) - 1
    correlation = np.correlate(np.concatenate([chips, chips[:-1]]), chips, "valid")
    assert correlation.tolist() == [count] + [-1] * (count - 1)


@pytest.mark.parametrize("length", [3, 6, 10, 12])
def test_balance_and_runs(length: int) -> None:
    """Of 2^(length-1) runs half have length one, a quarter two, and so on; the longest are of ones (Golomb)."""
    count = 2**length - 1
    sequence = bits(register(length), count)
    while sequence[0] == sequence[-1]:
        sequence = sequence[1:] + sequence[:1]
    assert sum(sequence) == 2 ** (length - 1)
    runs = [(value, len(list(same))) for value, same in groupby(sequence)]
    assert len(runs) == 2 ** (length - 1)
    expected = {(v, k): 2 ** (length - 2 - k) for v in (0, 1) for k in range(1, length - 1)}
    expected |= {(0, length - 1): 1, (1, length): 1}
    assert {run: runs.count(run) for run in set(runs)} == expected


def test_first_bits_of_the_default() -> None:
    first = bits(ShiftRegister(), 1023)
    assert "".join(map(str, first[:24])) == "111111111100000001110000"
    assert sum(first) == 512


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"length": 9}, "  got:      576\n  expected: taps within 9 cells; 272 is primitive"),
        ({"length": 11}, "  got:      576\n  expected: the last of 11 cells among the taps; 1280 is primitive"),
        ({"seed": 1024}, "seed: does not go with the other parameters\n  got:      1024\n  expected: 1 to 1023"),
        ({"seed": 0}, "ShiftRegister.seed: must be >= 1\n  got:      0\n  expected: an integer >= 1"),
        ({"taps": 0}, "ShiftRegister.taps: must be >= 1"),
        ({"length": 25}, "ShiftRegister.length: must be >= 2 and <= 24"),
    ],
)
def test_bad_taps_and_seeds_are_refused(wrong: dict[str, int], text: str) -> None:
    with pytest.raises(ModelError) as error:
        ShiftRegister(**wrong)
    assert text in str(error.value)
