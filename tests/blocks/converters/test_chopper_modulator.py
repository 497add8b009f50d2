"""Two choppers around an amplifier with an offset: the signal comes back, the offset becomes a ripple."""

import numpy as np
import pytest

from proofmass.blocks import ChopperModulator
from tests.by_hand.responses import noise, response


def test_the_square_wave() -> None:
    assert response(ChopperModulator(half_period=3), [0.0] * 8, "square") == [1.0] * 3 + [-1.0] * 3 + [1.0] * 2
    assert response(ChopperModulator(), [2.0, 3.0, 4.0]) == [2.0, -3.0, 4.0]


@pytest.mark.parametrize("half", [1, 5])
def test_an_offset_between_two_choppers_has_no_mean(half: int) -> None:
    signal = noise(40 * half)
    amplified = [10.0 * u + 0.5 for u in response(ChopperModulator(half_period=half), signal)]
    answer = response(ChopperModulator(half_period=half), amplified)
    rest = [y - 10.0 * u for y, u in zip(answer, signal, strict=True)]
    assert rest == pytest.approx(([0.5] * half + [-0.5] * half) * 20, abs=1e-14)


@pytest.mark.derivation(
    ChopperModulator,
    equation="output = input square, square = 1 for half_period ticks, then -1 for as many",
    source="Fourier's series of a square wave, 4 / (pi k) of its odd lines; a geometric series at ticks",
    convention="half_period is half: the line is at 1 / (2 half_period T); lines are peaks, of amplitude 1",
)
@pytest.mark.parametrize("half", [1, 4, 500])
def test_lines_of_the_square_wave(half: int) -> None:
    """A constant of 3: 2 / (N sin(pi k / N)) of N = 2 half_period ticks, twice that but for the last line."""
    chopped = np.array(response(ChopperModulator(half_period=half), [3.0] * (2 * half)))
    lines = np.abs(np.fft.rfft(chopped)) / half
    odd = np.arange(1, half + 1, 2)
    expected = 3.0 * 2.0 / (half * np.sin(np.pi * odd / (2.0 * half)))
    assert lines[odd] == pytest.approx(expected, rel=1e-9)
    assert np.abs(lines[::2]).max() < 1e-12
    if half == 500:
        assert lines[[1, 3]] == pytest.approx(3.0 * 4.0 / (np.pi * np.array([1.0, 3.0])), rel=2e-5)
