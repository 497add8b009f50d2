"""Magnitude and phase against hypot and atan2, in all quadrants; bits against plain integers."""

import math

import numpy as np
import pytest

from proofmass.blocks import FixedCordicVectoring
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.cordic import swept
from tests.by_hand.fixed_point import drive_fixed, words

WORD = Fixed(18, 16)


def by_hand(real: int, imaginary: int, iterations: int, guard: int) -> tuple[int, int]:
    """Magnitude and phase in plain integers."""
    inner = 16 + guard
    x, y, z = real << guard, imaginary << guard, 0
    if real < 0:
        z = round(math.pi * 2**inner) * (-1 if imaginary < 0 else 1)
        x, y = -x, -y
    for i in range(iterations):
        d = 1 if y < 0 else -1
        x, y, z = x - d * (y >> i), y + d * (x >> i), z - d * round(math.atan(2.0**-i) * 2**inner)
    reciprocal = round(2**20 / math.prod(math.sqrt(1 + 4.0**-i) for i in range(iterations)))
    phase = round(z / 2**guard) if real or imaginary else 0
    return round(x * reciprocal / 2 ** (20 + guard)), phase


def test_within_about_a_step_of_hypot_and_atan2() -> None:
    rng = np.random.default_rng(5)
    real, imaginary = rng.integers(-131072, 131072, (2, 50_000))
    block = FixedCordicVectoring()
    length, angle = np.hypot(real, imaginary), np.arctan2(imaginary, real)
    found = swept(block, "magnitude", real, imaginary), swept(block, "phase", real, imaginary)
    assert np.max(np.abs(found[0] - length)) < 1.1
    # Bits that the rotations drop are up to a step of a coordinate, which the phase of a short vector feels more.
    assert np.all(np.abs(found[1] - angle * 65536) < 1.1 + 65536 / np.maximum(length, 1.0))


def test_axes_the_corner_and_the_zero_vector() -> None:
    vectors = [(65536, 0), (0, 65536), (-65536, 0), (0, -65536), (-131072, -131072), (0, 0)]
    rows = drive_fixed(FixedCordicVectoring(), [{"real": x, "imaginary": y} for x, y in vectors])
    exact = [(math.hypot(x, y), math.atan2(y, x) * 65536) for x, y in vectors]
    for row, (length, angle) in zip(rows, exact, strict=True):
        assert row["magnitude"] == pytest.approx(length, abs=1.1)
        assert row["phase"] == pytest.approx(angle, abs=1.1)
    assert rows[-1] == {"magnitude": 0, "phase": 0}


@pytest.mark.parametrize(("iterations", "guard"), [(18, 4), (9, 0)])
def test_bits_against_plain_integers(iterations: int, guard: int) -> None:
    block = FixedCordicVectoring(iterations=iterations, guard_bits=guard)
    pairs = list(zip(words(WORD, 200, seed=6), words(WORD, 200, seed=7), strict=True))
    rows = drive_fixed(block, [{"real": x, "imaginary": y} for x, y in pairs])
    expected = [by_hand(x, y, iterations, guard) for x, y in pairs]
    assert [(row["magnitude"], row["phase"]) for row in rows] == expected
