"""The filter against exact fractions, and against its floating-point sibling."""

from fractions import Fraction

import pytest

from proofmass.blocks import FiniteImpulseResponse, FixedFiniteImpulseResponse
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.responses import response

WORD, OUT = Fixed(16, 12), Fixed(14, 10)
TAPS = (0.3, -0.71, 0.9, 0.25)


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("taps", [TAPS, TAPS[:1]])
def test_against_fractions(taps: tuple[float, ...], rounding: str, overflow: str) -> None:
    block = FixedFiniteImpulseResponse(taps=taps, output_format=OUT, rounding=rounding, overflow=overflow)
    exact = [Fraction(round(tap * 2**15), 2**15) for tap in taps]
    inputs = words(WORD, 300)
    expected = []
    for n in range(len(inputs)):
        terms = [exact[k] * value_of(inputs[n - k], WORD) for k in range(len(taps)) if n >= k]
        expected.append(cast(sum(terms, Fraction(0)), OUT, rounding, overflow))
    assert [row["output"] for row in drive_fixed(block, [{"input": m} for m in inputs])] == expected


def test_against_the_filter_in_floating_point() -> None:
    inputs = words(WORD, 300, seed=3)
    taps = (0.125, 0.25, 0.5, -0.375)
    found = [row["output"] / 2**20 for row in drive_fixed(
        FixedFiniteImpulseResponse(taps=taps, output_format=Fixed(28, 20)), [{"input": m} for m in inputs]
    )]  # fmt: skip
    assert found == pytest.approx(response(FiniteImpulseResponse(taps=taps), [m / 4096 for m in inputs]), abs=1e-12)
