"""The filter against numpy's convolution."""

import numpy as np
import pytest

from proofmass.blocks import FiniteImpulseResponse
from tests.by_hand.responses import distance, noise, response


@pytest.mark.parametrize("length", [1, 2, 33, 300])
def test_against_a_convolution(length: int) -> None:
    taps, signal = noise(length, 2), noise(500)
    answer = response(FiniteImpulseResponse(taps=taps), signal)
    assert distance(answer, np.convolve(taps, signal)[:500]) < 1e-13


def test_an_impulse_gives_the_taps() -> None:
    assert response(FiniteImpulseResponse(taps=(3.0, -1.0, 0.5)), [2.0, 0.0, 0.0, 0.0]) == [6.0, -2.0, 1.0, 0.0]
