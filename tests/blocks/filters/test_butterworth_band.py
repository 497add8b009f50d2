"""Butterworth bands against scipy.signal, sample by sample."""

import pytest
from scipy import signal

from proofmass.blocks import ButterworthBand
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import distance, noise, response

INPUT = noise(500)


@pytest.mark.parametrize("stop", [False, True])
@pytest.mark.parametrize("order", range(1, 5))
@pytest.mark.parametrize("edges", [(80.0, 120.0), (20.0, 400.0), (240.0, 260.0)])
def test_against_scipy(order: int, edges: tuple[float, float], stop: bool) -> None:
    block = ButterworthBand(order=order, low_frequency=edges[0], high_frequency=edges[1], stop=stop)
    kind = "bandstop" if stop else "bandpass"
    sections = signal.butter(order, edges, kind, fs=1000.0, output="sos")
    assert distance(response(block, INPUT, period=1e-3), signal.sosfilt(sections, INPUT)) < 1e-12


def test_edges_in_the_wrong_order_are_refused() -> None:
    with pytest.raises(ModelError, match="more than low_frequency"):
        ButterworthBand(low_frequency=120.0, high_frequency=80.0)
