"""Registers that wrap against NumPy's convolution of integers: the same sums, and the same ticks."""

from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import CascadedIntegratorComb, FixedCascadedIntegratorComb
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, words
from tests.by_hand.responses import response

WORD, OUT = Fixed(6, 2), Fixed(12, 7)


@pytest.mark.exhaustive(but=5)
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize(("order", "bits"), [(1, 3), (3, 2), (5, 1)])
def test_against_convolution(order: int, bits: int, rounding: str) -> None:
    ratio = 1 << bits
    block = FixedCascadedIntegratorComb(order=order, bits=bits, input_format=WORD, output_format=OUT, rounding=rounding)
    inputs = words(WORD, 60 * ratio + 1)
    taps = np.ones(1, dtype=object)
    for _ in range(order):
        taps = np.convolve(taps, np.ones(ratio, dtype=object))
    sums = np.convolve(np.array(inputs, dtype=object), taps)
    found = [row["output"] for row in drive_fixed(block, [{"input": m} for m in inputs])][::ratio]
    expected = [0] + [
        cast(Fraction(int(sums[n - 1]), ratio**order * 4), OUT, rounding, "saturate")
        for n in range(ratio, len(inputs), ratio)
    ]
    assert found == expected


def test_against_the_filter_in_floating_point() -> None:
    inputs = words(Fixed(4), 401)
    block = FixedCascadedIntegratorComb(output_format=Fixed(24, 18))
    found = [row["output"] / 2**18 for row in drive_fixed(block, [{"input": m} for m in inputs])][::16]
    assert found == pytest.approx(response(CascadedIntegratorComb(), list(map(float, inputs)))[::16], abs=1e-12)
