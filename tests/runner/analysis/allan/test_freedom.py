"""Degrees of freedom of variances of differences, by the filters that make the differences of white noise."""

import itertools

import numpy as np
import pytest

from proofmass.runner.analysis.allan.freedom import AllanStatistic, freedom

CASES = [
    *itertools.product(AllanStatistic, (2, 0, -2), (1000, 130), (40,)),
    *itertools.product((AllanStatistic.ALLAN, AllanStatistic.HADAMARD), (2, 0), (900,), (1,)),
]


@pytest.mark.parametrize(("statistic", "alpha", "points", "factor"), CASES)
def test_correlations_are_those_of_filtered_white_noise(
    statistic: AllanStatistic, alpha: int, points: int, factor: int
) -> None:
    """The integral is white noise summed once for f^0, and twice for f^-2; M (sum of r^2) follows from its differences.

    Sums of single values stand for integrals: with an averaging time of 40 values they differ by less than 1 %.
    """
    order = 3 if statistic is AllanStatistic.HADAMARD else 2
    difference = np.zeros(factor + 1)
    difference[[0, -1]] = 1.0, -1.0
    taps = np.ones(1)
    for _ in range(order):
        taps = np.convolve(taps, difference)
    for _ in range((2 - alpha) // 2):
        taps = np.cumsum(taps)
    if statistic is AllanStatistic.MODIFIED:
        taps = np.convolve(taps, np.ones(factor))
    places = points - order * factor - (factor - 1 if statistic is AllanStatistic.MODIFIED else 0)
    r = np.correlate(taps, taps, "full")[len(taps) - 1 :] / (taps @ taps)
    lags = np.arange(1, min(len(r), places))
    expected = places / (1.0 + 2.0 * np.sum((1.0 - lags / places) * r[lags] ** 2))
    assert freedom(statistic, points, factor, alpha) == pytest.approx(
        max(1.0, expected), rel=1e-2 if alpha < 0 else 2e-3
    )
