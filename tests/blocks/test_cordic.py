"""Shifts, growth and convergence of the rotations, against mpmath and the textbook condition."""

import math

import mpmath
import pytest

from proofmass.blocks.cordic import (
    circular_angles,
    circular_growth,
    grown,
    hyperbolic_angles,
    hyperbolic_growth,
    hyperbolic_shifts,
    turned,
)
from proofmass.blocks.fixed_point import Fixed, FixedValue
from tests import cordic_by_hand

WORD = Fixed(40, 36)


@pytest.mark.parametrize("iterations", [1, 3, 4, 8, 13, 16, 40])
def test_shifts_and_growth(iterations: int) -> None:
    assert list(hyperbolic_shifts(iterations)) == cordic_by_hand.shifts(iterations)
    assert hyperbolic_growth(iterations) == pytest.approx(float(cordic_by_hand.growth(iterations)), rel=1e-15)
    circular = mpmath.fprod(mpmath.sqrt(1 + mpmath.mpf(4) ** -i) for i in range(iterations))
    assert circular_growth(iterations) == pytest.approx(float(circular), rel=1e-15)


def test_growth_and_reach_of_the_paper() -> None:
    """K, and the largest angle that the rotations take up: it covers ln 2."""
    assert hyperbolic_growth(16) == pytest.approx(0.828159360992, abs=1e-12)
    assert sum(float(a) for a in hyperbolic_angles(16, WORD)) == pytest.approx(1.118158, abs=1e-6)


def test_no_rotation_is_longer_than_those_that_follow_it_together() -> None:
    """Volder's condition: whatever an angle leaves undone, the later ones make up for, but for the last of them."""
    for angles in (hyperbolic_angles(30, WORD), circular_angles(30, WORD)):
        values = [float(angle) for angle in angles]
        assert all(values[i] <= sum(values[i + 1 :]) + values[-1] for i in range(len(values)))


def test_angles_are_nearest_steps() -> None:
    for shift, angle in zip(hyperbolic_shifts(20), hyperbolic_angles(20, WORD), strict=True):
        assert angle.mantissa == cordic_by_hand.scaled(mpmath.atanh(mpmath.mpf(2) ** -shift), 36)
    for shift, angle in enumerate(circular_angles(20, WORD)):
        assert angle.mantissa == cordic_by_hand.scaled(mpmath.atan(mpmath.mpf(2) ** -shift), 36)


@pytest.mark.parametrize("up", [False, True])
def test_one_rotation(up: bool) -> None:
    word, angle = Fixed(16, 12), FixedValue(100, 12)
    rest = FixedValue(50 if up else -50, 12)
    value, left_over = grown(FixedValue(4097, 12), rest, 2, angle, word)
    assert (value.value * 4096, left_over.value * 4096) == ((5121, -50) if up else (3073, 50))
    x, y = turned(FixedValue(4096, 12), FixedValue(2048, 12), up, 1, word)
    assert (x.value * 4096, y.value * 4096) == ((3072, 4096) if up else (5120, 0))
    assert math.hypot(float(x), float(y)) == pytest.approx(math.hypot(1.0, 0.5) * math.sqrt(1.25))
