"""The detector: amplitude of a sine, its ripple, and the time in which it follows."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import AmplitudeDetector
from tests.by_hand.responses import distance, noise, response


def test_against_lfilter() -> None:
    u, k = noise(400), -math.expm1(-2.0 * math.pi * 5.0 * 1e-3)
    expected = signal.lfilter([k], [1.0, k - 1.0], 0.5 * math.pi * np.abs(u))
    assert distance(response(AmplitudeDetector(corner_frequency=5.0), u, "amplitude", period=1e-3), expected) < 1e-12


def test_the_amplitude_of_a_sine_and_its_ripple() -> None:
    carrier = [2.5 * math.sin(2.0 * math.pi * 1000.1 * n * 1e-5) for n in range(60_000)]
    answer = np.array(response(AmplitudeDetector(corner_frequency=30.0), carrier, "amplitude", period=1e-5))[-20_000:]
    assert answer.mean() == pytest.approx(2.5, rel=1e-3)
    assert 0.5 * np.ptp(answer) / 2.5 == pytest.approx(30.0 / (3.0 * 1000.1), rel=0.15)
