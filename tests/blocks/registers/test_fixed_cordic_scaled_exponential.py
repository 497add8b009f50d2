"""A preloaded factor against plain integers, of both signs, and against the product in floating point."""

import math

import numpy as np
import pytest

from proofmass.blocks import FixedCordicScaledExponential
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand import cordic as cordic_by_hand
from tests.by_hand.cordic import swept
from tests.by_hand.fixed_point import drive_fixed, words

FACTOR = Fixed(24, 24)


@pytest.mark.exhaustive("20-4")
@pytest.mark.parametrize(("iterations", "guard"), [(16, 0), (20, 4)])
def test_against_plain_integers(iterations: int, guard: int) -> None:
    block = FixedCordicScaledExponential(iterations=iterations, guard_bits=guard, preloaded_format=FACTOR)
    angles, factors = words(Fixed(16, 16, signed=False), 300), words(FACTOR, 300, seed=4)
    rows = drive_fixed(block, [{"angle": a, "preloaded": f} for a, f in zip(angles, factors, strict=True)])
    expected = [
        cordic_by_hand.rotated(f << guard, a << guard, 16 + guard, iterations) >> guard
        for a, f in zip(angles, factors, strict=True)
    ]
    assert [row["output"] for row in rows] == expected


@pytest.mark.parametrize("factor", [0.3, -0.3])
def test_factor_times_exponential(factor: float) -> None:
    block = FixedCordicScaledExponential(iterations=20, guard_bits=4, preloaded_format=FACTOR)
    angles = np.arange(0, 45426, 11)
    preloaded = round(factor / 0.8281593609920 * 2**24)
    found = swept(block, "output", angles, np.full(len(angles), preloaded)) / 2**24
    assert np.max(np.abs(found / factor - np.exp(angles / 65536))) < 3.2e-5
    assert found[0] == pytest.approx(factor, abs=2e-6)
    assert found[-1] == pytest.approx(factor * math.exp(angles[-1] / 65536), rel=2e-5)
