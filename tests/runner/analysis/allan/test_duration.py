"""How long to record, against the scatter of many series of that length."""

import functools
import math

import numpy as np
import pytest

from proofmass import Allan, ModelError, allan
from proofmass.runner.analysis.allan.deviations import duration
from proofmass.runner.analysis.allan.freedom import AllanStatistic
from tests.by_hand.deviations import deviation_at

RATE = 10.0


@functools.cache
def white(count: int) -> Allan:
    return allan(np.random.default_rng(1).normal(size=count), rate=RATE)


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize(("kind", "factor", "error"), [("white", 20, 0.1), ("white", 5, 0.05), ("walk", 20, 0.1)])
def test_series_of_that_length_scatter_so_much(kind: str, factor: int, error: float) -> None:
    draw = np.random.default_rng(8)

    def series(count: int) -> np.ndarray:  # type: ignore[type-arg]
        white = draw.normal(size=count)
        return white if kind == "white" else np.cumsum(white)

    needed = duration(allan(series(4000), rate=RATE), factor / RATE, error)
    assert needed.tau == pytest.approx(factor / RATE)
    deviations = [deviation_at(AllanStatistic.ALLAN, series(needed.values), factor) for _ in range(800)]
    assert np.std(deviations) / np.mean(deviations) == pytest.approx(error, rel=0.1)


def test_a_recording_that_is_long_enough_says_so() -> None:
    found = white(4000)
    needed = duration(found, 2.0, 0.1)
    assert needed.present_error is not None
    assert (needed.present_error < 0.1) == (needed.seconds < 400.0)
    assert duration(found, 300.0, 0.1).present_error is None


@pytest.mark.parametrize("tau", [0.01, 1e14, 1e300, math.nan, math.inf])
def test_what_is_no_averaging_time(tau: float) -> None:
    found = white(400)
    with pytest.raises(ModelError, match="no averaging time"):
        duration(found, tau, 0.1)


@pytest.mark.parametrize(("tau", "error"), [(1.0, 0.0), (1.0, 1.5), (1.0, 1e-9), (2.4e13, 0.1)])
def test_what_has_no_answer_is_refused(tau: float, error: float) -> None:
    found = white(400)
    with pytest.raises(ModelError, match=r"no relative error|no recording of up to"):
        duration(found, tau, error)


@pytest.mark.parametrize(("tau", "error"), [(1.0, 1e-6), (1e9, 0.1)])
def test_of_white_noise_the_freedom_is_that_of_its_length(tau: float, error: float) -> None:
    """Averages over m values of white noise, overlapping: an error of 1 / sqrt(2 f), f near 3 / 2 N / m."""
    found = white(4000)
    assert duration(found, tau, error).seconds == pytest.approx(0.5 / error**2 * tau / 1.5, rel=0.1)
