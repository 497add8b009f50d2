"""Counter-based deviates: published known answers, distribution, independence, and the same bits compiled."""

import math
from collections.abc import Callable
from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from scipy import stats
from scipy.special import ndtri

from benchmarks.normal_deviates import MOST, WAYS, errors
from proofmass.blocks.arithmetic.counter_random import normal_deviate, normal_quantile, philox, uniform_deviate
from tests.by_hand.compiled import compiled, over_columns

ONES = 0xFFFFFFFF
KNOWN_ANSWERS = [  # kat_vectors of Random123: key, counter, words
    ((0, 0), (0, 0, 0, 0), (0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8)),
    ((ONES, ONES), (ONES, ONES, ONES, ONES), (0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD)),
    (
        (0xA4093822, 0x299F31D0),
        (0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344),
        (0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1),
    ),
]
COUNT = 100_000


@pytest.fixture(scope="module")
def fast_normal() -> Any:
    return compiled(normal_deviate)


def draws(seed: int = 1, run: int = 0, stream: int = 0, first: int = 0) -> np.ndarray:
    """Deviates of samples one after the other, in compiled code."""
    samples = np.arange(first, first + COUNT)
    return over_columns(normal_deviate, samples, before=(seed, run, stream))[0]


@pytest.mark.parametrize(("key", "counter", "words"), KNOWN_ANSWERS)
def test_published_known_answers(key: tuple[int, ...], counter: tuple[int, ...], words: tuple[int, ...]) -> None:
    assert philox(*key, *counter) == words
    assert compiled(philox)(*key, *counter) == words


def test_layout_of_key_and_counter() -> None:
    seed, run, stream, sample = 0x299F31D0A4093822, 0x03707344, 0x13198A2E, 0x05A308D3243F6A88
    word0, word1, _, _ = philox(0xA4093822, 0x299F31D0, 0x243F6A88, 0x05A308D3, 0x13198A2E, 0x03707344)
    assert uniform_deviate(seed, run, stream, sample) * 2**53 == 2 * ((word0 << 20) | (word1 >> 12)) + 1


words = st.integers(0, ONES)
long_words = st.integers(0, 2**62 - 1)


@given(long_words, words, words, long_words)
def test_uniform_is_inside_and_normal_is_its_quantile(seed: int, run: int, stream: int, sample: int) -> None:
    uniform = uniform_deviate(seed, run, stream, sample)
    assert 0.0 < uniform < 1.0
    assert normal_deviate(seed, run, stream, sample) == normal_quantile(uniform)


@given(st.one_of(st.floats(2.0**-53, 1.0 - 2.0**-53), st.floats(1.0, 53.0).map(lambda octaves: 2.0**-octaves)))
@example(2.0**-53)
@example(1.0 - 2.0**-53)
@example(0.075)
@example(0.925)
@example(0.3277085674689529)
def test_quantile_within_6_ulp(probability: float) -> None:
    got = normal_quantile(probability)
    with mpmath.workprec(200):
        exact = mpmath.mpf(got)
        for _ in range(3):
            density = mpmath.exp(-exact * exact / 2) / mpmath.sqrt(2 * mpmath.pi)
            off = (mpmath.erfc(-exact / mpmath.sqrt(2)) / 2 - mpmath.mpf(probability)) / density
            exact -= off / (1 + exact * off / 2)
        assert abs(got - exact) <= 6 * math.ulp(float(exact))


def test_quantile_over_the_whole_range_against_scipy() -> None:
    tail = 2.0 ** -np.linspace(1.0, 53.0, 4000)
    for probabilities in (tail, 1.0 - tail):
        got = [normal_quantile(probability) for probability in probabilities.tolist()]
        np.testing.assert_allclose(got, ndtri(probabilities), rtol=2e-15)
    half = [n / 4096 for n in range(1, 2049)]
    assert [normal_quantile(1.0 - p) for p in half] == [-normal_quantile(p) for p in half]


def test_moments_and_distribution_of_the_normal() -> None:
    values = draws()
    assert abs(values.mean()) < 4 / math.sqrt(COUNT)
    assert abs(values.var() - 1) < 4 * math.sqrt(2 / COUNT)
    assert abs((values**3).mean()) < 4 * math.sqrt(15 / COUNT)
    assert abs((values**4).mean() - 3) < 4 * math.sqrt(96 / COUNT)
    assert stats.kstest(values, "norm").pvalue > 1e-4


def test_runs_streams_seeds_and_samples_are_independent() -> None:
    here = draws()
    others = [
        draws(run=1),
        draws(stream=1),
        draws(seed=2),
        draws(seed=1 + (1 << 32)),
        draws(first=1),
        draws(first=1 << 32),
    ]
    for other in others:
        for first, second in ((here, other), (here**2 - 1, (other**2 - 1) / 2)):
            assert abs((first * second).mean()) < 4 / math.sqrt(COUNT)


@pytest.mark.parametrize("function", [uniform_deviate, normal_deviate])
def test_compiled_to_the_same_bits(function: Callable[[int, int, int, int], float]) -> None:
    fast = compiled(function)
    cases = [(seed, run, stream, n * n) for n in range(500) for seed, run, stream in ((3, 0, ONES), (2**62 - 1, n, 5))]
    assert [function(*case) for case in cases] == [fast(*case) for case in cases]


@pytest.mark.parametrize("way", WAYS)
def test_moments_lags_and_distance_along_samples_runs_and_streams(way: str) -> None:
    found = dict(errors(way, 400_000))
    assert set(found) == {"mean", "variance", "skewness", "kurtosis", "distance", *(f"lag {n}" for n in range(1, 17))}
    assert max(map(abs, found.values())) < MOST


@pytest.mark.exhaustive
def test_the_statistics_are_those_of_scipy(fast_normal: Any) -> None:
    count = 20_000
    values = np.array([fast_normal(1, 3, 5, sample) for sample in range(count)])
    found = dict(errors("samples", count))
    root = math.sqrt(count)
    assert found["skewness"] == pytest.approx(stats.skew(values) * root / math.sqrt(6), rel=1e-6)
    assert found["kurtosis"] == pytest.approx(stats.kurtosis(values) * root / math.sqrt(24), rel=1e-6)
    assert found["lag 3"] == pytest.approx((values[3:] * values[:-3]).sum() / root, rel=1e-9)
    pvalue = stats.kstest(values, "norm").pvalue
    assert found["distance"] == pytest.approx(stats.norm.isf(pvalue / 2), abs=0.1)
