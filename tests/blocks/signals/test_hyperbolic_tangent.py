"""The soft limit against mpmath, and at its ends."""

import mpmath
import pytest

from proofmass.blocks import HyperbolicTangent
from tests.by_hand.responses import noise, response


def test_against_mpmath() -> None:
    x = noise(300, 1, 5.0)
    expected = [float(3 * mpmath.tanh(mpmath.mpf(u) / 3)) for u in x]
    assert response(HyperbolicTangent(limit=3.0), x) == pytest.approx(expected, rel=1e-14)


def test_ends() -> None:
    assert response(HyperbolicTangent(limit=2.0), [1e9, -1e9]) == [2.0, -2.0]
