"""The controller in registers against fractions, and against its sibling in floating point."""

from fractions import Fraction

import pytest

from proofmass.blocks import FixedStiffnessController, StiffnessController
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

VOLTS, SUM, CORRECTION, OUT = Fixed(16, 12), Fixed(20, 12), Fixed(16, 12), Fixed(20, 12)
WINDOW = [n % 13 in range(1, 6) for n in range(200)]


@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
def test_against_fractions(rounding: str, overflow: str) -> None:
    block = FixedStiffnessController(gain=0.3593, rounding=rounding, overflow=overflow)  # 1471.7 steps
    gain, initial = Fraction(round(0.3593 * 4096), 4096), Fraction(round(49.5627 * 4096), 4096)
    measured, modelled = (words(VOLTS, 200, seed=seed) for seed in (1, 2))
    samples = [{"measured": a, "modelled": b, "window": w} for a, b, w in zip(measured, modelled, WINDOW, strict=True)]
    correction, error, expected = 0, 0, []
    for row in samples:
        if row["window"]:
            change = value_of(row["modelled"] - row["measured"], VOLTS)
            error = cast(value_of(error, SUM) + change, SUM, rounding, overflow)
        else:
            wanted = value_of(correction, CORRECTION) + gain * value_of(error, SUM)
            correction, error = cast(wanted, CORRECTION, rounding, overflow), 0
        expected.append(cast(initial + value_of(correction, CORRECTION), OUT, rounding, overflow))
    assert [row["stiffness"] for row in drive_fixed(block, samples)] == expected
    assert len(set(expected)) > 10


def test_against_its_sibling_in_floating_point() -> None:
    measured, modelled = ([m // 16 for m in words(VOLTS, 200, seed=seed)] for seed in (3, 4))
    samples = [{"measured": a, "modelled": b, "window": w} for a, b, w in zip(measured, modelled, WINDOW, strict=True)]
    volts = [{**row, "measured": row["measured"] / 4096, "modelled": row["modelled"] / 4096} for row in samples]
    found = [row["stiffness"] / 4096 for row in drive_fixed(FixedStiffnessController(), samples)]
    expected = [row["stiffness"] for row in drive(StiffnessController(), volts)]
    assert found == pytest.approx(expected, abs=0.01)  # a gain of 0.3592 is 0.35913 in its register
    assert max(expected) - min(expected) > 0.3
