"""The cascade bit by bit against the one in floating point, which is exact too, and against its transfer function."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedMashModulator, MashModulator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import drive_fixed, value_of, words
from tests.by_hand.responses import response

WORD = Fixed(14, 13)


def test_one_bit_as_in_floating_point() -> None:
    """Levels of 1 and -1, and words of 13 bits after the point: floating point is exact as well."""
    inputs = [m // 2 for m in words(WORD, 1500)]
    block = FixedMashModulator(bits=1, input_format=WORD, state_bits=12)
    found = [row["output"] for row in drive_fixed(block, [{"input": m} for m in inputs])]
    assert found == response(MashModulator(levels=2), [m / 2.0**13 for m in inputs])


@pytest.mark.parametrize("bits", [2, 5])
def test_against_fractions(bits: int) -> None:
    """Its two stages one after the other: all v1, then what the second makes of their errors."""
    inputs = [value_of(m, WORD) for m in words(WORD, 800)]
    levels = [Fraction(2 * k - 2**bits + 1, 2 ** (bits - 1)) for k in range(2**bits)]

    def nearest(value: Fraction) -> Fraction:
        return min(reversed(levels), key=lambda level: abs(level - value))

    a = b = c = Fraction(0)
    first, errors = [], []
    for u in inputs:
        first.append(nearest(b))
        errors.append(b - first[-1])
        a, b = a + u - first[-1], b + a - 2 * first[-1]
    second = []
    for e in errors:
        second.append(nearest(c))
        c += e - second[-1]
    one, two = [Fraction(0), *first], [Fraction(0)] * 2 + second
    expected = [one[n] + two[n + 2] - 2 * two[n + 1] + two[n] for n in range(len(inputs))]
    block = FixedMashModulator(bits=bits, input_format=WORD, state_bits=16)
    rows = drive_fixed(block, [{"input": int(u * 2**13)} for u in inputs])
    assert [Fraction(row["output"], 2 ** (bits - 1)) for row in rows] == expected


def test_what_it_adds_is_differenced_three_times() -> None:
    """The sum of three integrations of output less input, delayed by 3 ticks, stays within the error of a level."""
    inputs = [m // 4 for m in words(WORD, 800, seed=9)]
    rows = drive_fixed(FixedMashModulator(bits=3, input_format=WORD, state_bits=12), [{"input": m} for m in inputs])
    first = second = third = 0.0
    for n, row in enumerate(rows):
        first += row["output"] / 4.0 - (inputs[n - 3] / 2.0**13 if n >= 3 else 0.0)
        second += first
        third += second
        assert abs(third) <= 1.0
