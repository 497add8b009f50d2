"""The Chebyshev filter against scipy.signal, sample by sample."""

import pytest
from scipy import signal

from proofmass.blocks import ChebyshevType1
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize(("corner", "ripple"), [(10.0, 3.0), (120.0, 0.1), (450.0, 0.5)])
def test_against_scipy(order: int, corner: float, ripple: float, high: bool) -> None:
    block = ChebyshevType1(order=order, corner_frequency=corner, ripple=ripple, high_pass=high)
    sections = signal.cheby1(order, ripple, corner, "high" if high else "low", fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12
