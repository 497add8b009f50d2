"""The angle in turns against atan2, in all quadrants and on the axes; bits against plain integers."""

import math

import mpmath
import numpy as np
import pytest

from proofmass.blocks import FixedCordicAngle
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.cordic import scaled, swept
from tests.by_hand.fixed_point import drive_fixed, words

WORD = Fixed(12, 0)
AXES = [(2047, 0), (0, 2047), (-2048, 0), (0, -2048), (-2048, -2048), (-1, -1), (0, 0)]


def by_hand(real: int, imaginary: int, bits: int, iterations: int, guard: int) -> int:
    """The angle in plain integers: rotations towards the real axis, from the half plane in which the vector lies."""
    if real == imaginary == 0:
        return 0
    inner = bits + guard
    x, y, turns = real << guard, imaginary << guard, 0
    if real < 0:
        turns = (1 << inner) // (2 if imaginary >= 0 else -2)
        x, y = -x, -y
    for i in range(iterations):
        step = scaled(mpmath.atan(mpmath.mpf(2) ** -i) / (2 * mpmath.pi), inner)
        down = y >= 0
        x, y = (x + (y >> i), y - (x >> i)) if down else (x - (y >> i), y + (x >> i))
        turns += step if down else -step
    half = 1 << (bits - 1)
    return (round(turns / 2**guard) + half) % (1 << bits) - half


def off(found: np.ndarray, real: np.ndarray, imaginary: np.ndarray, bits: int) -> np.ndarray:
    """Steps between an angle and the true one, the shorter way round."""
    apart = found / 2.0**bits - np.arctan2(imaginary, real) / (2.0 * math.pi)
    return np.abs(apart - np.round(apart)) * 2.0**bits


@pytest.mark.parametrize(("bits", "iterations", "guard"), [(16, 18, 12), (20, 18, 12), (12, 8, 0)])
def test_within_what_is_said(bits: int, iterations: int, guard: int) -> None:
    rng = np.random.default_rng(5)
    real, imaginary = rng.integers(-2048, 2048, (2, 2_000)) >> rng.integers(0, 8, 2_000)
    real = np.where((real == 0) & (imaginary == 0), 1, real)
    block = FixedCordicAngle(turn_bits=bits, iterations=iterations, guard_bits=guard)
    drops = 2.0 * iterations * 2.0 ** (bits - guard) / np.hypot(real, imaginary)
    bound = 0.5 + (2.0 ** (bits - iterations + 1) + drops) / (2.0 * math.pi)
    assert (off(swept(block, "angle", real, imaginary), real, imaginary, bits) <= bound).all()


def test_axes_and_the_zero_vector() -> None:
    rows = drive_fixed(FixedCordicAngle(), [{"real": x, "imaginary": y} for x, y in AXES])
    quarter = 1 << 14
    assert [row["angle"] for row in rows[:2]] == pytest.approx([0, quarter], abs=1)
    assert abs(rows[2]["angle"]) == pytest.approx(2 * quarter, abs=1)
    assert [row["angle"] for row in rows[3:5]] == pytest.approx([-quarter, -1.5 * quarter], abs=1)
    assert rows[6]["angle"] == 0


@pytest.mark.parametrize(("bits", "iterations", "guard"), [(16, 18, 12), (20, 18, 12), (12, 8, 0)])
def test_bits_against_plain_integers(bits: int, iterations: int, guard: int) -> None:
    block = FixedCordicAngle(turn_bits=bits, iterations=iterations, guard_bits=guard)
    pairs = [*AXES, *zip(words(WORD, 200, seed=6), words(WORD, 200, seed=7), strict=True)]
    rows = drive_fixed(block, [{"real": x, "imaginary": y} for x, y in pairs])
    assert [row["angle"] for row in rows] == [by_hand(x, y, bits, iterations, guard) for x, y in pairs]
