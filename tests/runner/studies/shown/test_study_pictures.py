"""Pictures of a study: what is drawn stands where its numbers say."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.studies.study_reader import read_study_text
from proofmass.runner.studies.outcome.lifetimes import lifetimes
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.influences import StudyInfluences
from proofmass.runner.studies.shown.plot import (
    plot_curves,
    plot_distribution,
    plot_influences,
    plot_lifetimes,
    plot_shares,
)
from proofmass.runner.studies.shown.points import by_point
from proofmass.runner.studies.whole.study import run_study
from tests.by_hand.study_texts import STUDY

YEAR = 31557600.0
AGES = np.array([0.0, 3.6e6 / YEAR, 1.0])


@pytest.fixture(scope="module")
def one_point() -> StudyResult:
    both = run_study(read_study_text(STUDY), runs=60, engine="compiled")
    return as_shown(by_point(both)[0])


def line(panel: Any, label: str) -> tuple[Any, Any]:
    (found,) = [one for one in panel.lines if one.get_label() == label]
    return np.asarray(found.get_xdata(), float), np.asarray(found.get_ydata(), float)


@pytest.mark.exhaustive
def test_a_distribution_is_a_histogram_beside_its_fans(one_point: StudyResult) -> None:
    measure = next(m for m in one_point.measures if m.name == "bias")
    figure = plot_distribution(one_point, measure)
    histogram, fan, change = figure.axes
    young, old = histogram.patches
    for drawn, column in ((young, 0), (old, -1)):
        counts, edges, _ = drawn.get_data()  # type: ignore[attr-defined]
        values = one_point["bias"][:, column]
        assert counts.tolist() == [
            np.count_nonzero((values >= a) & ((values < b) | ((b == edges[-1]) & (values == b))))
            for a, b in pairwise(edges)
        ]
    assert (histogram.get_ylabel(), fan.get_ylabel(), change.get_ylabel()) == ("runs", "bias", "change of bias [%]")
    at, median = line(fan, "median")
    assert at == pytest.approx(AGES)
    assert median == pytest.approx(np.sort(one_point["bias"], axis=0)[29:31].mean(axis=0))
    widest = fan.collections[0].get_paths()[0].vertices[:, 1]
    assert widest.min() == pytest.approx(np.percentile(one_point["bias"], 1.0, axis=0).min())
    assert widest.max() == pytest.approx(np.percentile(one_point["bias"], 99.0, axis=0).max())
    assert [fan.get_xlabel(), change.get_xlabel()] == ["age [years]"] * 2


@pytest.mark.exhaustive
def test_rows_of_effects_stand_in_order(one_point: StudyResult) -> None:
    influences = StudyInfluences(one_point).by_measure(one_point)["bias"][-1]
    tornado, *scattered = plot_influences(influences).axes
    bars = [(bar.get_y(), bar.get_width()) for bar in tornado.patches]  # type: ignore[attr-defined]
    strongest = influences.regression.influences
    assert [width for _, width in bars] == pytest.approx([influence.effect for influence in strongest])
    assert tornado.get_ylim()[0] > tornado.get_ylim()[1], "the first row is on top"
    assert all(above < below for (above, _), (below, _) in pairwise(bars))
    assert [label.get_text() for label in tornado.get_yticklabels()] == [i.parameter for i in strongest]
    for panel, influence in zip(scattered, strongest, strict=False):
        (dots,) = panel.lines
        size = {"[ppm]": 1e-6, "[µV]": 1e-6}.get(panel.get_xlabel().split()[-1], 1.0)
        assert size * np.asarray(dots.get_xdata()) == pytest.approx(influences.factors.columns[influence.parameters[0]])
        assert dots.get_ydata() == pytest.approx(one_point["bias"][:, -1])


@pytest.mark.exhaustive
def test_shares_of_the_variance_over_the_age(one_point: StudyResult) -> None:
    tables = StudyInfluences(one_point).by_measure(one_point)["bias"]
    (panel,) = plot_shares([one_point.study.epochs[t.epoch] for t in tables], [t.regression for t in tables]).axes
    at, explained = line(panel, "all factors")
    parts = sum(line(panel, name)[1] for name in {i.parameter for t in tables for i in t.regression.influences})
    assert at.tolist() == [one_point.study.epochs[t.epoch] / YEAR for t in tables]
    assert parts == pytest.approx(explained), "the shares add up to what the regression explains"


@pytest.mark.exhaustive
def test_lifetimes(one_point: StudyResult) -> None:
    lives = next(lives for lives in lifetimes(one_point) if lives.limit == "bias")
    good, survival = plot_lifetimes(lives).axes
    bias = one_point["bias"]
    within = np.abs(bias - bias[:, :1]) <= 100e-6 * np.abs(bias[:, :1])
    at, drawn = line(good, "within limits")
    assert at == pytest.approx(AGES[-len(at) :])
    assert drawn == pytest.approx(100.0 * within[:, -len(at) :].mean(axis=0))
    never_out = np.logical_and.accumulate(within, axis=1).mean(axis=0)
    assert line(survival, "never out of tolerance")[1] == pytest.approx(100.0 * never_out[-len(at) :])
    assert survival.get_ylabel() == "never out of bias [%]"


@pytest.mark.exhaustive
def test_curves_have_means_and_few_of_them_bands(one_point: StudyResult) -> None:
    measure, rng = one_point.measures[0], np.random.default_rng(3)
    columns = [rng.normal(x, 1.0, 200) for x in range(3)]
    points = [(float(x), column, column.sum() / 200) for x, column in enumerate(columns)]
    curves = {"a": [*points, (3.0, np.array([]), np.nan)], "nothing": [(0.0, np.array([]), np.nan)]}
    (panel,) = plot_curves(curves, "width [m]", measure).axes
    at, means = line(panel, "a")
    assert (at.tolist(), panel.get_xlabel()) == ([0.0, 1.0, 2.0], "width [m]")
    assert means == pytest.approx([column.sum() / 200 for column in columns])
    (band,) = panel.collections
    assert band.get_paths()[0].vertices[:, 1].max() == pytest.approx(np.percentile(points[-1][1], 99.0))
    (many,) = plot_curves(dict.fromkeys("abc", points), "width [m]", measure).axes
    assert not many.collections


@pytest.mark.exhaustive("seed")
@pytest.mark.parametrize("name", ["change of reference.value", "accelerometer.sensor.mass", "seed"])
def test_names_below_points_end_within_the_picture(name: str, one_point: StudyResult) -> None:
    influences = StudyInfluences(one_point).by_measure(one_point)["bias"][-1]
    first, *others = influences.regression.influences
    old, factors = first.parameters[0], influences.factors
    columns, units = {**factors.columns, name: factors.columns[old]}, {**factors.units, name: factors.units[old]}
    renamed = replace(influences.regression, influences=(replace(first, parameters=(name,)), *others))
    figure = plot_influences(
        replace(influences, factors=replace(factors, columns=columns, units=units), regression=renamed)
    )
    figure.draw_without_rendering()
    whole = figure.bbox
    for panel in figure.axes:
        label = panel.xaxis.label.get_window_extent()
        assert label.x0 >= whole.x0
        assert label.x1 <= whole.x1
    labels = [panel.xaxis.label.get_window_extent() for panel in figure.axes]
    assert all(left.x1 < right.x0 for left, right in pairwise(labels))
    for panel in figure.axes[1:]:
        ticks = [one.get_window_extent() for one in panel.get_xticklabels() if one.get_text()]
        assert all(left.x1 < right.x0 for left, right in pairwise(ticks))
