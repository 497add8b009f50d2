"""The fringe: the two waves added as complex numbers."""

import cmath

import numpy as np
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


@pytest.mark.derivation(
    Interferometer,
    equation="power = peak (1 + visibility cos(phase)) / 2",
    source="mean over time of the square of two real fields of unlike power, 2 sqrt(P1 P2) / (P1 + P2) of contrast",
    convention="peak is twice the power of both waves, not what a fringe with less contrast reaches",
    wrong="the documents did not say that the mean is half the peak whatever the visibility",
)
def test_the_mean_square_of_two_fields() -> None:
    """Fields of 1 and 0.5: 1.25 in all, from 0.25 to 2.25."""
    time = 2.0 * np.pi * np.arange(32) / 32.0
    phases = [0.0, 0.6, 2.0, np.pi]
    fields = [np.cos(time) + 0.5 * np.cos(time + phase) for phase in phases]
    expected = [2.0 * np.mean(field**2) for field in fields]
    block = Interferometer(peak=2.5, visibility=2.0 * 0.5 / 1.25)
    assert response(block, phases, "power", "phase") == pytest.approx(expected, rel=1e-12)
    assert expected[::3] == pytest.approx([2.25, 0.25])
