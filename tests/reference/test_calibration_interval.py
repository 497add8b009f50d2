"""Fifteen years of an accelerometer: the study's answers, against a model of its drift written by hand."""

import numpy as np
import pytest

from proofmass.graphs.files.library import library_file
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.outcome.lifetimes import lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.points import by_point
from proofmass.runner.studies.whole.study import run_study

LIMIT = 4500e-6
YEAR = 31557600.0


@pytest.fixture(scope="module")
def result() -> StudyResult:
    return run_study(read_study(library_file("calibration_interval_study.toml")), runs=300)


def gains(result: StudyResult) -> np.ndarray:  # type: ignore[type-arg]
    """Return the gain of each sensor at each age: element times amplifier over reference."""
    drawn = [result.study.drawn(run) for run in result.numbers.tolist()]
    names = "element.nominal", "amplifier.gain", "reference.nominal"
    e, a, r = (np.array([[at[name] for at in run] for run in drawn]) for name in names)
    return np.asarray(e * a / r)


@pytest.mark.exhaustive
@pytest.mark.parametrize("place", [0, 1])
def test_what_has_drifted_since_the_calibration_explains_the_errors(result: StudyResult, place: int) -> None:
    part = by_point(result)[place]
    tables = StudyInfluences(part).by_measure(part)
    for name, cause in (("scale_error", "amplifier.gain"), ("bias_error", "bias.value")):
        last = tables[name][-1]
        assert last.epoch == 15
        assert last.regression.explained > 0.95
        strongest = max(last.regression.influences, key=lambda influence: influence.share)
        assert f"change of {cause}" in strongest.parameters
        shares = [influence.share for influence in last.regression.influences]
        assert sum(shares) == pytest.approx(last.regression.explained, abs=1e-9)


@pytest.mark.exhaustive
@pytest.mark.parametrize(("place", "every"), [(0, 99), (1, 2)])
def test_the_scale_errors_are_those_of_a_model_by_hand(result: StudyResult, place: int, every: int) -> None:
    """gain now over gain at the last calibration; what is left is noise, some 30 ppm."""
    part = by_point(result)[place]
    gain = gains(part)
    for epoch in range(1, 16):
        last = (epoch - 1) // every * every
        expected = gain[:, epoch] / gain[:, last] - 1.0
        assert np.abs(part["scale_error"][:, epoch] - expected).max() < 3e-4
        assert np.corrcoef(part["scale_error"][:, epoch], expected)[0, 1] > 0.98


@pytest.mark.exhaustive
def test_when_one_per_cent_is_out_and_what_a_calibration_buys(result: StudyResult) -> None:
    never, often = ({life.limit: life for life in lifetimes(part)} for part in by_point(result))
    gain = gains(by_point(result)[0])
    inside = np.abs(gain[:, 1:] / gain[:, :1] - 1.0) <= LIMIT
    survival = np.logical_and.accumulate(inside, axis=1).mean(axis=0)
    assert never["scale_error"].surviving == pytest.approx(survival, abs=0.02)
    assert never["scale_error"].left_at(0.01) == (YEAR, 2.0 * YEAR)
    assert often["scale_error"].surviving[-1] > 0.9 > 0.2 > never["scale_error"].surviving[-1]
    assert often["all limits"].time_out < 0.1 * never["all limits"].time_out
