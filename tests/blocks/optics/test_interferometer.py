"""The fringe: the two waves added as complex numbers."""

import cmath

import pytest

from proofmass.blocks import Interferometer
from tests.by_hand.responses import noise, response


@pytest.mark.parametrize("visibility", [1.0, 0.3])
def test_against_two_waves(visibility: float) -> None:
    """|1 + e^(j phase)|^2 / 4 of the peak, and the rest without fringes."""
    phases = noise(200, 1, 3.0)
    found = response(Interferometer(peak=2e-5, visibility=visibility), phases, "power", "phase")
    expected = [
        2e-5 * (visibility * abs(1.0 + cmath.exp(1j * f)) ** 2 / 4.0 + (1.0 - visibility) / 2.0) for f in phases
    ]
    assert found == pytest.approx(expected, rel=1e-13, abs=1e-20)
