"""The cascade: the error of its first stage falls out to the last bit, and its noise is of third order."""

import numpy as np
import pytest

from proofmass.blocks import MashModulator
from tests.by_hand.responses import noise, response

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


@pytest.mark.derivation(
    MashModulator,
    equation="output = z^-3 u + (1 - z^-1)^3 e, e of a quantiser with equal steps",
    source="noise in a band of 1 / (2 R) of the rate: step^2 / 12 pi^6 / (7 R^7), from an integral of (2 sin(pi f))^6",
    convention="levels are points, so levels - 1 steps over two references; the band counts one-sided",
)
@pytest.mark.parametrize(("levels", "reference"), [(9, 1.0), (33, 2.0)])
def test_noise_in_a_band_against_its_integral(levels: int, reference: float) -> None:
    """Within 6 % over 960 lines: steps of two references over the levels, not over one less, would be 0.79 of it."""
    n = 8192
    signal = noise(n, 7, 0.1 * reference)
    values = np.array(response(MashModulator(levels=levels, reference=reference), signal))[3:] - signal[:-3]
    window = np.hanning(len(values))
    power = 2.0 * np.abs(np.fft.rfft(window * values)) ** 2 / np.sum(window**2) / len(values)
    lines, step = np.arange(n // 128, n // 8), 2.0 * reference / (levels - 1)
    shape = 2.0 / n * (2.0 * np.sin(np.pi * lines / n)) ** 6
    assert np.mean(power[lines] / shape) == pytest.approx(step**2 / 12.0, rel=0.1)
    band = lines < n // 32
    assert shape[band].sum() == pytest.approx(np.pi**6 / 7.0 * (16.0**-7 - 64.0**-7), rel=0.03)


def test_leakage_takes_some_of_a_constant() -> None:
    """At rest leakage a = u - v, leakage b = a - 2 v, and b is v but for its error: v is u / (1 + leakage)^2."""
    answer = response(MashModulator(levels=33, leakage=0.02), [0.31] * 12_000)
    assert np.mean(answer[2000:]) == pytest.approx(0.31 / 1.02**2, rel=2e-3)
