"""The rotation against a complex factor, and back."""

import cmath

import pytest

from proofmass.blocks import VectorRotation
from tests.by_hand.responses import noise, responses


def test_it_is_a_complex_factor_and_its_inverse() -> None:
    first, second, angle = noise(50), noise(50)[::-1], [7.0 * u for u in noise(50)]
    block = VectorRotation()
    x = responses(block, "along_x", first=first, second=second, angle=angle)
    y = responses(block, "along_y", first=first, second=second, angle=angle)
    for a, b, t, u, v in zip(first, second, angle, x, y, strict=True):
        assert complex(u, v) == pytest.approx(complex(a, b) * cmath.exp(1j * t), abs=1e-15)
    back = [-t for t in angle]
    assert responses(block, "along_x", first=x, second=y, angle=back) == pytest.approx(first, abs=1e-14)
    assert responses(block, "along_y", first=x, second=y, angle=back) == pytest.approx(second, abs=1e-14)
