"""The compensator against scipy's bilinear transform, and the phase that it adds."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import LeadLag
from tests.by_hand.responses import distance, noise, response

INPUT = noise(400)


@pytest.mark.parametrize(("zero", "pole", "gain"), [(10.0, 100.0, 1.0), (200.0, 3.0, -2.5), (50.0, 50.0, 1.0)])
def test_against_scipy(zero: float, pole: float, gain: float) -> None:
    analog = [gain / (2.0 * math.pi * zero), gain], [1.0 / (2.0 * math.pi * pole), 1.0]
    expected = signal.lfilter(*signal.bilinear(*analog, fs=1000.0), INPUT)
    block = LeadLag(zero_frequency=zero, pole_frequency=pole, gain=gain)
    assert distance(response(block, INPUT, period=1e-3), expected) < 1e-12


def test_it_leads_by_the_angle_of_the_textbook() -> None:
    """asin((r - 1) / (r + 1)) at the geometric mean of two corners of ratio r, slowly sampled."""
    impulse = np.array(response(LeadLag(zero_frequency=1.0, pole_frequency=9.0), [1.0] + [0.0] * 20_000, period=1e-3))
    at_mean = impulse @ np.exp(-2j * np.pi * 3.0 * 1e-3 * np.arange(len(impulse)))
    assert math.degrees(math.asin(0.8)) == pytest.approx(float(np.angle(at_mean, deg=True)), abs=1e-2)
