"""Confidence intervals of what a study estimates, at a level of 95 %, for sensors that are drawn independently."""

import math
from collections.abc import Sequence

import numpy as np

from proofmass.runner.host.arrays import AnyArray

LEVEL = 0.95
FEWEST_OF_DEVIATION = 5  # values
_Z = 1.959963984540054  # standard normal quantile of (1 + LEVEL) / 2

Bounds = tuple[float, float]


def part_interval(good: float, runs: int) -> Bounds:
    """Interval of a probability, of which `good` of `runs` are known (Clopper and Pearson,
    Biometrika 26 (1934) 404).

    At its ends so many good ones, or so few, have a probability of 2.5 %: it holds 95 % at least,
    whatever the truth.
    """
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import betaincinv

    aside, bad = 0.5 - 0.5 * LEVEL, runs - good
    low = float(betaincinv(good, bad + 1.0, aside)) if good > 0.0 else 0.0
    return low, float(betaincinv(good + 1.0, bad, 1.0 - aside)) if bad > 0.0 else 1.0


def halves_of_means(runs: AnyArray, deviations: AnyArray) -> AnyArray:
    """Half of Student's intervals of means, t s / sqrt(n), each of two values or more."""
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import stdtrit

    return np.asarray(stdtrit(runs - 1, 0.5 + 0.5 * LEVEL) * deviations / np.sqrt(runs))


def mean_interval(values: AnyArray) -> Bounds:
    """Student's interval of the mean."""
    half = float(halves_of_means(np.array(len(values)), values.std(ddof=1))) if len(values) > 1 else math.inf
    return float(values.mean()) - half, float(values.mean()) + half


def deviation_interval(values: AnyArray) -> Bounds:
    """Interval of the standard deviation: exp(ln(c s^2) -+ t e) under the root (Bonett, CSDA 50 (2006) 775).

    e = c sqrt((g - (n - 3) / n) / (n - 1)), c = n / (n - z), g the kurtosis about a trimmed mean,
    and Student's t. Small samples see too few of the values that make a kurtosis large, so g counts
    1 + 4 / sqrt(n) times for the upper end: what 93 % at least ask for of normal, lognormal,
    exponential and Laplace's laws. Fewer than five values, or equal ones, bound nothing.
    """
    count = len(values)
    if count < FEWEST_OF_DEVIATION or np.ptp(values) == 0.0:
        return 0.0, math.inf
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import stdtrit

    cut = int(count * 0.5 / math.sqrt(count - 4.0))
    scaled = (values - values.mean()) / values.std(ddof=1)
    kurtosis = float(((scaled - np.sort(scaled)[cut : count - cut].mean()) ** 4).sum()) * count / (count - 1.0) ** 2
    larger, student = count / (count - _Z), float(stdtrit(count - 1, 0.5 + 0.5 * LEVEL))

    def error(kurtosis: float) -> float:
        return larger * math.sqrt(max(kurtosis - (count - 3.0) / count, 0.0) / (count - 1.0))

    middle = math.sqrt(larger) * float(values.std(ddof=1))
    upper = error(kurtosis * (1.0 + 4.0 / math.sqrt(count)))
    return middle * math.exp(-0.5 * student * error(kurtosis)), middle * math.exp(0.5 * student * upper)


def percentile_interval(values: AnyArray, percent: float) -> Bounds:
    """Interval of a percentile of any distribution: two of the values in order; infinite where they are too few.

    The number of values below the percentile is binomial (David and Nagaraja, "Order statistics",
    3rd ed. (2003), 7.1).
    """
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import bdtr, bdtrik

    runs, part, aside = len(values), percent / 100.0, 0.5 - 0.5 * LEVEL
    first = 0 if bdtr(0, runs, part) > aside else math.floor(bdtrik(aside, runs, part)) + 1  # ranks, from 1
    last = math.ceil(bdtrik(1.0 - aside, runs, part)) + 1
    ordered = np.partition(values, [max(first, 1) - 1, min(last, runs) - 1])
    return (
        float(ordered[first - 1]) if first >= 1 else -math.inf,
        float(ordered[last - 1]) if last <= runs else math.inf,
    )


def concise(value: float, interval: Sequence[float]) -> str:
    """A value with the larger half of its interval in brackets, in units of its last digits (GUM, 7.2.2).

    >>> concise(9.806657, (9.8055, 9.8079)), concise(523461.0, (523000.0, 523900.0)), concise(2.0, (2.0, math.inf))
    ('9.8067(12)', '523461(460)', '2')
    >>> concise(-7.61e-6, (-15.7e-6, 0.0))
    '-7.6(81)e-06'
    """
    half = max(value - interval[0], interval[1] - value)
    if not 0.0 < half < math.inf:
        return f"{value:.6g}"
    power = math.floor(math.log10(max(abs(value), half)))
    if -4 <= power < 9:
        power = 0
    value, half = value / 10.0**power, float(f"{half / 10.0**power:.1e}")
    digits = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{digits}f}({round(half * 10**digits)})" + (f"e{power:+03d}" if power else "")
