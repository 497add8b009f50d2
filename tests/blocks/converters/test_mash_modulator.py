"""The cascade: the error of its first stage falls out to the last bit, and its noise is of third order."""

import numpy as np
import pytest

from proofmass.blocks import MashModulator
from tests.by_hand.responses import response

N = 4096
U = (0.4 * np.sin(2.0 * np.pi * 11.0 * np.arange(N) / N)).tolist()


def second_error(levels: int) -> np.ndarray:
    """Error of the second quantiser, c - v2, by the difference equations with NumPy's rounding."""
    step = 2.0 / (levels - 1)

    def level(value: float) -> float:
        return float(np.clip(np.floor((value + 1.0) / step + 0.5), 0, levels - 1) * step - 1.0)

    a = b = c = 0.0
    errors = []
    for u in U:
        v1, v2 = level(b), level(c)
        errors.append(v2 - c)
        a, b, c = a + u - v1, b + a - 2.0 * v1, c + (b - v1) - v2
    return np.array(errors)


@pytest.mark.parametrize("levels", [5, 17])
def test_the_output_is_the_input_late_and_an_error_of_third_order(levels: int) -> None:
    """v1 = z^-2 u + (1 - z^-1)^2 e1, v2 = -z^-1 e1 + (1 - z^-1) e2: z^-1 v1 + (1 - z^-1)^2 v2 leaves e2 alone."""
    values = np.array(response(MashModulator(levels=levels), U))
    late = np.concatenate([np.zeros(3), U])[:N]
    shaped = np.convolve(second_error(levels), [1.0, -3.0, 3.0, -1.0])[:N]
    assert values == pytest.approx(late + shaped, abs=1e-12)


def test_noise_of_third_order() -> None:
    """From 1/64 to 1/32 of the rate the noise is about 18 dB lower than in the octave above."""
    window = np.hanning(N)
    power = np.abs(np.fft.rfft(window * np.array(response(MashModulator(levels=17), U)))) ** 2
    lower, upper = power[N // 64 : N // 32].mean(), power[N // 32 : N // 16].mean()
    assert 10.0 * np.log10(upper / lower) == pytest.approx(18.0, abs=3.0)


def test_leakage_lets_the_error_of_the_first_stage_through() -> None:
    def noise(leakage: float) -> float:
        values = np.array(response(MashModulator(leakage=leakage), U))
        power = np.abs(np.fft.rfft(np.hanning(N) * values)) ** 2
        return float(power[20 : N // 128].mean())

    assert noise(0.01) > 3.0 * noise(0.0)
