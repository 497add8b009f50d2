"""The angle of a pair against complex numbers."""

import cmath
import math

import pytest

from proofmass.blocks import ArcTangent2
from tests.by_hand.responses import noise, responses


def test_against_complex_numbers() -> None:
    y, x = noise(500, 1), noise(500, 2)
    expected = [cmath.phase(complex(b, a)) for a, b in zip(y, x, strict=True)]
    assert responses(ArcTangent2(), "angle", quadrature=y, in_phase=x) == pytest.approx(expected, rel=1e-15)


def test_all_four_quadrants_and_the_axes() -> None:
    y, x = [0.0, 1.0, 0.0, -1.0, 1.0], [1.0, 0.0, -1.0, 0.0, -1.0]
    expected = [0.0, math.pi / 2, math.pi, -math.pi / 2, 3 * math.pi / 4]
    assert responses(ArcTangent2(), "angle", quadrature=y, in_phase=x) == expected
