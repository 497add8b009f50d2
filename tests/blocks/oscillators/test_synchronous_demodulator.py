"""The demodulator: both components of a carrier exactly, and averages of any signal."""

import math

import numpy as np
import pytest

from proofmass.blocks import SynchronousDemodulator
from tests.by_hand.responses import noise, responses


def references(ticks: int, per_period: int) -> tuple[list[float], list[float]]:
    angles = 2.0 * np.pi * np.arange(ticks) / per_period
    return np.sin(angles).tolist(), np.cos(angles).tolist()


def both(block: SynchronousDemodulator, signal: list[float], per_period: int) -> list[tuple[float, float]]:
    sine, cosine = references(len(signal), per_period)
    inputs = {"signal": signal, "sine": sine, "cosine": cosine}
    return list(zip(responses(block, "in_phase", **inputs), responses(block, "quadrature", **inputs), strict=True))


@pytest.mark.parametrize("ratio", [5, 25, 50])
def test_components_of_a_carrier(ratio: int) -> None:
    angles = 2.0 * np.pi * np.arange(4 * ratio + 1) / 5.0
    carrier = (0.7 * np.sin(angles + 0.4)).tolist()
    values = both(SynchronousDemodulator(ratio=ratio), carrier, 5)
    assert values[ratio - 1] == (0.0, 0.0)
    for after in (ratio, 2 * ratio, 4 * ratio):
        assert values[after] == pytest.approx((0.7 * math.cos(0.4), 0.7 * math.sin(0.4)), abs=1e-14)


def test_averages_of_any_signal() -> None:
    ratio, signal = 8, noise(8 * 20 + 1)
    sine, cosine = (np.array(reference[:-1]) for reference in references(len(signal), 8))
    values = both(SynchronousDemodulator(ratio=ratio), signal, 8)[ratio::ratio]
    u = np.array(signal[:-1])
    along = [2.0 * (u * reference).reshape(-1, ratio).mean(axis=1) for reference in (sine, cosine)]
    assert np.array(values) == pytest.approx(np.transpose(along), abs=1e-14)


@pytest.mark.derivation(
    SynchronousDemodulator,
    equation="i = 2 / N sum of s sin, q = 2 / N sum of s cos over N ticks",
    source="least squares of a sine and a cosine, by NumPy; its covariance gives sqrt(2 / N) of white noise",
    convention="peaks, not rms; q of a carrier that leads is positive; the mean of N ticks is given after them",
)
def test_least_squares_of_a_carrier_in_noise() -> None:
    ratio, per_period = 30, 6
    sine, cosine = (np.array(reference) for reference in references(ratio + 1, per_period))
    signal = 1.3 * np.sin(2.0 * np.pi * np.arange(ratio + 1) / per_period - 0.9) + noise(ratio + 1)
    columns = np.transpose([sine, cosine])[:ratio]
    fitted = np.linalg.lstsq(columns, signal[:ratio])[0]
    assert both(SynchronousDemodulator(ratio=ratio), signal.tolist(), per_period)[ratio] == pytest.approx(tuple(fitted))
    deviations = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    assert deviations == pytest.approx(np.full(2, math.sqrt(2.0 / ratio)))


def test_what_it_says_in_the_first_average() -> None:
    values = both(SynchronousDemodulator(ratio=5, initial_in_phase=0.3), [0.0] * 6, 5)
    assert values[:5] == [(0.3, 0.0)] * 5
    assert values[5] == (0.0, 0.0)
