"""The controller in registers against fractions, and against its sibling in floating point."""

from fractions import Fraction

import pytest

from proofmass.blocks import DampingController, FixedDampingController
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

VOLTS, CORRECTION, OUT = Fixed(16, 12), Fixed(16, 22), Fixed(17, 22)


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_fractions(rounding: str, overflow: str) -> None:
    block = FixedDampingController(rounding=rounding, overflow=overflow)
    gain, initial, lowest = (Fraction(round(value * 2**22), 2**22) for value in (1.453e-3, 3.4e-3, 3.4e-6))
    samples = [
        {"measured": a, "modelled": b} for a, b in zip(*(words(VOLTS, 300, seed=seed) for seed in (1, 2)), strict=True)
    ]
    correction, expected = 0, []
    for row in samples:
        change = gain * value_of(row["modelled"] - row["measured"], VOLTS)
        correction = cast(value_of(correction, CORRECTION) + change, CORRECTION, rounding, overflow)
        total = max(initial + value_of(correction, CORRECTION), lowest)
        expected.append(cast(total, OUT, rounding, overflow))
    assert [row["damping"] for row in drive_fixed(block, samples)] == expected
    assert min(expected) == round(lowest * 2**22)


def test_against_its_sibling_in_floating_point() -> None:
    samples = [
        {"measured": a // 64, "modelled": b // 64} for a, b in zip(words(VOLTS, 60), words(VOLTS, 60, 2), strict=True)
    ]
    volts = [{name: [0.0, m / 4096] for name, m in row.items()} for row in samples]
    found = [row["damping"] / 2**22 for row in drive_fixed(FixedDampingController(), samples)]
    expected = [row["damping"] for row in drive(DampingController(cells=2), volts)]
    assert found == pytest.approx(expected, rel=2e-3)
    assert max(expected) - min(expected) > 1e-4
