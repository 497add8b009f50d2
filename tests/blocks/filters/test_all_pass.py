"""The all-pass: amplitude 1, its phase, and scipy's bilinear transform of the analog one."""

import cmath
import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import AllPass
from tests.by_hand.responses import distance, noise, response

PERIOD = 1e-3


def transfer(block: AllPass, frequencies: list[float]) -> list[complex]:
    impulse = np.array(response(block, [1.0] + [0.0] * 5000, period=PERIOD))
    n = np.arange(len(impulse))
    return [complex(impulse @ np.exp(-2j * np.pi * f * PERIOD * n)) for f in frequencies]


@pytest.mark.parametrize(("order", "frequency"), [(1, 20.0), (1, 300.0), (2, 20.0), (2, 300.0)])
def test_amplitude_and_phase(order: int, frequency: float) -> None:
    block = AllPass(order=order, frequency=frequency)
    *others, there = transfer(block, [1.0, 50.0, 200.0, 490.0, frequency])
    assert [abs(h) for h in others] == pytest.approx([1.0] * 4, rel=1e-12)
    assert abs(cmath.phase(there / cmath.exp(-0.5j * math.pi * order))) < 1e-9


@pytest.mark.parametrize("quality", [0.5, 3.0])
def test_order_two_is_the_bilinear_transform_of_the_analog_one(quality: float) -> None:
    w = 2.0 / PERIOD * math.tan(math.pi * 80.0 * PERIOD)
    analog = [1.0, -w / quality, w * w], [1.0, w / quality, w * w]
    expected = signal.lfilter(*signal.bilinear(*analog, fs=1.0 / PERIOD), noise(400))
    block = AllPass(order=2, frequency=80.0, quality=quality)
    assert distance(response(block, noise(400), period=PERIOD), expected) < 1e-12
