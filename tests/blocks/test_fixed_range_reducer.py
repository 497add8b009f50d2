"""Range reduction against plain integers and real numbers, over every exponent where there are few enough.

Exhaustive: all 2^23 exponents of M = 16, N = 6, and every exponent of twelve smaller words. For larger words an
interval suffices: |z| <= 2^(M+N) and C1 < 1.4427 2^M + 1/2 < 2^(M+1) bound |A| by 2^(2M+N+1), which are 2M + N + 2 bits
with the sign, one fewer than the product has. Its middle bits are below 2^M, so that (F C2) >> M < C2. Nothing else
depends on the size of a word.
"""

import math

import mpmath
import numpy as np
import pytest

from proofmass.blocks.fixed_range_reducer import FixedRangeReducer
from proofmass.blocks.problem import ModelError
from tests import cordic_by_hand
from tests.cordic_by_hand import swept
from tests.fixed_by_hand import drive_fixed


def test_every_exponent_of_the_paper() -> None:
    exponents = np.arange(-(2**22), 2**22)
    product, octave, remainder = cordic_by_hand.reduced(exponents, 16)
    block = FixedRangeReducer()
    assert np.array_equal(swept(block, "octave", exponents, compiled=True), octave)
    assert np.array_equal(swept(block, "remainder", exponents, compiled=True), remainder)
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
