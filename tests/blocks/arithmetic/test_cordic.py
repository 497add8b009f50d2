"""Shifts, growth and convergence of the rotations, against mpmath and the textbook condition."""

import math

import mpmath
import pytest

from proofmass.blocks.arithmetic.cordic import (
    circular_angles,
    circular_growth,
    circular_turns,
    grown,
    hyperbolic_angles,
    hyperbolic_growth,
    hyperbolic_shifts,
    turned,
)
from tests.by_hand import cordic as cordic_by_hand


@pytest.mark.parametrize("iterations", [1, 3, 4, 8, 13, 16, 40])
def test_shifts_and_growth(iterations: int) -> None:
    assert list(hyperbolic_shifts(iterations)) == cordic_by_hand.shifts(iterations)
    assert hyperbolic_growth(iterations) == pytest.approx(float(cordic_by_hand.growth(iterations)), rel=1e-15)
    circular = mpmath.fprod(mpmath.sqrt(1 + mpmath.mpf(4) ** -i) for i in range(iterations))
    assert circular_growth(iterations) == pytest.approx(float(circular), rel=1e-15)


def test_growth_and_reach_of_the_paper() -> None:
    """K, and the largest angle that the rotations take up: it covers ln 2."""
    assert hyperbolic_growth(16) == pytest.approx(0.828159360992, abs=1e-12)
    assert sum(hyperbolic_angles(16, 36)) / 2**36 == pytest.approx(1.118158, abs=1e-6)


def test_no_rotation_is_longer_than_those_that_follow_it_together() -> None:
    """Volder's condition: whatever an angle leaves undone, the later ones make up for, but for the last of them."""
    for angles in (hyperbolic_angles(30, 36), circular_angles(30, 36)):
        assert all(angles[i] <= sum(angles[i + 1 :]) + angles[-1] for i in range(len(angles)))


def test_angles_are_nearest_steps() -> None:
    for shift, angle in zip(hyperbolic_shifts(20), hyperbolic_angles(20, 36), strict=True):
        assert angle == cordic_by_hand.scaled(mpmath.atanh(mpmath.mpf(2) ** -shift), 36)
    for shift, angle in enumerate(circular_angles(20, 36)):
        assert angle == cordic_by_hand.scaled(mpmath.atan(mpmath.mpf(2) ** -shift), 36)
    for shift, angle in enumerate(circular_turns(30, 48)):
        assert angle == cordic_by_hand.scaled(mpmath.atan(mpmath.mpf(2) ** -shift) / (2 * mpmath.pi), 48)


@pytest.mark.parametrize("up", [False, True])
def test_one_rotation(up: bool) -> None:
    rest = 50 if up else -50
    assert grown(4097, rest, 2, 100) == ((5121, -50) if up else (3073, 50))
    x, y = turned(4096, 2048, up, 1)
    assert (x, y) == ((3072, 4096) if up else (5120, 0))
    assert math.hypot(x, y) == pytest.approx(math.hypot(4096, 2048) * math.sqrt(1.25))
