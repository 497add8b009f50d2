"""The section against exact fractions, against SciPy where words are wide, and at its limits."""

from fractions import Fraction

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import FixedSecondOrderSection
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words

WORD, STATE, OUT = Fixed(16, 12), Fixed(20, 15), Fixed(14, 10)
B, A = (0.3, 0.5, 0.2), (-1.2, 0.7)


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_fractions(rounding: str, overflow: str) -> None:
    coefficients = dict(zip(("b0", "b1", "b2", "a1", "a2"), B + A, strict=True))
    block = FixedSecondOrderSection(
        **coefficients, state_format=STATE, output_format=OUT, rounding=rounding, overflow=overflow
    )
    b0, b1, b2, a1, a2 = (Fraction(round(value * 2**16), 2**16) for value in B + A)
    inputs = words(WORD, 400)
    u1 = u2 = y1 = y2 = Fraction(0)
    expected = []
    for m in inputs:
        u = value_of(m, WORD)
        y = value_of(cast(b0 * u + b1 * u1 + b2 * u2 - a1 * y1 - a2 * y2, STATE, rounding, overflow), STATE)
        expected.append(cast(y, OUT, rounding, overflow))
        u1, u2, y1, y2 = u, u1, y, y1
    assert [row["output"] for row in drive_fixed(block, [{"input": m} for m in inputs])] == expected


def test_against_scipy() -> None:
    b, a = signal.butter(2, 0.2)
    block = FixedSecondOrderSection(
        b0=b[0], b1=b[1], b2=b[2], a1=a[1], a2=a[2], input_format=Fixed(16, 14),
        coefficient_format=Fixed(28, 26), state_format=Fixed(32, 28), output_format=Fixed(32, 28),
    )  # fmt: skip
    inputs = words(Fixed(15, 14), 500, seed=3)
    found = np.array([row["output"] for row in drive_fixed(block, [{"input": m} for m in inputs])]) / 2.0**28
    assert found == pytest.approx(signal.lfilter(b, a, np.array(inputs) / 2.0**14), abs=2e-7)
