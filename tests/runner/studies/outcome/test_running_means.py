"""Means while a study runs: the same stop in every order of arrival, and as soon as the intervals say so."""

import math
import random
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.outcome.outcomes import SensorRun, outcomes_of
from proofmass.runner.studies.outcome.running_means import FEWEST, RunningMeans
from proofmass.runner.studies.runs.sensor_runs import SensorRuns
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

HALF = 0.05


@pytest.fixture
def study(tmp_path: Path) -> Study:
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("runs = 6", "runs = 200") + f"\n[study.stop]\nnoise = {HALF}\n")
    return read_study(path)


def made_runs(study: Study) -> list[SensorRun]:
    dice = np.random.default_rng(3)
    return [
        SensorRun(run, epoch, (1000.0 + dice.normal(), dice.normal(5.0, 0.2)) if dice.random() > 0.05 else None, "")
        for run in range(study.runs * study.points)
        for epoch in range(len(study.epochs))
    ]


def by_definition(study: Study, runs: list[SensorRun]) -> int:
    """The first number of sensors from which on every interval is short enough, found from scratch each time."""
    for sensors in range(FEWEST, study.runs):
        halves = []
        for point in range(study.points):
            for epoch in range(len(study.epochs)):
                seen = [r for r in runs if r.run < sensors * study.points and r.epoch == epoch]
                values = [r.values[1] for r in seen if r.run % study.points == point and r.values is not None]
                interval = stats.ttest_1samp(values, 0.0).confidence_interval(0.95)
                halves.append(0.5 * (interval.high - interval.low))
        if max(halves) <= HALF:
            return sensors * study.points
    return study.runs * study.points


def test_it_stops_at_the_same_run_in_every_order(study: Study) -> None:
    measures = SensorRuns(study, "python").plan.measures
    runs = made_runs(study)
    expected = by_definition(study, runs)
    assert FEWEST < expected < len(runs)
    for seed in range(4):
        shuffled = list(range(study.runs * study.points))
        random.Random(seed).shuffle(shuffled)
        means = RunningMeans(study, measures)
        for first in range(0, len(shuffled), 7):
            some = sorted(shuffled[first : first + 7])
            means.add(outcomes_of((run for run in runs if run.run in some), len(study.epochs), 2))
        assert (means.end, means.enough) == (expected, True)


@pytest.mark.parametrize("together", [1, FEWEST - 1, FEWEST, FEWEST + 5])
def test_sensors_that_are_all_alike_are_known_from_the_fewest(study: Study, together: int) -> None:
    """No sooner, and no later, however many arrive at a time."""
    means = RunningMeans(study, SensorRuns(study, "python").plan.measures)
    step = together * study.points
    for first in range(0, (FEWEST + 10) * study.points, step):
        runs = (SensorRun(run, epoch, (0.0, 5.0), "") for run in range(first, first + step) for epoch in range(3))
        means.add(outcomes_of(runs, 3, 2))
    assert (means.end, means.enough) == (FEWEST * study.points, True)


def test_a_measure_without_values_that_stop_does_not_name_keeps_nothing_going(study: Study) -> None:
    means = RunningMeans(study, SensorRuns(study, "python").plan.measures)
    count = FEWEST * study.points
    means.add(outcomes_of((SensorRun(run, epoch, (math.nan, 5.0)) for run in range(count) for epoch in range(3)), 3, 2))
    assert (means.end, means.enough) == (count, True)


def test_what_it_shows(study: Study) -> None:
    means = RunningMeans(study, SensorRuns(study, "python").plan.measures)
    assert means.text() == ""
    runs = (SensorRun(run, epoch, (0.0, float(run // 2)), "") for run in range(60) for epoch in range(3))
    means.add(outcomes_of(runs, 3, 2))
    half = stats.t.ppf(0.975, 29) * np.std(np.arange(30.0), ddof=1) / math.sqrt(30)
    assert means.text() == f"noise 14.5({round(10 * half)}), bias 0"
    assert not means.enough


@pytest.mark.exhaustive
def test_a_study_stops_early_to_the_bits_of_a_shorter_one(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY.replace("runs = 6", "runs = 200") + "\n[study.stop]\nnoise = 0.2\n")
    study = read_study(path)
    stopped = run_study(study, engine="compiled", folder=tmp_path / "a")
    assert FEWEST * 2 <= stopped.planned_runs < 400
    assert not stopped.interrupted
    notes: list[str] = []
    again = run_study(
        study, engine="compiled", folder=tmp_path / "a", progress=lambda done, total, note: notes.append(note)
    )
    assert (again.digest, again.planned_runs) == (stopped.digest, stopped.planned_runs)
    assert notes[-1].startswith("noise ")
    shorter = run_study(study, runs=stopped.planned_runs // 2, engine="python")
    assert shorter.digest == stopped.digest
