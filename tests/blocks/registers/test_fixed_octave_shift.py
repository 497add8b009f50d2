"""The shift against powers of two in fractions, for every octave, and what becomes of exp(64) and exp(-64)."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks import FixedOctaveShift
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import cast, drive_fixed, value_of, words


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize(
    ("first", "output"),
    [(Fixed(18, 16, signed=False), Fixed(32, 16)), (Fixed(26, 24), Fixed(30, 24)), (Fixed(12, 4), Fixed(20, 10))],
)
def test_against_powers_of_two(first: Fixed, output: Fixed, overflow: str) -> None:
    block = FixedOctaveShift(input_format=first, output_format=output, overflow=overflow)
    octaves = [k for k in range(-128, 128) for _ in range(3)]
    inputs = words(first, len(octaves))
    rows = drive_fixed(block, [{"input": m, "octave": k} for m, k in zip(inputs, octaves, strict=True)])
    expected = [
        cast(value_of(m, first) * Fraction(2) ** k, output, "floor", overflow)
        for m, k in zip(inputs, octaves, strict=True)
    ]
    assert [row["output"] for row in rows] == expected


def test_both_ends_of_the_range() -> None:
    """exp(64) has 93 bits before the point and saturates; of exp(-64), below 2^-92, nothing is left."""
    ends = [{"input": 65536 + 15112, "octave": 92}, {"input": 65536 + 30313, "octave": -93}]
    assert [row["output"] for row in drive_fixed(FixedOctaveShift(), ends)] == [2**31 - 1, 0]
    assert math.log2(math.exp(64.0)) == pytest.approx(92.3, abs=0.1)


def test_formats_that_do_not_go_together() -> None:
    with pytest.raises(ModelError, match="at most 63 bits together with the input"):
        FixedOctaveShift(output_format=Fixed(50, 16))
    with pytest.raises(ModelError, match="no fraction bits"):
        FixedOctaveShift(octave_format=Fixed(8, 1))
