"""Angles less their quarter turns against many digits, also what the second number of the pair holds."""

import random

import mpmath
import pytest

from proofmass.blocks.arithmetic.angles import LARGE, less_quarters


@pytest.mark.parametrize(
    ("low", "high", "near"),
    [(-3.0, 0.7, 1e-31), (0.7, 6.0, 1e-31), (6.0, 307.0, 1e-31)],  # powers of ten
    ids=["first", "small", "large"],
)
def test_pairs_hold_what_is_left_to_thirty_digits(low: float, high: float, near: float) -> None:
    """Below 1.5e6 by a sum of four parts, beyond by a product with all digits of 2 / pi."""
    dice = random.Random(8)
    angles = [dice.choice((-1.0, 1.0)) * 10.0 ** dice.uniform(low, high) for _ in range(200)]
    angles += [LARGE, -LARGE, 1.5e6 - 0.25, 1.5e6 + 0.25]
    with mpmath.workdps(400):
        for angle in angles:
            quarters, left, rest = less_quarters(angle)
            whole = mpmath.nint(mpmath.mpf(angle) * 2 / mpmath.pi)
            assert quarters in (-2.0, -1.0, 0.0, 1.0, 2.0)
            assert (int(quarters) - int(whole)) % 4 == 0
            assert abs(mpmath.mpf(left) + mpmath.mpf(rest) - (angle - whole * mpmath.pi / 2)) <= near, angle
