"""The derivative of a ramp, and scipy.signal for noise."""

import math

import pytest
from scipy import signal

from proofmass.blocks import Differentiator
from tests.by_hand.responses import distance, noise, response


def test_against_lfilter() -> None:
    u, a = noise(400), math.exp(-2.0 * math.pi * 60.0 * 1e-3)
    expected = signal.lfilter([2.5e3 * (1.0 - a), -2.5e3 * (1.0 - a)], [1.0, -a], u)
    assert distance(response(Differentiator(gain=2.5, corner_frequency=60.0), u, period=1e-3), expected) < 1e-12


def test_a_ramp_has_its_slope() -> None:
    ramp = [1.0 + 3.0 * n * 1e-3 for n in range(2000)]
    assert response(Differentiator(corner_frequency=50.0), ramp, period=1e-3)[-1] == pytest.approx(3.0, rel=1e-9)
