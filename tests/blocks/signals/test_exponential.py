"""The exponential against mpmath, and where it is held."""

import mpmath
import pytest

from proofmass.blocks import Exponential
from tests.by_hand.responses import noise, response


def test_against_mpmath() -> None:
    x = noise(200, 1, 30.0)
    found = response(Exponential(scale=-2.5, reference=3.0), x)
    assert found == pytest.approx([float(-2.5 * mpmath.exp(mpmath.mpf(u) / 3)) for u in x], rel=1e-14)


def test_a_huge_input_stays_a_number() -> None:
    assert response(Exponential(), [1e9, -1e9]) == pytest.approx([float(mpmath.exp(354)), float(mpmath.exp(-354))])
