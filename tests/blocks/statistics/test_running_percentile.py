"""The P2 estimate against the published example, exact percentiles of few samples, and those of known distributions."""

import numpy as np
import pytest
from scipy import stats

from proofmass.blocks import RunningPercentile
from tests.by_hand.functions import drive

# The twenty observations of Jain and Chlamtac (1985), table I, and their estimate of the median.
OBSERVATIONS = [
    0.02, 0.15, 0.74, 3.39, 0.83, 22.37, 10.15, 15.43, 38.62, 15.92,
    34.60, 10.28, 1.47, 0.40, 0.05, 11.39, 0.27, 0.42, 0.09, 11.37,
]  # fmt: skip
MEDIAN = 4.44


def percentile(samples: list[float], percent: float, skip: int = 0) -> float:
    inputs = [{"input": u} for u in [*samples, 0.0]]
    return float(drive(RunningPercentile(percent=percent, skip=skip), inputs)[-1]["percentile"])


def test_the_published_example() -> None:
    assert percentile(OBSERVATIONS, 50.0) == pytest.approx(MEDIAN, abs=0.005)
    assert percentile([99.0, -99.0, *OBSERVATIONS], 50.0, skip=2) == pytest.approx(MEDIAN, abs=0.005)


@pytest.mark.parametrize("percent", [1.0, 25.0, 50.0, 60.0, 90.0, 99.9])
def test_up_to_five_samples_are_exact(percent: float) -> None:
    samples = [3.0, -1.0, 7.0, 7.0, 2.0]
    for count in range(1, 6):
        assert percentile(samples[:count], percent) == pytest.approx(np.percentile(samples[:count], percent), rel=1e-14)
    assert percentile([], percent) == 0.0


@pytest.mark.parametrize("percent", [2.5, 50.0, 97.5])
@pytest.mark.parametrize(
    "law", [stats.norm(), stats.uniform(), stats.expon()], ids=["normal", "uniform", "exponential"]
)
def test_known_distributions(percent: float, law: "stats.rv_continuous") -> None:
    """Within six standard errors of an exact percentile of as many samples."""
    samples = law.rvs(20_000, random_state=3)
    expected = law.ppf(percent / 100.0)
    part = percent / 100.0
    error = np.sqrt(part * (1.0 - part) / len(samples)) / law.pdf(expected)
    assert percentile(samples.tolist(), percent) == pytest.approx(expected, abs=6.0 * error)


def test_order_and_equal_samples() -> None:
    assert percentile([4.0] * 50, 30.0) == 4.0
    ramp = np.arange(1001.0)
    for samples in (ramp, ramp[::-1]):
        assert percentile(samples.tolist(), 90.0) == pytest.approx(900.0, rel=0.02)
