"""Percentiles in the loop against those of NumPy, which keeps every sample, and those of known distributions."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy import stats

from proofmass.blocks import RunningPercentile
from proofmass.blocks.declaration.instance import shape_of


def percentile(samples: list[float], percent: float, skip: int = 0) -> float:
    block = RunningPercentile(percent=percent, skip=skip)
    functions, buffers = type(block).functions, type(block).buffers
    known: dict[str, Any] = {name: [buffer.dtype(0)] * shape_of(block, buffer)[0] for name, buffer in buffers.items()}
    state = functions["start"].function(block)
    for tick, sample in enumerate(samples):
        state = functions["update"].function(block, state, tick, *known.values(), sample)
    return float(type(block).output_functions["percentile"].function(block, state, *known.values()))


@pytest.mark.defect("S550", before="percentiles of 40 samples 20 % off, those of codes between codes", after="exact")
@pytest.mark.parametrize("percent", [1.0, 25.0, 50.0, 60.0, 90.0, 99.9])
def test_few_samples_and_codes_are_exact(percent: float) -> None:
    samples = np.random.default_rng(7).lognormal(size=1024)
    codes = np.random.default_rng(8).binomial(40, 0.5, size=20_000).astype(float)
    for exact in (samples[:1], samples[:2], samples[:5], samples[:40], samples, np.tile(samples, 3), codes):
        assert percentile(exact.tolist(), percent) == pytest.approx(np.percentile(exact, percent), rel=1e-13)
    assert percentile([], percent) == 0.0
    assert percentile([9.0, *samples[:40]], percent, skip=1) == percentile(samples[:40].tolist(), percent)


@pytest.mark.parametrize("percent", [10.0, 99.0])
def test_samples_at_the_wanted_rank_are_joined_last(percent: float) -> None:
    """Of 1,500 the table has no room: those of other ranks are joined."""
    samples = np.random.default_rng(7).lognormal(size=1500)
    assert percentile(samples.tolist(), percent) == pytest.approx(np.percentile(samples, percent), rel=1e-13)


Array = npt.NDArray[np.float64]
SIGNALS: dict[str, Array] = {
    "normal": np.random.default_rng(1).normal(size=30_000),
    "half of it zero": np.maximum(np.random.default_rng(2).normal(size=30_000), 0.0),
    "up": np.arange(30_000.0),
    "down": -np.arange(30_000.0),
    "sine": np.sin(0.0101 * np.arange(30_000.0)),
    "slow sine": np.sin(2e-4 * np.arange(30_000.0)),
    "growing": np.random.default_rng(3).normal(size=30_000) * np.arange(30_000.0),
    "shrinking": np.random.default_rng(4).normal(size=30_000) / (1.0 + np.arange(30_000.0)),
    "step": np.random.default_rng(5).normal(size=30_000) + 5.0 * (np.arange(30_000) > 15_000),
}


@pytest.mark.exhaustive(but=3)
@pytest.mark.parametrize("percent", [1.0, 50.0, 99.9])
@pytest.mark.parametrize("signal", SIGNALS)
def test_the_rank_of_an_estimate_is_off_by_a_thousandth_at_most(signal: str, percent: float) -> None:
    """Of the samples; far from the median by much less."""
    samples = SIGNALS[signal]
    estimate, place = percentile(samples.tolist(), percent), percent / 100.0 * (len(samples) - 1)
    assert np.count_nonzero(samples < estimate) - 1 - place <= 1e-3 * len(samples)
    assert place - np.count_nonzero(samples <= estimate) <= 1e-3 * len(samples)


@pytest.mark.exhaustive(but=3)
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


@pytest.mark.parametrize("place", [2.0, 2.5, 4.9, 5.0, 6.25, 7.0, 7.5])
def test_the_mean_of_joined_samples_stands_at_the_middle_of_their_ranks(place: float) -> None:
    """0 to 9, of which five are joined to 2 and four to 7.5: the value of each rank between is that rank."""
    block = RunningPercentile(percent=100.0 * place / 9.0)
    state = type(block).functions["start"].function(block)._replace(samples=10, values=2, fresh=1)
    table: tuple[list[float] | list[int], ...] = ([2.0, 7.5], [-5, -4], [5.0], [1])
    found = type(block).output_functions["percentile"].function(block, state, *table)
    assert found == pytest.approx(place, rel=1e-14)


def test_every_sample_is_counted_once() -> None:
    """Also one that equals the mean of joined ones: 0 to 9 as above, and then 2, 7.5, 5 and 6."""
    block = RunningPercentile()
    state = type(block).functions["start"].function(block)._replace(samples=10, values=2, fresh=1)
    value, count, fresh, fresh_count = [2.0, 7.5], [-5, -4], [5.0, 0.0, 0.0], [1, 0, 0]
    for sample in (2.0, 7.5, 5.0, 6.0):
        update = type(block).functions["update"].function
        state = update(block, state, 10, value, count, fresh, fresh_count, sample)
    assert (value, count) == ([2.0, 7.5], [-6, -5])
    assert (fresh, fresh_count) == ([5.0, 6.0, 0.0], [2, 1, 0])
    assert state.samples == 14
