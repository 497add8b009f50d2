"""The notch and its band against scipy.signal.iirnotch and iirpeak."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import Notch
from tests.by_hand.responses import distance, noise, response

INPUT = noise(600)


@pytest.mark.parametrize(("frequency", "quality"), [(50.0, 30.0), (2.0, 5.0), (400.0, 1.0)])
def test_against_scipy(frequency: float, quality: float) -> None:
    block = Notch(frequency=frequency, quality=quality)
    notch = signal.iirnotch(frequency, quality, fs=1000.0)
    assert distance(response(block, INPUT, period=1e-3), signal.lfilter(*notch, INPUT)) < 1e-12
    peak = signal.iirpeak(frequency, quality, fs=1000.0)
    rest = np.subtract(response(block, INPUT, "band", period=1e-3), signal.lfilter(*peak, INPUT))
    assert np.abs(rest).max() < 1e-12 * np.abs(INPUT).max()


def test_the_frequency_itself_vanishes() -> None:
    carrier = [math.cos(2.0 * math.pi * 0.05 * n) for n in range(5000)]
    answer = response(Notch(), carrier, period=1e-3)
    assert max(map(abs, answer[-1000:])) < 1e-9
    assert distance(response(Notch(), carrier, "band", period=1e-3)[-1000:], carrier[-1000:]) < 1e-9
