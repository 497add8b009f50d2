"""Range reduction against plain integers and real numbers, over every exponent where there are few enough.

Exhaustive: every exponent of [-2^N, 2^N) where these are fewer than 1e9, for the words named below. For all others up
to M = 24, N = 6, this proof, whose inequalities test_no_word_overflows computes in exact integers. The integer code is
that of big integers as long as no value leaves 64 bits and no cast its register. A = z C1 grows with z, so that its
largest magnitudes are at both ends of the range; the octave, A >> 2M, grows with A. F = A[2M-1:M] < 2^M whatever A is;
F C2 and the remainder grow with F. So it is enough that A, octave, F C2 and remainder fit at their ends.

What octave and remainder leave of the exponent, with A = octave 2^2M + F 2^M + R: it is z 2^-M (1 - C1 2^-M ln 2), what
rounding C1 costs, plus R 2^-2M ln 2, plus F 2^-M (ln 2 - C2 2^-M), plus what the last shift drops: together below
2^N / 2 ln 2 + ln 2 + 1/2 + 1 steps of 2^-M.
"""

import itertools
import math
from typing import Any

import mpmath
import numpy as np
import pytest

from proofmass.blocks import FixedRangeReducer
from proofmass.blocks.declaration.instance import format_of
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.fixed.digital import digital_block
from proofmass.runner.targets.machine_code import ALONE
from tests.by_hand import cordic as cordic_by_hand
from tests.by_hand.compiled import compiled
from tests.by_hand.cordic import swept
from tests.by_hand.fixed_point import drive_fixed
from tests.by_hand.integer_code import Code


@pytest.mark.exhaustive
def test_every_exponent_of_the_paper() -> None:
    exponents = np.arange(-(2**22), 2**22)
    product, octave, remainder = cordic_by_hand.reduced(exponents, 16)
    block = FixedRangeReducer()
    assert np.array_equal(swept(block, "octave", exponents), octave)
    assert np.array_equal(swept(block, "remainder", exponents), remainder)
    assert int(np.abs(product).max()).bit_length() < 2 * 16 + 6 + 3
    assert (octave.min(), octave.max()) == (-93, 92)
    assert remainder.max() == 45425
    apart = exponents / 65536 - octave * math.log(2.0) - remainder / 65536
    assert np.abs(apart).max() < 64 * 2.0**-17 * math.log(2.0) + 2.5 / 65536  # C1 is rounded; so is the rest


@pytest.mark.parametrize("range_bits", [0, 1, 3, 6])
@pytest.mark.parametrize("bits", [4, 7, 10])
def test_every_exponent_of_smaller_words(bits: int, range_bits: int) -> None:
    block = FixedRangeReducer(fraction_bits=bits, range_bits=range_bits)
    exponents = np.arange(-(2 ** (bits + range_bits)), 2 ** (bits + range_bits))
    _, octave, remainder = cordic_by_hand.reduced(exponents, bits)
    assert np.array_equal(swept(block, "octave", exponents), octave)
    assert np.array_equal(swept(block, "remainder", exponents), remainder)


def differences_of(octave: Any, remainder: Any) -> Any:
    """What counts differences of two functions."""

    def differences(constants: Any, c1: int, c2: int, bits: int, first: int, high: int, low: int) -> int:
        """Count of exponents whose octave or remainder is not that of A = high 2^2M + low; A grows by C1 with each.

        No product but F C2 < 2^(2M): in 64 bits this is arithmetic of big integers.
        """
        wrong = 0
        for z in range(first, -first):
            expected = ((low >> bits) * c2) >> bits
            if octave(constants, None, z) != high or remainder(constants, None, z) != expected:
                wrong += 1
            low += c1
            if low >= 1 << 2 * bits:
                low -= 1 << 2 * bits
                high += 1
        return wrong

    return differences


WHOLE = pytest.mark.exhaustive


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("bits", "range_bits"), [(20, 6), pytest.param(22, 6, marks=WHOLE), pytest.param(24, 4, marks=WHOLE)]
)
def test_every_exponent_of_larger_words(bits: int, range_bits: int) -> None:
    """2^27, 2^29 and 2^29 of them, against a sum that is carried on from one to the next."""
    made = digital_block("block", FixedRangeReducer(fraction_bits=bits, range_bits=range_bits), 1.0)
    steps = (Code(made.steps[name].code).step(made.constants, None, 0) for name in ("octave", "remainder"))
    count = compiled(differences_of(*steps), ALONE)
    first = -(2 ** (bits + range_bits))
    c1, c2 = (cordic_by_hand.scaled(value, bits) for value in (1 / mpmath.log(2), mpmath.log(2)))
    high, low = divmod(first * c1, 2 ** (2 * bits))
    assert count(made.constants, c1, c2, bits, first, high, low) == 0
    assert count(made.constants, c1, c2 + 1, bits, first, high, low) > 0


def test_no_word_overflows() -> None:
    """The inequalities of the proof, in exact integers."""
    for bits, range_bits in itertools.product(range(4, 25), range(7)):
        c1, c2 = (cordic_by_hand.scaled(value, bits) for value in (1 / mpmath.log(2), mpmath.log(2)))
        for product in (z * c1 for z in (-(2 ** (bits + range_bits)), 2 ** (bits + range_bits) - 1)):
            assert -(2 ** (2 * bits + range_bits + 2)) <= product < 2 ** (2 * bits + range_bits + 2) <= 2**63
            assert -(2 ** (range_bits + 1)) <= product >> 2 * bits < 2 ** (range_bits + 1)
        largest = (2**bits - 1) * c2
        assert largest < 2 ** (2 * bits) < 2**63
        assert largest >> bits < 2**bits


@pytest.mark.parametrize(("bits", "range_bits"), [(16, 6), (20, 6), (24, 6), (24, 0)])
def test_what_is_left_of_an_exponent_is_below_the_bound_of_the_proof(bits: int, range_bits: int) -> None:
    end, ln2 = 2 ** (bits + range_bits), mpmath.log(2)
    bound = 2**range_bits / 2 * ln2 + ln2 + 1.5
    drawn = np.random.default_rng(2).integers(-end, end, 500).tolist()
    for z in (-end, end - 1, *drawn):
        _, octave, remainder = cordic_by_hand.reduced(z, bits)
        assert abs(z - octave * ln2 * 2**bits - remainder) < bound


@pytest.mark.parametrize(("bits", "range_bits"), [(20, 6), (24, 6), (28, 5)])
def test_larger_words(bits: int, range_bits: int) -> None:
    end = 2 ** (bits + range_bits)
    multiples = [
        cordic_by_hand.scaled(k * mpmath.log(2), bits) + near for k in range(-40, 41, 8) for near in (-1, 0, 1)
    ]
    drawn = np.random.default_rng(1).integers(-end, end, 300).tolist()
    exponents = [m for m in (-end, -end + 1, -1, 0, 1, end - 1, *multiples, *drawn) if -end <= m < end]
    rows = drive_fixed(
        FixedRangeReducer(fraction_bits=bits, range_bits=range_bits), [{"exponent": m} for m in exponents]
    )
    expected = [cordic_by_hand.reduced(m, bits) for m in exponents]
    assert [(row["octave"], row["remainder"]) for row in rows] == [(o, r) for _, o, r in expected]
    assert all(abs(product) < 2 ** (2 * bits + range_bits + 2) for product, _, _ in expected)


def test_negative_exponents_multiples_of_ln2_and_both_ends() -> None:
    block = FixedRangeReducer()
    named = {"-1": -65536, "ln 2, rounded down": 45426, "above ln 2": 45427, "-64": -(2**22), "64": 2**22 - 1, "0": 0}
    word = format_of(block, "exponent")
    assert (word.lowest, word.highest) == (named["-64"], named["64"])
    found = drive_fixed(block, [{"exponent": m} for m in named.values()])
    assert {name: (row["octave"], row["remainder"]) for name, row in zip(named, found, strict=True)} == {
        "-1": (-2, 25316),
        "ln 2, rounded down": (0, 45425),
        "above ln 2": (1, 0),
        "-64": (-93, 30343),  # 30322.6 if C1 had more bits
        "64": (92, 15081),  # 15102.2
        "0": (0, 0),
    }


def test_a_product_that_no_register_holds_is_refused() -> None:
    with pytest.raises(ModelError, match="2 M \\+ N \\+ 3 at most 64"):
        FixedRangeReducer(fraction_bits=28, range_bits=6)
