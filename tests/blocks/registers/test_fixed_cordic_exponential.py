"""The exponential against plain integers, bit by bit, and its error against the exponential of floating point."""

from typing import Any

import numpy as np
import pytest

from proofmass.blocks import FixedCordicExponential
from tests.by_hand import cordic as cordic_by_hand
from tests.by_hand.cordic import swept
from tests.by_hand.fixed_point import drive_fixed

LN2 = 45426  # of 16 bits: the remainders of a range reduction are below


def error(bits: int, iterations: int, guard: int = 0, every: int = 1) -> float:
    """Largest relative error in percent over [0, ln 2).

    Plain integers find the angles where it is; the block has these bits there, and at some hundreds of other angles.
    """
    block = FixedCordicExponential(fraction_bits=bits, iterations=iterations, guard_bits=guard)
    largest = 0.0
    for first in range(0, int(2**bits * np.log(2.0)) + 1, every << 20):
        angles = np.arange(first, min(first + (every << 20), int(2**bits * np.log(2.0)) + 1), every)
        found = cordic_by_hand.exponential(angles, bits, iterations, guard)
        errors = np.abs(found / (np.exp(angles / 2**bits) * 2**bits) - 1.0)
        looked_at = np.unique(np.append(np.argsort(errors)[-20:], np.arange(0, len(angles), 1 + len(angles) // 300)))
        assert np.array_equal(swept(block, "exponential", angles[looked_at]), found[looked_at])
        largest = max(largest, float(errors.max()))
    return 100.0 * largest


def test_every_angle_of_16_bits_bit_by_bit() -> None:
    """All 65536 codes of the port, of which the 45426 below ln 2 are what a range reduction leaves."""
    angles = np.arange(65536)
    found = swept(FixedCordicExponential(), "exponential", angles)
    assert np.array_equal(found, cordic_by_hand.exponential(angles, 16, 16))
    worst = np.max(np.abs(found[:LN2] / (np.exp(angles[:LN2] / 65536) * 65536) - 1.0))
    assert 100.0 * worst == pytest.approx(0.01373, abs=6e-6)
    assert 100.0 * worst < 0.0138


def test_the_reference_on_single_angles_as_plain_integers() -> None:
    angles = [0, 1, 2, LN2 - 1, LN2, 65535, *range(0, 65536, 997)]
    rows = drive_fixed(FixedCordicExponential(), [{"angle": angle} for angle in angles])
    assert [row["exponential"] for row in rows] == [cordic_by_hand.exponential(a, 16, 16) for a in angles]


@pytest.mark.parametrize(
    ("bits", "iterations", "guard"), [(4, 3, 1), (12, 12, 0), (16, 20, 4), (24, 24, 0), (28, 40, 8)]
)
def test_other_words_bit_by_bit(bits: int, iterations: int, guard: int) -> None:
    block = FixedCordicExponential(fraction_bits=bits, iterations=iterations, guard_bits=guard)
    angles = np.arange(0, 2**bits, max(1, 2**bits // 4001))
    found = swept(block, "exponential", angles)
    assert np.array_equal(found, cordic_by_hand.exponential(angles, bits, iterations, guard))


@pytest.mark.parametrize(
    ("bits", "percent"), [(12, 0.13805), (14, 0.039205), (16, 0.013735), (18, 0.0029202), (20, 0.00084846)]
)
def test_error_over_every_angle_of_a_word_length(bits: int, percent: float) -> None:
    """As many iterations as bits, no guard bits."""
    assert error(bits, bits) == pytest.approx(percent, rel=1e-3)


@pytest.mark.parametrize(("every", "percent"), [(16, 6.3e-5), pytest.param(1, 7.17e-5, marks=pytest.mark.exhaustive)])
def test_error_of_24_bits(every: int, percent: float) -> None:
    """Over one angle in sixteen, and over all 11.6 million."""
    assert error(24, 24, every=every) == pytest.approx(percent, rel=2e-3)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("bits", "every", "percent"), [(28, 97, 4.93e-6), (32, 1501, 3.17e-7)])
def test_error_of_longer_words_over_many_angles(bits: int, every: int, percent: float) -> None:
    assert error(bits, bits, every=every) == pytest.approx(percent, rel=0.01)


def test_error_of_the_block_with_28_and_32_bits() -> None:
    """What the plain integers say above holds for the block: it is the same bits."""
    for bits in (28, 32):
        angles = np.arange(0, int(2**bits * np.log(2.0)), 2**bits // 997)
        found = swept(FixedCordicExponential(fraction_bits=bits, iterations=bits), "exponential", angles)
        assert np.array_equal(found, cordic_by_hand.exponential(angles, bits, bits))


@pytest.mark.parametrize(("iterations", "percent"), [(8, 0.40226), (10, 0.11121), (12, 0.03982), (14, 0.01724)])
def test_error_of_fewer_iterations(iterations: int, percent: float) -> None:
    assert error(16, iterations) == pytest.approx(percent, rel=1e-3)


@pytest.mark.exhaustive("20-percents2")
@pytest.mark.parametrize(
    ("bits", "percents"),
    [
        (12, (0.4704, 0.1380, 0.1380, 0.1380)),
        (16, (0.4023, 0.03982, 0.01373, 0.01373)),
        (20, (0.3987, 0.03182, 0.002194, 0.0008485)),
    ],
)
def test_error_over_word_length_and_iterations(bits: int, percents: tuple[float, ...]) -> None:
    """8, 12, 16 and 20 iterations: more than bits change nothing, as the shifts drop all."""
    assert [error(bits, n) for n in (8, 12, 16, 20)] == pytest.approx(percents, rel=1e-3)


def test_error_with_guard_bits() -> None:
    assert error(16, 16, guard=4) == pytest.approx(0.002808, rel=1e-3)
    assert error(16, 20, guard=4) == pytest.approx(0.0016585, rel=1e-3)


def falls(iterations: int, guard: int) -> Any:
    """The steps downwards from one of the 45426 angles to the next."""
    block = FixedCordicExponential(iterations=iterations, guard_bits=guard)
    steps = np.diff(swept(block, "exponential", np.arange(LN2)))
    return steps[steps < 0].tolist()


def test_monotonic_with_two_guard_bits_and_the_iterations_for_them() -> None:
    assert falls(18, 2) == falls(20, 4) == []


def test_not_monotonic_without() -> None:
    """One step of -5; with guard bits and too few iterations, or one guard bit, there are falls too."""
    assert falls(16, 0) == [-5]
    assert falls(16, 4) != []
    assert falls(17, 1) != []
