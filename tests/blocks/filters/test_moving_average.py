"""The average against numpy's convolution, and after very many samples."""

import numpy as np
import pytest

from proofmass.blocks import MovingAverage
from tests.by_hand.responses import distance, noise, response


@pytest.mark.parametrize("length", [1, 2, 7, 100])
def test_against_a_convolution(length: int) -> None:
    signal = noise(1000)
    expected = np.convolve(np.full(length, 1.0 / length), signal)[:1000]
    assert distance(response(MovingAverage(length=length), signal, "mean"), expected) < 1e-13


def test_rounding_does_not_add_up() -> None:
    signal = [1e9 * u for u in noise(20_000)] + [0.1] * 20
    assert response(MovingAverage(length=10), signal, "mean")[-1] == pytest.approx(0.1, rel=1e-15)


def test_what_repeats_within_its_length_vanishes() -> None:
    hum = [np.sin(2.0 * np.pi * n / 20.0) for n in range(200)]
    assert max(map(abs, response(MovingAverage(length=20), hum, "mean")[20:])) < 1e-15
