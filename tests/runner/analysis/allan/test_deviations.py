"""Deviations against the published ones of the 1000-point set of NBS Monograph 140, and of known noise."""

import math

import numpy as np
import pytest

from proofmass import allan
from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.allan.deviations import dominating
from proofmass.runner.analysis.allan.freedom import AllanStatistic, freedom
from proofmass.runner.analysis.allan.levels import NAMES, Level, Levels, density_terms
from tests.by_hand.amounts import amounts
from tests.by_hand.deviations import deviation_at

PUBLISHED = {  # NIST SP 1065, table 31; averages of 1, 10 and 100 values
    AllanStatistic.ALLAN: (2.922319e-01, 9.159953e-02, 3.241343e-02),
    AllanStatistic.MODIFIED: (2.922319e-01, 6.172376e-02, 2.170921e-02),
    AllanStatistic.HADAMARD: (2.943883e-01, 9.581083e-02, 3.237638e-02),
}


def published_set() -> np.ndarray:  # type: ignore[type-arg]
    number, values = 1234567890, []
    for _ in range(1000):
        values.append(number / 2147483647)
        number = 16807 * number % 2147483647
    return np.array(values)


@pytest.mark.parametrize("statistic", list(AllanStatistic))
@pytest.mark.friendly(31, "published deviations")
def test_published_deviations(statistic: AllanStatistic) -> None:
    for factor, expected in zip((1, 10, 100), PUBLISHED[statistic], strict=True):
        assert deviation_at(statistic, published_set(), factor) == pytest.approx(expected, rel=1e-6)


def test_curves_are_the_deviations_at_all_averaging_times() -> None:
    found = allan(published_set(), rate=4.0, unit="V")
    for statistic, curve in found.curves.items():
        factors = np.round(curve.taus * 4.0).astype(int)
        assert (factors[0], len(factors) > 30) == (1, True)
        expected = [deviation_at(statistic, published_set(), int(m)) for m in factors]
        assert curve.deviation == pytest.approx(expected, rel=1e-12)
        assert np.all((curve.low < curve.deviation) & (curve.deviation < curve.high))


def noise_of(random: np.random.Generator, alpha: int, count: int) -> np.ndarray:  # type: ignore[type-arg]
    white = random.normal(size=count + 1)
    return {2: np.diff(white), 0: white[1:], -2: np.cumsum(white[1:])}[alpha]


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("statistic", list(AllanStatistic))
@pytest.mark.parametrize("alpha", [2, 0, -2])
@pytest.mark.parametrize("factor", [4, 16, 64])
def test_degrees_of_freedom_are_those_of_the_scatter(statistic: AllanStatistic, alpha: int, factor: int) -> None:
    random = np.random.default_rng(factor)
    squares = [deviation_at(statistic, noise_of(random, alpha, 1024), factor) ** 2 for _ in range(1500)]
    scatter = 2.0 * float(np.mean(squares)) ** 2 / float(np.var(squares))
    assert freedom(statistic, 1025, factor, alpha) == pytest.approx(scatter, rel=0.1)


def test_degrees_of_freedom_of_white_noise_in_closed_form() -> None:
    """Riley, NIST SP 1065, table 5, for overlapping Allan deviations of white noise."""
    for m in (1, 4, 16, 64):
        known = (3 * 1024 / (2 * m) - 2 * 1023 / 1025) * 4 * m * m / (4 * m * m + 5)
        assert freedom(AllanStatistic.ALLAN, 1025, m, 0) == pytest.approx(known, rel=0.02)


@pytest.mark.parametrize("signals", amounts(2, 60))
def test_intervals_hold_the_truth_as_often_as_they_say(signals: int) -> None:
    random, inside, all_of_them = np.random.default_rng(11), 0, 0
    for _ in range(signals):
        curve = allan(random.normal(size=4096), rate=1.0).curves[AllanStatistic.ALLAN]
        truth = 1.0 / np.sqrt(curve.taus)
        inside += int(np.sum((curve.low <= truth) & (truth <= curve.high)))
        all_of_them += len(truth)
    assert inside / all_of_them == pytest.approx(0.95, abs=0.03 * math.sqrt(60 / signals))


def test_a_constant_drops_out() -> None:
    values = published_set()
    assert deviation_at(AllanStatistic.ALLAN, values + 1e6, 10) == pytest.approx(
        deviation_at(AllanStatistic.ALLAN, values, 10), rel=1e-8
    )
    drifting = values + 1e-3 * np.arange(1000)
    assert deviation_at(AllanStatistic.HADAMARD, drifting, 10) == pytest.approx(
        deviation_at(AllanStatistic.HADAMARD, values, 10)
    )


def test_a_signal_that_stands_still_is_refused() -> None:
    with pytest.raises(ModelError, match="does not move"):
        allan(np.ones(100), rate=1.0)


def test_a_short_signal_is_refused() -> None:
    with pytest.raises(ModelError, match="too short for an Allan deviation"):
        allan(np.ones(63), rate=1.0)


@pytest.mark.parametrize(("name", "exponent"), [("N", 0), ("B", -1), ("K", -2), ("Q", 2)])
def test_a_noise_alone_dominates_with_the_exponent_of_its_density(name: str, exponent: int) -> None:
    """White, 1 / f, 1 / f^2 of a random walk, f^2 of a difference: the slopes of `density_terms` at low frequencies."""
    levels = Levels(tuple(Level(n, float(n == name), 0.0, 2.0) for n in NAMES), 0.1, 0.0)
    assert dominating(levels, np.array([0.1, 1.0, 100.0])) == [exponent] * 3
    low = density_terms(np.array([1e-4, 2e-4]), 0.1)[:, NAMES.index(name)]
    assert math.log2(low[1] / low[0]) == pytest.approx(exponent, abs=1e-6)
