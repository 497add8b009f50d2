"""The filter against exact fractions, and against its floating-point sibling."""

from contextlib import nullcontext
from fractions import Fraction

import pytest

from proofmass.blocks import FiniteImpulseResponse, FixedFiniteImpulseResponse
from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.responses import response

WORD, OUT = Fixed(16, 12), Fixed(14, 10)
TAPS = (0.3, -0.71, 0.9, 0.25)


@pytest.mark.exhaustive(but=6)
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


@pytest.mark.parametrize(("taps", "refused"), [(64, False), (65, True)])
def test_64_taps_are_taken(taps: int, refused: bool) -> None:
    with pytest.raises(ModelError, match="at most 64 numbers") if refused else nullcontext():
        FixedFiniteImpulseResponse(taps=(0.5,) * taps)
