"""The overlapping Allan deviation against the sums of its definition, and against the published set of SP 1065."""

import numpy as np
import pytest

from proofmass.blocks import AllanDeviation
from tests.by_hand.functions import drive


def by_definition(samples: "np.ndarray[tuple[int], np.dtype[np.float64]]", m: int) -> float:
    means = np.convolve(samples, np.ones(m) / m, "valid")
    return float(np.sqrt(0.5 * np.mean((means[m:] - means[:-m]) ** 2)))


def deviation(samples: list[float], m: int, skip: int = 0) -> float:
    rows = drive(AllanDeviation(averaging=m, skip=skip), [{"input": u} for u in [*samples, 0.0]])
    return float(rows[-1]["deviation"])


@pytest.mark.parametrize("m", [1, 2, 7, 40])
def test_against_the_definition(m: int) -> None:
    samples = 1e6 + np.cumsum(np.random.default_rng(m).normal(size=300))
    assert deviation(samples.tolist(), m) == pytest.approx(by_definition(samples, m), rel=1e-9)
    assert deviation([-5.0, *samples.tolist()], m, skip=1) == deviation(samples.tolist(), m)
    assert deviation(samples[: 2 * m].tolist(), m) == pytest.approx(by_definition(samples[: 2 * m], m), rel=1e-9)
    assert deviation(samples[: 2 * m - 1].tolist(), m) == 0.0


def test_the_published_set_of_a_thousand_points() -> None:
    """Riley (2008), section 12.4: n[i+1] = 16807 n[i] mod 2147483647 from 1234567890, over 2147483647."""
    number, samples = 1234567890, []
    for _ in range(1000):
        samples.append(number / 2147483647)
        number = 16807 * number % 2147483647
    published = {1: 2.922319e-01, 10: 9.159953e-02, 100: 3.241343e-02}
    assert {m: float(f"{deviation(samples, m):.6e}") for m in published} == published


@pytest.mark.exhaustive
def test_white_noise_and_a_ramp_have_their_closed_forms() -> None:
    noise = np.random.default_rng(1).normal(size=40_000).tolist()
    for m in (1, 10):
        assert deviation(noise, m) == pytest.approx(m**-0.5, rel=0.05)
    assert deviation([0.25 * k for k in range(100)], 8) == pytest.approx(0.25 * 8 / 2**0.5, rel=1e-12)
