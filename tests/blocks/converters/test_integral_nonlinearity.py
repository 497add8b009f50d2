"""The bent characteristic: its errors in steps, at the ends, the middle and where they are largest."""

import numpy as np
import pytest

from proofmass.blocks import IntegralNonlinearity
from tests.by_hand.responses import response

STEP = 2.5 / 2**15


def errors(voltages: list[float], bow: float, s_shape: float) -> np.ndarray:
    answer = response(IntegralNonlinearity(bow=bow, s_shape=s_shape), voltages, input="voltage")
    return np.subtract(answer, voltages) / STEP


def test_a_bow_is_largest_in_the_middle() -> None:
    assert errors([-2.5, 0.0, 2.5, 3.0], 3.0, 0.0) == pytest.approx([0.0, 3.0, 0.0, 0.0], abs=1e-9)


def test_an_s_shape_is_largest_at_a_root_of_a_third() -> None:
    grid = np.linspace(-2.5, 2.5, 10_001)
    found = errors(grid.tolist(), 0.0, 2.0)
    assert found.max() == pytest.approx(2.0, abs=1e-6)
    assert grid[found.argmax()] == pytest.approx(2.5 / np.sqrt(3.0), abs=1e-3)
    assert found.min() == pytest.approx(-2.0, abs=1e-6)


@pytest.mark.derivation(
    IntegralNonlinearity,
    equation="output = v + lsb (bow (1 - x^2) + s_shape 3 sqrt(3) / 2 (x - x^3)), lsb = reference / 2^(bits-1)",
    source="harmonics of a sine over the span: cos(2 f) / 2 of the bow, 3 sqrt(3) / 8 of the S, by a Fourier sum",
    convention="bow and s_shape are peaks in steps of the span over 2^bits, end points at zero; not the best line",
)
def test_harmonics_of_a_full_sine() -> None:
    """bow / 2 of the second harmonic, s_shape 3 sqrt(3) / 8 of the third, in steps."""
    phases = 2.0 * np.pi * np.arange(256) / 256.0
    lines = 2.0 / 256.0 * np.abs(np.fft.rfft(errors((2.5 * np.sin(phases)).tolist(), 1.0, 4.0)))
    assert lines[2] == pytest.approx(0.5, abs=1e-8)
    assert lines[3] == pytest.approx(4.0 * 3.0 * np.sqrt(3.0) / 8.0, abs=1e-8)
