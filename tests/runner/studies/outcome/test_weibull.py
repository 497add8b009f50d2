"""Weibull's law from looks at sensors, against closed forms, SciPy's optimum and drawn lifetimes."""

import math

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import weibull_min

from proofmass.runner.studies.outcome.weibull import weibull

YEARS = np.arange(16.0)


def test_two_looks_determine_the_law_exactly() -> None:
    """S(1) = 0.9 and S(2) = 0.6 have one law: log(-log S) is a straight line over log t."""
    law = weibull([0.0, 1.0, 2.0], [100, 300], 600)
    assert law is not None
    shape = math.log(math.log(0.6) / math.log(0.9)) / math.log(2.0)
    assert law.shape == pytest.approx(shape, rel=1e-6)
    assert law.scale == pytest.approx((-math.log(0.9)) ** (-1.0 / shape), rel=1e-6)
    assert law.survival(np.array([1.0, 2.0])) == pytest.approx([0.9, 0.6], rel=1e-6)
    assert law.one_percent == pytest.approx(law.scale * (-math.log(0.99)) ** (1.0 / shape), rel=1e-6)


def test_it_is_the_optimum_of_the_likelihood() -> None:
    left, surviving = [3, 8, 20, 31, 55, 40], 43
    law = weibull(YEARS[:7].tolist(), left, surviving)
    assert law is not None

    def loss(point: np.ndarray) -> float:  # type: ignore[type-arg]
        survival = weibull_min.sf(YEARS[:7], math.exp(point[0]), scale=math.exp(point[1]))
        return float(-(np.array(left) * np.log(-np.diff(survival))).sum() - surviving * math.log(survival[-1]))

    best = minimize(loss, [0.5, 1.5], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12})
    assert [law.shape, law.scale] == pytest.approx(np.exp(best.x), rel=1e-6)


@pytest.mark.exhaustive
def test_its_intervals_cover_the_truth() -> None:
    """95 % of 200 samples, give or take three standard errors."""
    dice, covered = np.random.default_rng(1), np.zeros(3)
    for _ in range(200):
        lives = weibull_min.rvs(2.5, scale=12.0, size=300, random_state=dice)
        law = weibull(YEARS.tolist(), np.histogram(lives, YEARS)[0].tolist(), int((lives > 15.0).sum()))
        assert law is not None
        truths = 2.5, 12.0, 12.0 * (-math.log(0.99)) ** (1.0 / 2.5)
        ends = law.shape_interval, law.scale_interval, law.one_percent_interval
        covered += [low < truth < high for truth, (low, high) in zip(truths, ends, strict=True)]
    assert (np.abs(covered / 200.0 - 0.95) < 3.0 * math.sqrt(0.95 * 0.05 / 200.0)).all()


@pytest.mark.parametrize(("left", "surviving"), [([4, 0], 996), ([500, 0], 0), ([0, 500], 500), ([59, 1], 0)])
def test_too_little_determines_no_law(left: list[int], surviving: int) -> None:
    assert weibull([0.0, 1.0, 2.0], left, surviving) is None


def test_intervals_of_two_looks_follow_from_counts() -> None:
    """By y_i = log(-log S_i), var S_i = S_i (1 - S_i) / n and cov = S_2 (1 - S_1) / n; Wald's in logarithms."""
    law = weibull([0.0, 1.0, 2.0], [100, 300], 600)
    assert law is not None
    s, double = np.array([0.9, 0.6]), math.log(2.0)
    covariance = np.array([[0.09, 0.06], [0.06, 0.24]]) / 1000.0
    by_counts = np.diag(1.0 / (s * np.log(s)))  # of y
    y, level = np.log(-np.log(s)), math.log(-math.log(0.99))
    shape = (y[1] - y[0]) / double
    of_shape = np.array([-1.0, 1.0]) / double / shape  # of its logarithm
    of_one = np.array([-1.0, 0.0]) / shape - (level - y[0]) / shape * of_shape
    for gradient, value, ends in (
        (of_shape, law.shape, law.shape_interval),
        (of_one, law.one_percent, law.one_percent_interval),
    ):
        moved = gradient @ by_counts
        half = 1.959964 * math.sqrt(moved @ covariance @ moved)
        assert ends == pytest.approx((value * math.exp(-half), value * math.exp(half)), rel=1e-4)
