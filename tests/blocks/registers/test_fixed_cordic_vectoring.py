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
    few = min(guard, 4)
    return round((x >> (guard - few)) * reciprocal / 2 ** (20 + few)), phase


def bound(length: float, bits: int, iterations: int, guard: int) -> float:
    """Steps by which a phase may be off: rounding, the last turn, and the bits that rotations and angles drop.

    A register drops less than 1 each rotation after the first, the vector less than sqrt 2, when its length has grown
    to 1.58 at least: 0.9 / length a rotation, once in the vector and once in the angle at which the turns end.
    """
    dropped = 2.0 * 2.0**0.5 / 1.58 * (iterations - 1) / length + (iterations + 1) / 2.0 / 2.0**bits
    return 0.5 + 2.0 ** (bits - iterations + 1) + 2.0 ** (bits - guard) * dropped


SHORT = [(x, y) for x in range(-12, 13) for y in range(-12, 13) if 0 < math.hypot(x, y) <= 12.0]


@pytest.mark.defect(
    "S653",
    before="phases said to be rounded to the nearest step are off by up to 5067 steps for a vector of one step",
    after="at most one step, of the shortest vectors too",
)
@pytest.mark.parametrize(
    ("bits", "word"),
    [
        (16, WORD),
        pytest.param(10, Fixed(12, 10), marks=pytest.mark.exhaustive),
        pytest.param(24, Fixed(24, 20), marks=pytest.mark.exhaustive),
    ],
)
def test_at_most_one_step_off(bits: int, word: Fixed) -> None:
    """Every vector of up to 12 steps, many longer ones, for which the bound of any vector is below one step."""
    more = bits + 4
    assert bound(12.0, bits, more, more) < 1.0
    block = FixedCordicVectoring(input_format=word, phase_bits=bits, iterations=more, guard_bits=more)
    assert bits != 16 or block == FixedCordicVectoring()
    rng = np.random.default_rng(5)
    long = rng.integers(word.lowest, word.highest + 1, (2, 20_000)) >> rng.integers(0, word.width - 4, 20_000)
    real, imaginary = np.concatenate([np.array(SHORT).T, long], axis=1)
    length, angle = np.hypot(real, imaginary), np.arctan2(imaginary, real)
    found = (
        swept(block, "magnitude", real, imaginary),
        swept(block, "phase", real, imaginary),
    )
    assert np.max(np.abs(found[0] - length)) < 1.0
    off = np.abs(found[1] - angle * 2.0**bits)[length > 0.0]
    assert np.max(off) < 1.0
    assert (off <= np.array([bound(v, bits, more, more) for v in length[length > 0.0]])).all()


@pytest.mark.parametrize(("iterations", "guard"), [(18, 4), (9, 0), (20, 12)])
def test_within_what_is_said_for_any_parameters(iterations: int, guard: int) -> None:
    rng = np.random.default_rng(8)
    real, imaginary = rng.integers(-131072, 131072, (2, 400)) >> rng.integers(0, 14, 400)
    length = np.maximum(np.hypot(real, imaginary), 1.0)
    block = FixedCordicVectoring(iterations=iterations, guard_bits=guard)
    off = np.abs(swept(block, "phase", real, imaginary) - np.arctan2(imaginary, real) * 65536)
    assert (off <= 0.5 + 2.0 ** (17 - iterations) + 2 * iterations * 2.0 ** (16 - guard) / length).all()


def test_axes_the_corner_and_the_zero_vector() -> None:
    vectors = [(65536, 0), (0, 65536), (-65536, 0), (0, -65536), (-131072, -131072), (0, 0)]
    rows = drive_fixed(FixedCordicVectoring(), [{"real": x, "imaginary": y} for x, y in vectors])
    exact = [(math.hypot(x, y), math.atan2(y, x) * 65536) for x, y in vectors]
    for row, (length, angle) in zip(rows, exact, strict=True):
        assert row["magnitude"] == pytest.approx(length, abs=1.0)
        assert row["phase"] == pytest.approx(angle, abs=1.0)
    assert rows[-1] == {"magnitude": 0, "phase": 0}


@pytest.mark.parametrize(("iterations", "guard"), [(20, 20), (18, 4), (9, 0)])
def test_bits_against_plain_integers(iterations: int, guard: int) -> None:
    block = FixedCordicVectoring(iterations=iterations, guard_bits=guard)
    pairs = list(zip(words(WORD, 200, seed=6), words(WORD, 200, seed=7), strict=True))
    rows = drive_fixed(block, [{"real": x, "imaginary": y} for x, y in pairs])
    expected = [by_hand(x, y, iterations, guard) for x, y in pairs]
    assert [(row["magnitude"], row["phase"]) for row in rows] == expected
