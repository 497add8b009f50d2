"""Fates of sensors under limits that begin at some age, and what Weibull's law is asked, counted by hand."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.studies.outcome import lifetimes as module
from proofmass.runner.studies.outcome.intervals import part_interval
from proofmass.runner.studies.outcome.lifetimes import ALL_LIMITS, Lifetimes, lifetimes
from proofmass.runner.studies.outcome.outcomes import SensorRun, outcomes_of
from proofmass.runner.studies.outcome.weibull import weibull
from tests.by_hand.study_results import AGED, study_result

TWO = 'epochs = { ages = ["0 h", "1 year"] }\n'
ROWS = [[0, 0, 9], [0, 9, 0], [0, 0, 0], [9, 9, 0]]  # within a limit of 1: at 0, 1 and 3 years


@pytest.fixture
def asked(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """What Weibull's law is asked for."""
    found: list[Any] = []
    monkeypatch.setattr(module, "weibull", lambda edges, left, kept: found.append((edges, left, kept)))
    return found


def test_a_limit_from_the_beginning(asked: list[Any]) -> None:
    """One is bad when new, one leaves within the first year, one in the years to the third."""
    (lives,) = lifetimes(study_result(AGED + "limits = { bias = { at_most = 1 } }\n", {"bias": ROWS}))
    assert asked == [((0.0, YEAR, 3.0 * YEAR), [1, 1], 1)]
    assert (lives.good.tolist(), lives.surviving.tolist()) == ([0.75, 0.5, 0.75], [0.75, 0.5, 0.25])
    assert lives.good_intervals == (part_interval(3, 4), part_interval(2, 4), part_interval(3, 4))
    assert lives.surviving_intervals == (part_interval(3, 4), part_interval(2, 4), part_interval(1, 4))
    assert lives.good_at_last.tolist() == [False, True, True, True]
    assert lives.time_out == pytest.approx((0.0 + 2.0 / 3.0 + 0.0 + 1.0) / 4.0)


def test_a_limit_from_an_age_on_counts_who_has_left_by_then(asked: list[Any]) -> None:
    """Half have left by one year; a limit from the last age on has no time out of it."""
    limits = 'limits = { bias = { at_most = 1, from = "1 year" }, noise = { at_most = 1, from = "3 year" } }\n'
    first, last, both = lifetimes(study_result(AGED + limits, {"bias": ROWS, "noise": ROWS}))
    assert asked[0] == ((0.0, YEAR, 3.0 * YEAR), [2, 1], 1)
    assert asked[1] == ((0.0, 3.0 * YEAR), [1], 3)
    assert [lives.epochs for lives in (first, last, both)] == [(1, 2), (2,), (1, 2)]
    assert (both.limit, both.good.tolist()) == (ALL_LIMITS, [0.5, 0.75])
    assert (first.time_out, last.time_out) == (0.5, 0.0)


def test_there_are_no_lifetimes_without_two_epochs_limits_and_runs() -> None:
    limit = "limits = { bias = { at_most = 1 } }\n"
    (lives,) = lifetimes(study_result(TWO + limit, {"bias": [[9, 0], [0, 9], [0, 0], [0, 0]]}))
    assert lives.time_out == 0.25, "from the first age to the second one of four is out"
    assert list(lifetimes(study_result(limit, {"bias": [[0]]}))) == []
    assert list(lifetimes(study_result(TWO, {"bias": [[0, 1]]}))) == []
    made = study_result(TWO + limit, {"bias": [[0, 1]]})
    assert list(lifetimes(made.some(made.numbers < 0))) == []


def lives(surviving: list[float], band: float, law: Any = None) -> Lifetimes:
    some: Any = (1.0, 1.0)
    parts = np.array(surviving)
    return Lifetimes("bias", 8, (0, 1), (0.0, YEAR), parts, some, parts, some, parts > 0, band, law, 0.0, (0.0, 0.0))


def test_a_law_fits_up_to_the_end_of_the_band() -> None:
    law = SimpleNamespace(survival=lambda ages: np.array([1.0, 0.75]))
    assert lives([1.0, 0.5], 0.25, law).law_fits
    assert not lives([1.0, 0.5], 0.24, law).law_fits
    assert not lives([1.0, 0.5], 0.25).law_fits


def test_a_part_has_left_but_for_rounding() -> None:
    assert lives([1.0, 0.9 + 1e-13], 0.1).left_at(0.1) == (0.0, YEAR)
    assert lives([1.0, 0.9 + 1e-8], 0.1).left_at(0.1) is None


def test_weibulls_law_needs_five_sensors_in_two_intervals() -> None:
    """Its unit of time does not matter."""
    law = weibull([0.0, 1.0, 2.0, 3.0], [2, 0, 3], 5)
    assert law is not None
    assert weibull([0.0, 1.0, 2.0, 3.0], [2, 0, 2], 6) is None
    assert weibull([0.0, 1.0, 2.0, 3.0], [0, 0, 9], 6) is None
    years = weibull([0.0, YEAR, 2.0 * YEAR, 3.0 * YEAR], [2, 0, 3], 5)
    assert years is not None
    assert (years.shape, years.scale) == pytest.approx((law.shape, law.scale * YEAR))
    assert years.survival(np.array([years.scale])) == pytest.approx([np.exp(-1.0)])


@pytest.mark.parametrize("epochs", [1, 3])
def test_the_numbers_of_runs_are_those_of_their_first_epochs(epochs: int) -> None:
    runs = [SensorRun(run, epoch, (10.0 * run + epoch,)) for run in (4, 2, 7) for epoch in range(epochs)]
    found = outcomes_of(runs, epochs, 1)
    assert found.numbers.tolist() == [4, 2, 7]
    assert found.values[:, :, 0].tolist() == [[10.0 * run + epoch for epoch in range(epochs)] for run in (4, 2, 7)]
