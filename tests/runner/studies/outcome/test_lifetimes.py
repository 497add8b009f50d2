"""Yield by age, survival and time out of tolerance, counted by hand on a study whose values are given."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.studies.outcome.intervals import part_interval
from proofmass.runner.studies.outcome.lifetimes import ALL_LIMITS, lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.export_answers import lifetime_rows, yield_rows
from proofmass.runner.studies.shown.report import save_study_report
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

YEAR = 31557600.0
ROWS = np.array(
    [
        [0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 2.0, 2.0],  # leaves between one and two years
        [0.0, 2.0, 0.0, 0.0],  # leaves, and comes back
        [2.0, 2.0, 2.0, 2.0],  # bad when new
        [0.0, math.nan, 0.0, 0.0],  # a run that failed
    ]
)


def result_of(rows: np.ndarray, **limits: dict[str, object]) -> StudyResult:  # type: ignore[type-arg]
    graph = read_study_text(STUDY).graph
    ages = {"ages": ["0 h", "1 year", "2 year", "4 year"]}
    study = Study(graph, runs=len(rows), epochs=ages, limits=limits or {"bias": {"at_most": 1.0}})
    empty = run_study(study, runs=1, engine="python")
    values = {"bias": rows, "noise": np.zeros(rows.shape)}
    study = study.changed(runs=len(rows), seed=0)
    return dataclasses.replace(empty, study=study, numbers=np.arange(len(rows)), values=values, planned_runs=len(rows))


def test_yield_survival_and_time_out_are_those_counted_by_hand() -> None:
    (lives,) = lifetimes(result_of(ROWS))
    assert lives.good.tolist() == [4 / 5, 2 / 5, 3 / 5, 3 / 5]
    assert lives.surviving.tolist() == [4 / 5, 2 / 5, 1 / 5, 1 / 5]
    assert lives.surviving_intervals[2] == part_interval(1, 5)
    # out from an epoch to the next: 0; 2 of 4 years; 1; 4; 1
    assert lives.time_out == pytest.approx((0 + 2 + 1 + 4 + 1) / 4 / 5)
    assert lives.band == pytest.approx(math.sqrt(math.log(40.0) / 10.0))
    assert lives.left_at(0.2) == (0.0, 0.0)
    assert lives.left_at(0.5) == (0.0, YEAR)
    assert lives.left_at(0.8) == (YEAR, 2.0 * YEAR)
    assert lives.left_at(0.9) is None
    assert lives.law is None


def test_a_limit_from_an_age_on_and_one_on_the_change() -> None:
    (lives,) = lifetimes(result_of(ROWS, bias={"at_most": 1.0, "from": "1 year"}))
    assert lives.epochs == (1, 2, 3)
    assert lives.surviving.tolist() == [2 / 5, 1 / 5, 1 / 5]
    values = np.array([[-1.0, -1.09, -0.91, -1.0], [-1.0, -1.2, -1.0, -1.0], [0.0, 0.0, 0.0, 0.0]])
    result = result_of(values, bias={"change": 0.1}, noise={"at_most": 1.0})
    assert result.kept("bias").tolist() == [True, False, True]
    assert [found.limit for found in lifetimes(result)] == ["bias", "noise", ALL_LIMITS]
    assert result.yields()["all limits"] == pytest.approx(2 / 3)


def test_weibulls_law_begins_when_the_sensor_is_new() -> None:
    """A limit that counts from one year on: who has left by then did so within the first year."""
    dice = np.random.default_rng(4)
    lives = 3.0 * YEAR * dice.weibull(2.0, size=4000)
    ages = np.array([0.0, 1.0, 2.0, 4.0]) * YEAR
    rows = np.where(lives[:, None] <= ages, 2.0, 0.0)
    (found,) = lifetimes(result_of(rows, bias={"at_most": 1.0, "from": "1 year"}))
    assert found.law is not None
    low, high = found.law.shape_interval
    assert low < 2.0 < high
    low, high = found.law.scale_interval
    assert low < 3.0 * YEAR < high
    assert found.law_fits


@pytest.mark.exhaustive
def test_the_rows_and_the_report_hold_them(tmp_path: Path) -> None:
    result = result_of(ROWS)
    rows = yield_rows(result)
    assert [row["never_out"] for row in rows] == [4 / 5, 2 / 5, 1 / 5, 1 / 5]
    assert [row["age_s"] for row in rows] == [0.0, YEAR, 2.0 * YEAR, 4.0 * YEAR]
    (whole,) = lifetime_rows(result)
    assert (whole["left_50_percent_after_s"], whole["left_50_percent_by_s"]) == (0.0, YEAR)
    assert math.isnan(whole["weibull_shape"])
    page = save_study_report(result, tmp_path / "report.html").read_text()
    assert "1 % and then 10 % of the sensors were out of it when new; 50 % of the sensors left it between" in page
