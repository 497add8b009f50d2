"""The filter against SciPy's window design, convolved and decimated by NumPy."""

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import DecimatingFilter
from tests.by_hand.responses import distance, noise, response


@pytest.mark.parametrize(
    ("ratio", "length", "corner", "beta"), [(1, 2, 0.2, 0.0), (4, 63, 0.1, 8.0), (5, 64, 0.08, 5.0)]
)
def test_against_firwin(ratio: int, length: int, corner: float, beta: float) -> None:
    u = noise(40 * ratio + 1)
    taps = signal.firwin(length, 2.0 * corner, window=("kaiser", beta))
    expected = np.concatenate([[0.0], np.convolve(u, taps)[: len(u) - 1]])  # from the inputs before the tick
    block = DecimatingFilter(ratio=ratio, length=length, corner=corner, beta=beta)
    assert distance(response(block, u)[::ratio], expected[::ratio]) < 1e-13


def test_stop_band() -> None:
    """80 dB by Kaiser's formula: 0.1102 (80 - 8.7) = 7.857."""
    block = DecimatingFilter(ratio=1, length=101, corner=0.125, beta=7.857)
    taps = np.array(response(block, [1.0] + [0.0] * 101))[1:]
    f = np.linspace(0.125 + 0.53 * (80.0 - 7.95) / (14.36 * 100), 0.5, 400)
    assert np.abs(np.exp(-2j * np.pi * np.outer(f, np.arange(101))) @ taps).max() < 10 ** (-79.0 / 20.0)
