"""The gain against the logistic curve, from far too small and far too large inputs, and its limits."""

import math

import numpy as np
import pytest

from proofmass.blocks import AutomaticGainControl
from tests.by_hand.responses import response

PERIOD = 1e-5


def sine(amplitude: float, samples: int) -> list[float]:
    return [amplitude * math.sin(2.0 * math.pi * 5000.37 * PERIOD * n) for n in range(samples)]


@pytest.mark.exhaustive
@pytest.mark.derivation(
    AutomaticGainControl,
    equation="g[n+1] = g (1 + T / tau (1 - pi |y| / (2 setpoint)))",
    source="solution of g' = g / tau (1 - g A / setpoint), the logistic curve, from 0.02 to 40 of input",
    convention="the setpoint is the peak of the output sine, neither rms nor mean; tau is that of small deviations",
)
@pytest.mark.parametrize("amplitude", [0.02, 1.0, 40.0])
def test_it_settles_on_the_logistic_curve(amplitude: float) -> None:
    block = AutomaticGainControl(setpoint=2.0, time_constant=0.05)
    gain = np.array(response(block, sine(amplitude, 50_000), "gain", period=PERIOD))
    t = np.arange(50_000) * PERIOD
    expected = 2.0 / amplitude / (1.0 + (2.0 / amplitude - 1.0) * np.exp(-t / 0.05))
    assert np.abs(gain / expected - 1.0).max() < 0.02 * max(1.0, amplitude / 20.0)


@pytest.mark.exhaustive
def test_the_settled_output_has_the_set_amplitude() -> None:
    block = AutomaticGainControl(setpoint=2.0, time_constant=0.02)
    output = np.array(response(block, sine(0.3, 40_000), period=PERIOD))
    assert math.sqrt(2.0 * np.mean(output[-20_000:] ** 2)) == pytest.approx(2.0, rel=1e-3)


def test_silence_drives_it_to_its_highest_gain() -> None:
    assert response(AutomaticGainControl(highest=50.0), [0.0] * 1000, "gain", period=0.01)[-1] == 50.0


def test_the_set_amplitude_is_the_peak() -> None:
    block = AutomaticGainControl(setpoint=2.0, time_constant=0.05, initial=2.0 / 0.7)
    output = np.array(response(block, sine(0.7, 6000), period=PERIOD))[-3000:]
    assert (output.max(), output.min()) == (pytest.approx(2.0, rel=5e-3), pytest.approx(-2.0, rel=5e-3))
