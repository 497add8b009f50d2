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


@pytest.mark.exhaustive
def test_the_amplitude_of_a_sine_and_its_ripple() -> None:
    carrier = [2.5 * math.sin(2.0 * math.pi * 1000.1 * n * 1e-5) for n in range(60_000)]
    answer = np.array(response(AmplitudeDetector(corner_frequency=30.0), carrier, "amplitude", period=1e-5))[-20_000:]
    assert answer.mean() == pytest.approx(2.5, rel=1e-3)
    assert 0.5 * np.ptp(answer) / 2.5 == pytest.approx(30.0 / (3.0 * 1000.1), rel=0.15)


@pytest.mark.derivation(
    AmplitudeDetector,
    equation="a[n] = a[n-1] + k (pi / 2 |u| - a[n-1]), k = 1 - exp(-2 pi corner T)",
    source="Fourier's series of a rectified sine, 2 / pi - 4 / (3 pi) cos(2 f) ..., each line through an analog pole",
    convention="the amplitude is the peak, neither rms nor mean; the ripple too; it rises as 1 - exp(-2 pi corner t)",
)
def test_lines_of_a_rectified_sine_through_a_pole() -> None:
    """64 ticks a period: the lines that fold back are below 1e-3 of the mean."""
    ticks, corner, amplitude = 64, 0.02, 3.0
    carrier = [amplitude * math.sin(2.0 * math.pi * (n + 0.5) / ticks) for n in range(60 * ticks)]
    found = np.array(response(AmplitudeDetector(corner_frequency=corner), carrier, "amplitude", period=1.0 / ticks))
    t = np.arange(60 * ticks) / ticks
    whole = found.reshape(-1, ticks).mean(axis=1)
    rise = amplitude * (1.0 - np.exp(-2.0 * np.pi * corner * (np.arange(60) + 0.5)))
    assert whole == pytest.approx(rise, abs=0.01 * amplitude)
    settled = found - amplitude * (1.0 - np.exp(-2.0 * np.pi * corner * (t + 0.5 / ticks)))
    line = abs(np.fft.rfft(settled[-ticks:])[2]) * 2.0 / ticks
    expected = amplitude * math.pi / 2.0 * 4.0 / (3.0 * math.pi) / math.hypot(1.0, 2.0 / corner)
    assert line == pytest.approx(expected, rel=0.01)
    assert expected == pytest.approx(amplitude * corner / 3.0, rel=1e-3)
