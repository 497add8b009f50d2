"""The demodulator against the Fourier transform of the samples."""

import math

import numpy as np
import pytest

from proofmass.blocks import DigitalDemodulator
from tests.by_hand.functions import drive


def amplitudes(block: DigitalDemodulator, numbers: list[float]) -> list[float]:
    rows = drive(block, [{"number": n} for n in [*numbers, 0.0]])
    return [row["amplitude"] for row in rows[:: block.samples]]


@pytest.mark.parametrize("samples", [3, 4, 8, 15])
def test_against_the_fourier_transform(samples: int) -> None:
    numbers = np.random.default_rng(3).normal(size=7 * samples)
    expected = -2.0 / samples * np.fft.fft(numbers.reshape(7, samples), axis=1)[:, 1].imag
    found = amplitudes(DigitalDemodulator(samples=samples), numbers.tolist())
    assert found == pytest.approx([0.0, *expected], abs=1e-13)


@pytest.mark.parametrize("error", [-0.7, 0.0, 0.3, 2.0])
def test_a_phase_error_takes_its_cosine(error: float) -> None:
    carrier = [4.0 * math.sin(2.0 * math.pi * k / 8 + error) for k in range(8)]
    assert amplitudes(DigitalDemodulator(), carrier)[1] == pytest.approx(4.0 * math.cos(error), rel=1e-14)
    assert amplitudes(DigitalDemodulator(phase=error), carrier)[1] == pytest.approx(4.0, rel=1e-14)


@pytest.mark.exhaustive
def test_white_noise_comes_through_with_the_root_of_two_over_the_samples() -> None:
    numbers = np.random.default_rng(4).normal(size=8 * 20_000)
    found = amplitudes(DigitalDemodulator(), numbers.tolist())[1:]
    assert np.std(found) == pytest.approx(math.sqrt(2.0 / 8.0), rel=0.02)


def test_offset_and_even_harmonics_are_rejected() -> None:
    numbers = [3.0 + math.cos(4.0 * math.pi * k / 8) for k in range(8)]
    assert amplitudes(DigitalDemodulator(), numbers)[1] == pytest.approx(0.0, abs=1e-15)
