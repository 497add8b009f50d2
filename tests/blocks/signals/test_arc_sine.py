"""The arcsine against mpmath, and a quarter turn beyond its reference."""

import math

import mpmath
import pytest

from proofmass.blocks import ArcSine
from tests.by_hand.responses import noise, response


def test_against_mpmath() -> None:
    x = [u for u in noise(300, 1, 1.2) if abs(u) < 2.0]
    expected = [float(mpmath.asin(mpmath.mpf(u) / 2)) for u in x]
    assert response(ArcSine(reference=2.0), x) == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_beyond_the_reference() -> None:
    assert response(ArcSine(), [7.0, -1.5]) == pytest.approx([0.5 * math.pi, -0.5 * math.pi])
