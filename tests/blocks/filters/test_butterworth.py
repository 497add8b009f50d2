"""The Butterworth filter against scipy.signal, sample by sample."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import Butterworth
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("high", [False, True])
@pytest.mark.parametrize("order", range(1, 9))
@pytest.mark.parametrize("corner", [3.0, 120.0, 480.0])
def test_against_scipy(order: int, corner: float, high: bool) -> None:
    block = Butterworth(order=order, corner_frequency=corner, high_pass=high)
    sections = signal.butter(order, corner, "high" if high else "low", fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12


def test_the_corner_is_down_by_three_decibels() -> None:
    block = Butterworth(order=5, corner_frequency=100.0)
    carrier = np.array([math.sin(0.2 * math.pi * n) for n in range(4000)])
    answer = np.array(response(block, carrier, period=1e-3))[-1000:]
    assert np.sqrt(2.0 * np.mean(answer**2)) == pytest.approx(math.sqrt(0.5), rel=1e-9)


def test_beyond_half_the_rate_everything_passes() -> None:
    answer = response(Butterworth(order=4, corner_frequency=700.0), INPUT, period=1e-3)
    assert distance(answer, INPUT) < 1e-4
