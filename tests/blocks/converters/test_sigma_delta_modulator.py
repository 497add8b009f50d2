"""Modulators against independent programs bit by bit, their mean, and the noise that they shape."""

import math

import numpy as np
import pytest

from proofmass.blocks import SigmaDeltaModulator
from proofmass.blocks.declaration.problem import ModelError
from tests.by_hand.responses import noise, response


def second_order(signal: list[float]) -> list[float]:
    """Boser and Wooley's modulator by its equations."""
    first = second = 0.0
    outputs = []
    for u in signal:
        v = 1.0 if second >= 0.0 else -1.0
        outputs.append(v)
        first, second = first + 0.5 * (u - v), second + 0.5 * (first - v)
    return outputs


def slow_sine(samples: int, amplitude: float) -> list[float]:
    return [amplitude * math.sin(2.0 * math.pi * 7.0 * n / samples) for n in range(samples)]


def test_the_second_order_bit_by_bit() -> None:
    signal = slow_sine(20_000, 0.6)
    assert response(SigmaDeltaModulator(), signal) == second_order(signal)
    assert response(SigmaDeltaModulator(), signal, "code") == [int(v > 0.0) for v in second_order(signal)]


def test_the_first_order_is_an_accumulator() -> None:
    """Of a constant k / 64 its bits repeat after 64 ticks, and their mean is the constant."""
    block = SigmaDeltaModulator(gains=(1.0,), feedback=(1.0,), reference=2.0)
    for k in (-31, 0, 5, 30):
        answer = response(block, [2.0 * k / 32.0] * 6400)
        assert math.fsum(answer[-64:]) / 64.0 == pytest.approx(2.0 * k / 32.0, abs=1e-12)


@pytest.mark.parametrize("order", [3, 4])
def test_higher_orders_and_levels_against_matrices(order: int) -> None:
    """The integrators as one matrix equation, with a resonance and five levels."""
    gains, feedback, resonance = [0.2, 0.3, 0.4, 0.5][-order:], [1.0, 0.9, 0.8, 1.1][-order:], 0.02
    block = SigmaDeltaModulator(gains=gains, feedback=feedback, resonance=resonance, levels=5)
    a = np.eye(order) + np.diag(gains[1:], -1)
    a[order - 2, order - 1] -= gains[order - 2] * resonance
    x, expected, signal = np.zeros(order), [], slow_sine(3000, 0.3)
    levels = np.linspace(-1.0, 1.0, 5)
    for u in signal:
        v = levels[np.argmin(np.abs(levels - x[-1] - 1e-12))]
        expected.append(v)
        x = a @ x - np.multiply(gains, feedback) * v
        x[0] += gains[0] * u
    assert response(block, signal) == expected


def test_noise_is_shaped_by_forty_decibels_a_decade() -> None:
    samples = 1 << 15
    bits = np.array(response(SigmaDeltaModulator(), slow_sine(samples, 0.5)))
    power = np.abs(np.fft.rfft((bits - slow_sine(samples, 0.5)) * np.hanning(samples))) ** 2
    low, high = power[60:200].mean(), power[600:2000].mean()
    assert 10.0 * math.log10(high / low) == pytest.approx(40.0, abs=3.0)


def test_it_is_quiet_only_in_the_mean() -> None:
    assert set(response(SigmaDeltaModulator(), noise(500, 1, 0.1))) == {-1.0, 1.0}


@pytest.mark.parametrize(
    ("changes", "text"),
    [({"gains": (1.0,)}, "1 numbers, as gains has"), ({"gains": (1.0,) * 9}, "at most 8 numbers")],
)
def test_coefficients_that_do_not_fit_are_refused(changes: dict[str, tuple[float, ...]], text: str) -> None:
    with pytest.raises(ModelError, match=text):
        SigmaDeltaModulator(**changes)


@pytest.mark.derivation(
    SigmaDeltaModulator,
    equation="x_i' = x_i + g_i (x_(i-1) - f_i v); noise (1 - z^-1)^2 e of gains (1, 1) and feedback (1, 2)",
    source="noise in a band of 1 / (2 R) of the rate, step^2 / 12 pi^4 / (5 R^5), by the sum of (2 sin(pi f))^4",
    convention="levels are points: levels - 1 steps over two references; the band counts one-sided",
)
def test_noise_in_a_band_against_its_integral() -> None:
    """Within 6 % over 960 lines: steps of two references over the levels, not over one less, would be 0.79 of it."""
    n, reference, levels = 8192, 2.0, 9
    signal = noise(n, 7, 0.1 * reference)
    block = SigmaDeltaModulator(gains=(1.0, 1.0), feedback=(1.0, 2.0), levels=levels, reference=reference)
    values = np.array(response(block, signal))[2:] - signal[:-2]
    window = np.hanning(len(values))
    power = 2.0 * np.abs(np.fft.rfft(window * values)) ** 2 / np.sum(window**2) / len(values)
    lines, step = np.arange(n // 128, n // 8), 2.0 * reference / (levels - 1)
    shape = 2.0 / n * (2.0 * np.sin(np.pi * lines / n)) ** 4
    assert np.mean(power[lines] / shape) == pytest.approx(step**2 / 12.0, rel=0.1)
    band = lines < n // 32
    assert shape[band].sum() == pytest.approx(np.pi**4 / 5.0 * (16.0**-5 - 64.0**-5), rel=0.03)


@pytest.mark.derivation(
    SigmaDeltaModulator,
    equation="a zero of the noise at atan(sqrt(g h resonance)) / (2 pi) of the rate",
    source="the line where a DFT of the output has its notch, without an input",
    convention="in turns a tick; g and h are the gains of the last two integrators",
    wrong="the documents had sqrt(g resonance) / (2 pi): 1.4 times too high at gains of 0.5",
)
def test_the_zero_of_the_noise() -> None:
    n, gains, feedback = 16_384, (0.5, 0.4), (1.0, 1.25)
    resonance = math.tan(2.0 * math.pi * 0.03) ** 2 / 0.2
    block = SigmaDeltaModulator(gains=gains, feedback=feedback, resonance=resonance, levels=65)
    values = np.array(response(block, noise(n, 3, 0.02)))
    power = np.abs(np.fft.rfft(np.hanning(n) * (values - np.mean(values)))) ** 2
    smooth = np.convolve(power, np.ones(33) / 33.0, "same")
    assert np.argmin(smooth[n // 100 : n // 15]) + n // 100 == pytest.approx(0.03 * n, rel=0.05)
