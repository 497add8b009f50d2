"""The tangent against mpmath."""

import mpmath
import pytest

from proofmass.blocks import TangentFunction
from tests.by_hand.responses import noise, response


def test_against_mpmath() -> None:
    angles = noise(300, 1, 4.0)
    expected = [float(-0.5 * mpmath.tan(mpmath.mpf(u))) for u in angles]
    assert response(TangentFunction(scale=-0.5), angles) == pytest.approx(expected, rel=1e-14)
