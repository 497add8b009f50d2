"""The Chebyshev filter of type 2 against scipy.signal, sample by sample."""

import pytest
from scipy import signal

from proofmass.blocks import ChebyshevType2
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize(("corner", "attenuation"), [(20.0, 30.0), (120.0, 60.0), (450.0, 50.0)])
def test_against_scipy(order: int, corner: float, attenuation: float, high: bool) -> None:
    block = ChebyshevType2(order=order, corner_frequency=corner, attenuation=attenuation, high_pass=high)
    sections = signal.cheby2(order, attenuation, corner, "high" if high else "low", fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12
