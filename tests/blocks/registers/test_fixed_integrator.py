"""The integrator against big integers, against its floating-point sibling, and at its limits."""

from fractions import Fraction

import pytest

from proofmass.blocks import DiscreteIntegrator, FixedIntegrator
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

WORD, SUM, OUT = Fixed(16, 12), Fixed(24, 18), Fixed(14, 10)
PERIOD = 1.0 / 512


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_big_integers(rounding: str, overflow: str) -> None:
    block = FixedIntegrator(
        gain=300.3, initial=3.3, sum_format=SUM, output_format=OUT, rounding=rounding, overflow=overflow
    )
    step = Fraction(round(300.3 * PERIOD * 2**30), 2**30)
    total = round(3.3 * 2**18)
    inputs = words(WORD, 600)
    expected = []
    for m in inputs:
        expected.append(cast(value_of(total, SUM), OUT, rounding, overflow))
        total = cast(value_of(total, SUM) + step * value_of(m, WORD), SUM, rounding, overflow)
    rows = drive_fixed(block, [{"input": m} for m in inputs], PERIOD)
    assert [row["output"] for row in rows] == expected
    assert {OUT.lowest, OUT.highest} <= set(expected) or overflow == "wrap"


@pytest.mark.exhaustive
def test_against_the_integrator_in_floating_point() -> None:
    inputs = words(WORD, 2000, seed=3)
    block = FixedIntegrator(gain=5.0, initial=-0.5, output_format=Fixed(32, 26))
    sibling = DiscreteIntegrator(gain=5.0, initial=-0.5)
    found = [row["output"] / 2**26 for row in drive_fixed(block, [{"input": m} for m in inputs], PERIOD)]
    expected = [row["output"] for row in drive(sibling, [{"input": m / 4096} for m in inputs], PERIOD)]
    assert found == pytest.approx(expected, abs=2000 * 2.0**-29 + 2000 * 8 * 2.0**-31)
