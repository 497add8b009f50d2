"""Degrees of freedom of variances of differences, by the filters that make the differences of white noise."""

import itertools

import numpy as np
import pytest

from proofmass.runner.analysis.allan.freedom import AllanStatistic, freedom

LONG = 1 << 16  # samples of a filter, where those of flicker have faded
CASES = [
    *itertools.product(AllanStatistic, (2, 0, -1, -2), (1000, 130), (40,)),
    *itertools.product((AllanStatistic.MODIFIED,), (1,), (1000, 130), (40,)),
    *itertools.product((AllanStatistic.ALLAN, AllanStatistic.HADAMARD), (2, 0), (900,), (1,)),
]


@pytest.mark.parametrize(("statistic", "alpha", "points", "factor"), CASES)
def test_correlations_are_those_of_filtered_white_noise(
    statistic: AllanStatistic, alpha: int, points: int, factor: int
) -> None:
    """White noise through (1 - z^-1)^-d, d = 1 - alpha / 2, is the integral of noise of f^alpha (Kasdin 1995).

    Single values stand for integrals: with averaging times of 40 values they differ by less than 1 %.
    """
    order = 3 if statistic is AllanStatistic.HADAMARD else 2
    averaged = statistic is AllanStatistic.MODIFIED
    d, k = 1.0 - alpha / 2.0, np.arange(1.0, LONG)
    taps = np.cumprod(np.append(1.0, (k - 1.0 + d) / k))
    for _ in range(order):
        taps = taps - np.append(np.zeros(factor), taps[:-factor])
    if averaged:
        taps = np.convolve(taps, np.ones(factor))[:LONG]
    places = points - order * factor - (factor - 1 if averaged else 0)
    lags = np.arange(1, min((order + 1) * factor + 1, places))
    r = np.fft.irfft(np.abs(np.fft.rfft(taps, 2 * LONG)) ** 2)
    expected = places / (1.0 + 2.0 * np.sum((1.0 - lags / places) * (r[lags] / r[0]) ** 2))
    assert freedom(statistic, points, factor, alpha) == pytest.approx(max(1.0, expected), rel=0.01)
