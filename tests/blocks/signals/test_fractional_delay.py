"""Lagrange's interpolation: exact for cubics, its taps against scipy, its delay at low frequency."""

import math

import numpy as np
import pytest
from scipy import interpolate, signal

from proofmass.blocks import FractionalDelay
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response


@pytest.mark.parametrize("delay", [1.0, 1.25, 2.0, 2.5, 7.125, 12.9])
def test_a_cubic_is_delayed_exactly(delay: float) -> None:
    def cubic(t: float) -> float:
        return 2.0 - t + 0.3 * t**2 - 0.02 * t**3

    answer = response(FractionalDelay(delay=delay), [cubic(n) for n in range(40)])
    assert answer[16:] == pytest.approx([cubic(n - delay) for n in range(16, 40)], rel=1e-12)


@pytest.mark.parametrize("delay", [1.0, 1.75, 2.5, 5.3])
def test_noise_against_a_filter_whose_taps_scipy_interpolates(delay: float) -> None:
    back = math.floor(delay) - 1
    nodes = np.arange(4.0)
    taps = [
        float(interpolate.BarycentricInterpolator(nodes, (nodes == i).astype(float))(delay - back)) for i in range(4)
    ]
    u = noise(400)
    assert distance(response(FractionalDelay(delay=delay), u), signal.lfilter([0.0] * back + taps, [1.0], u)) < 1e-13


def test_a_whole_delay_copies() -> None:
    u = noise(50)
    assert response(FractionalDelay(delay=3.0), u) == pytest.approx([0.0] * 3 + u[:-3], abs=1e-15)


def test_longer_than_the_line_is_refused() -> None:
    with pytest.raises(ModelError, match="less than longest - 1 = 15"):
        FractionalDelay(delay=15.0)
