"""Fans, histograms and legends of a study, of values that were written by hand."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from proofmass.graphs.studies.ages import YEAR
from proofmass.runner.output.pictures import BLUE, GREEN, INK, ORANGE
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown import plot
from proofmass.runner.studies.shown.plot import (
    Aged,
    aged,
    near,
    plot_curves,
    plot_distribution,
    plot_influences,
    plot_study,
    save_study_plots,
    whole,
)
from tests.by_hand.study_results import AGED, SWEPT, measure, study_result
from tests.runner.studies.shown.test_plot import influence, influences

# 0, 1 ... 100, ten times that a year later, and minus it after three
LINE = np.arange(101.0)
THREE = np.column_stack([LINE, 10.0 * LINE, -LINE])
TWO = 'epochs = { ages = ["0 h", "1 year"] }\n'


def one_point(tables: str = AGED, values: Any = THREE, unit: str = "V") -> StudyResult:
    return study_result(tables, {"bias": values}, {"bias": unit})


@pytest.mark.parametrize(
    ("unit", "largest", "factor", "finer"),
    [
        ("", 0.999e-3, 1e6, "ppm"),
        ("1", 0.999e-3, 1e6, "ppm"),
        ("1", 1e-3, 1.0, "1"),
        ("", 5.0, 1.0, ""),
        ("V", 2e-5, 1e6, "µV"),
    ],
)
def test_small_numbers_have_finer_units(unit: str, largest: float, factor: float, finer: str) -> None:
    assert plot._finer(unit, largest) == (pytest.approx(factor), finer)


def test_ages_are_drawn_in_years_from_the_first_year_on() -> None:
    assert plot._scale([0.0, 3600.0, YEAR]) == (YEAR, "years")
    assert plot._scale([YEAR, 0.5 * YEAR]) == (3600.0, "hours")


def test_a_factor_of_several_parameters_has_the_name_of_the_first() -> None:
    assert plot._short(influence(1.0, "a")) == "a"
    assert plot._short(influence(1.0, "a", "b", "c")) == "a and 2 more"


def test_limits_far_from_the_values_are_not_drawn() -> None:
    """The values span 2 from 1 to 3: -1 and 5 are as near as they may be."""
    values = np.array([1.0, 3.0, np.nan, np.inf])
    limits = [-1.0, np.nextafter(-1.0, -2.0), 5.0, np.nextafter(5.0, 6.0), np.inf, -np.inf, 2.0]
    assert near(limits, values) == [-1.0, 5.0, 2.0]
    assert near(limits, np.array([np.nan])) == []


def test_runs_without_a_value_at_some_epoch_are_not_drawn() -> None:
    result = one_point(values=[[1, 2, 3], [4, np.nan, 6], [7, 8, 9]])
    assert whole(result, "bias").tolist() == [[1, 2, 3], [7, 8, 9]]


def test_a_limited_change_has_a_fan_from_the_age_on_that_counts() -> None:
    """In percent of the size at that age; a sensor of 0 there has none."""
    limits = 'limits = { bias = { at_most = 9, change = "5 %", from = "1 year" } }\n'
    result = one_point(AGED + limits, [[1, 2, 3], [1, -4, -5], [1, 0, 1]])
    (bias,) = result.measures
    values, change = aged(result, bias)
    assert values == Aged(bias, "bias [V]", (-np.inf, 9.0))
    assert change == Aged(bias, "change of bias since 1 year [%]", (-5.0, 5.0), 1, change=True)
    assert values.values(result).tolist() == [[1, 2, 3], [1, -4, -5], [1, 0, 1]]
    assert change.values(result).tolist() == [[0.0, 50.0], [0.0, -25.0]]
    other = replace(result, study=one_point(AGED + limits.replace(', from = "1 year"', "")).study)
    assert aged(other, bias)[1] == Aged(bias, "change of bias [%]", (-5.0, 5.0), 0, change=True)
    assert aged(one_point(), bias) == [Aged(bias, "bias [V]", (-np.inf, np.inf))]


def heights(band: Any, at: float) -> tuple[float, float]:
    corners = band.get_paths()[0].vertices
    column = corners[np.isclose(corners[:, 0], at), 1]
    return round(float(column.min()), 9), round(float(column.max()), 9)


def test_a_fan_of_percentiles_with_its_median() -> None:
    """Of 0, 1 ... 100 the percentiles are their numbers; the legend shows bands that lie above each other."""
    limits = "limits = { bias = { at_least = -120, at_most = 5000 } }\n"
    result = one_point(AGED + limits)
    panel: Any = Figure().subplots()
    (fan,) = aged(result, result.measures[0])
    plot._fans(panel, result, fan)
    drawn, shown = panel.collections[::2], panel.collections[1::2]
    for at, factor in ((0.0, 1.0), (1.0, 10.0)):
        assert [heights(band, at) for band in drawn] == [
            (factor * low, factor * high) for low, high in ((1.0, 99.0), (10.0, 90.0), (25.0, 75.0))
        ]
    assert [round(band.get_alpha(), 9) for band in drawn] == [0.2, 0.3, 0.4]
    assert [round(band.get_alpha(), 9) for band in shown] == [0.2, 0.44, 0.664]
    assert [band.get_label() for band in shown] == ["1 to 99 %", "10 to 90 %", "25 to 75 %"]
    median, limit = panel.lines
    assert median.get_xydata().tolist() == [[0.0, 50.0], [1.0, 500.0], [3.0, -50.0]]
    assert (median.get_label(), median.get_color(), median.get_marker()) == ("median", INK, "o")
    assert (limit.get_ydata()[0], limit.get_label(), limit.get_color()) == (-120.0, "limit", ORANGE)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("age [years]", "bias [V]")


@pytest.mark.parametrize(("epochs", "marker"), [(24, "o"), (25, "")])
def test_few_epochs_have_dots(epochs: int, marker: str) -> None:
    ages = f"epochs = {{ ages = {[*range(epochs)]} }}\n"
    panel: Any = Figure().subplots()
    result = one_point(ages, np.ones((2, epochs)))
    plot._fans(panel, result, aged(result, result.measures[0])[0])
    assert panel.lines[0].get_marker() == marker
    assert panel.get_xlabel() == "age [hours]"


def test_points_have_fans_of_their_own_colour() -> None:
    """The second point has no values at all."""
    sweep = 'sweep = { "filter.corner_frequency" = [1, 2, 3] }\n'
    rows = np.array([[1, 1, 1], [np.nan] * 3, [3, 3, 5], [1, 1, 1], [np.nan] * 3, [3, 3, 5]])
    result = one_point(AGED + sweep, rows)
    panel: Any = Figure().subplots()
    plot._fans(panel, result, aged(result, result.measures[0])[0])
    names = [f"filter.corner_frequency = {k} Hz" for k in (1, 3)]
    assert [(line.get_label(), line.get_color(), line.get_ydata()[-1]) for line in panel.lines] == [
        (names[0], BLUE, 1.0),
        (names[1], GREEN, 5.0),
    ]
    assert {band.get_label() for band in panel.collections} <= {""} | {f"_child{k}" for k in range(20)}


def bars(panel: Any) -> list[tuple[str, list[float], list[float]]]:
    """Name, counts and edges of each histogram."""
    found = [(patch.get_label(), patch.get_data()) for patch in panel.patches]
    return [(name, data.values.tolist(), np.round(data.edges, 9).tolist()) for name, data in found]


def test_histograms_of_the_first_and_the_last_epoch_have_the_same_edges() -> None:
    """Sturges and Freedman: of 0, 0, 0, 8 and 4, 4, 8, 8, four bars of 2."""
    result = one_point(AGED + "limits = { bias = { at_most = 9 } }\n", [[0, 9, 4], [0, 9, 4], [0, 9, 8], [8, 9, 8]])
    panel: Any = Figure().subplots()
    plot._histograms(panel, result, result.measures[0])
    (young, counts, edges), (old, others, same) = bars(panel)
    assert (young, old) == ("0 h", "3 years")
    assert edges == same == np.linspace(0.0, 8.0, len(edges)).tolist()
    assert (counts[0], sum(counts), others[0], others[-1], sum(others)) == (3, 4, 0, 2, 4)
    assert (panel.get_xlabel(), panel.get_ylabel()) == ("bias [V]", "runs")
    assert [(line.get_xdata()[0], line.get_label()) for line in panel.lines] == [(9.0, "limit")]
    assert [patch.get_fill() for patch in panel.patches] == [True, False]


def test_one_epoch_has_one_histogram_without_a_name_and_a_constant_its_number() -> None:
    panel: Any = Figure().subplots()
    result = one_point("", [[5.0], [5.0]])
    plot._histograms(panel, result, result.measures[0])
    ((name, counts, _),) = bars(panel)
    assert (name, sum(counts)) == ("", 2)
    assert list(panel.get_xticks()) == [5.0]
    other: Any = Figure().subplots()
    result = one_point("", [[5.0], [6.0]])
    plot._histograms(other, result, result.measures[0])
    assert len(other.get_xticks()) > 1


@pytest.mark.parametrize(("tables", "label"), [(TWO, "bias [V] at 1 year"), ("", "bias [V]")])
def test_points_have_histograms_of_the_last_epoch(tables: str, label: str) -> None:
    """The second point has no values."""
    sweep = 'sweep = { "filter.corner_frequency" = [1, 2, 3] }\n'
    last = np.array([0.0, np.nan, 10.0, 4.0, np.nan, 30.0])
    values = np.column_stack([last * 7.0, last]) if tables else last[:, None]
    panel: Any = Figure().subplots()
    result = one_point(tables + sweep, values)
    two = result.some(result.numbers % 3 != 1)
    few: Any = Figure().subplots()
    plot._histograms(few, two, two.measures[0])
    assert len(few.patches) == 2
    plot._histograms(panel, result, result.measures[0])
    found = [(name, edges[0], edges[-1], sum(counts)) for name, counts, edges in bars(panel)]
    names = [f"filter.corner_frequency = {k} Hz" for k in (1, 3)]
    assert found == [(names[0], 0.0, 4.0, 2), (names[1], 10.0, 30.0, 2)]
    assert panel.get_xlabel() == label
    assert [patch.get_fill() for patch in panel.patches] == [True, True]


def legend(labels: list[str]) -> tuple[list[str], int] | None:
    """Entries and columns of the legend of curves of these names."""
    figure = Figure()
    first, second = figure.subplots(1, 2)
    for panel, some in ((first, labels[:2]), (second, labels[1:])):
        for label in some:
            panel.plot([0.0], [0.0], label=label)
    plot._legend(figure)
    if not figure.legends:
        return None
    (drawn,) = figure.legends
    return [text.get_text() for text in drawn.get_texts()], drawn._ncols  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("labels", "entries"),
    [
        (["a"], None),
        (["limit"], (["limit"], 1)),
        (["proved within tolerances"], (["proved within tolerances"], 1)),
        (["a", "b", "c"], (["a", "b", "c"], 3)),
        (["a" * 48, "b" * 48], (["a" * 48, "b" * 48], 2)),  # 48 + 7 letters each: just 110
        (["a" * 49, "b" * 48], (["a" * 49, "b" * 48], 1)),
        (["a" * 49, "b" * 20, "c" * 20], (["a" * 49, "b" * 20, "c" * 20], 3)),
        (["a" * 30, "b" * 20, "c" * 20, "d" * 20], (["a" * 30, "b" * 20, "c" * 20, "d" * 20], 2)),
        (["a" * 200, "b"], (["a" * 200, "b"], 1)),
    ],
)
def test_a_legend_names_each_thing_once_in_as_many_columns_as_there_is_room(
    labels: list[str], entries: tuple[list[str], int] | None
) -> None:
    assert legend(labels) == entries


def test_a_study_has_a_column_for_each_point_and_a_row_for_each_measure() -> None:
    values = {"bias": np.arange(8.0)[:, None] + 1.0, "noise": np.ones((8, 1))}
    figure = plot_study(study_result(SWEPT, values, {"bias": "V"}))
    assert [panel.get_title() for panel in figure.axes[:2]] == [f"filter.corner_frequency = {k} Hz" for k in (100, 200)]
    assert [panel.get_xlabel() for panel in figure.axes] == ["bias [V]"] * 2 + ["noise"] * 2
    assert figure.get_suptitle() == "a converter that ages: 8 runs"


@pytest.mark.parametrize(("points", "columns"), [(4, 4), (5, 1)])
def test_of_many_points_there_is_one_column(points: int, columns: int) -> None:
    sweep = f'sweep = {{ "filter.corner_frequency" = {[*range(1, points + 1)]} }}\n'
    assert len(plot_study(one_point(sweep, np.ones((points, 1)))).axes) == columns


def test_the_title_has_the_yield_of_one_point() -> None:
    """2 of 3 runs are within all limits; fans of values and of a change each have a row."""
    limits = 'limits = { bias = { at_most = 9, change = "5 %" } }\n'
    figure = plot_study(one_point(TWO + limits, [[1, 1], [8, 8], [1, 2]]))
    assert figure.get_suptitle() == "a converter that ages: 3 runs, yield 66.67 %"
    assert [panel.get_ylabel() for panel in figure.axes] == ["bias [V]", "change of bias [%]"]
    assert plot_study(one_point("", [[1.0]])).get_suptitle() == "a converter that ages: 1 run"


def test_a_picture_is_laid_out_once_and_written_in_each_format(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    engines = []

    def save(figure: Figure, path: Path) -> Path:
        engines.append(isinstance(figure.get_layout_engine(), ConstrainedLayoutEngine))
        return path

    monkeypatch.setattr(plot, "save_figure", save)
    names = save_study_plots(one_point("", [[1.0]]), tmp_path / "study.toml", ("svg", "png", "pdf"))
    assert names == ["study.svg", "study.png", "study.pdf"]
    assert engines == [True, False, False]


def test_a_distribution_has_what_is_proved_and_fans() -> None:
    """At one age it is a histogram alone; a proved bound far away is left out."""
    alone = plot_distribution(one_point("", [[1.0], [3.0]]), measure("bias", "V"), [0.5, -9.0])
    assert len(alone.axes) == 1
    assert [(line.get_xdata()[0], line.get_label()) for line in alone.axes[0].lines] == [
        (0.5, "proved within tolerances")
    ]
    several = plot_distribution(one_point(TWO, THREE[:, :2]), measure("bias", "V"))
    assert [panel.get_ylabel() for panel in several.axes] == ["runs", "bias [V]"]
    assert [text.get_text() for text in several.legends[0].get_texts()][:2] == ["0 h", "1 year"]


def test_names_of_a_curve_without_others() -> None:
    (panel,) = plot_curves({"": [(1.0, LINE, 50.0)]}, "gain", measure("bias", "V")).axes
    assert panel.lines[0].get_label() == "mean"
    assert panel.collections[0].get_label() == "1 to 99 %"


def test_an_effect_of_nothing_is_drawn_as_one_upwards() -> None:
    up, nothing, down = (
        plot_influences(influences(influence(1.0, "a"), influence(0.0, "b"), influence(-1.0, "c"))).axes[0].patches
    )
    assert up.get_facecolor() == nothing.get_facecolor() != down.get_facecolor()
