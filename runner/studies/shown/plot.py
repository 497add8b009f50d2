"""Picture of a study: each measure as a histogram, or as fans of percentiles over its epochs; point by point."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.graphs.studies.ages import HOUR, YEAR, age_text
from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.output.counts import count
from proofmass.runner.output.plot import BLUE, INK, ORANGE, PAPER, STYLE, headed, save_figure
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.aged import LIMIT, Aged, aged, label_of, near, whole
from proofmass.runner.studies.shown.points import parts, swept_parts

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_COLUMNS = 4  # points of a sweep beside each other
LETTERS, SPACE = 110, 7  # of a row of a legend, and what an entry takes beside its own
COLORS = (BLUE, ORANGE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # of Okabe and Ito
MARKED = 24  # epochs up to which each has a dot
FAN = ((1.0, 99.0, 0.2), (10.0, 90.0, 0.3), (25.0, 75.0, 0.4))  # percentiles and how strongly they are drawn


def plot_study(result: StudyResult) -> "Figure":
    """A figure with a panel per measure, in its unit, limits dashed."""
    # start-up time: matplotlib takes 0.3 s, and most callers draw nothing
    import matplotlib
    from matplotlib.figure import Figure

    result = as_shown(result)
    study, columns = result.study, swept_parts(result)
    columns = columns if len(columns) <= MOST_COLUMNS else {"": result}
    with matplotlib.rc_context(STYLE):
        fans = [fan for measure in result.measures for fan in aged(result, measure)] if len(study.epochs) > 1 else []
        rows = len(fans or result.measures)
        size = max(8.0, 5.0 * len(columns)), 1.2 + 2.6 * rows
        figure = Figure(figsize=size, facecolor=PAPER, layout="constrained")
        panels = figure.subplots(rows, len(columns), squeeze=False)
        for (name, part), column in zip(columns.items(), panels.T, strict=True):
            column[0].set_title(name, fontsize=10)
            for panel, fan in zip(column, fans, strict=False):
                _fans(panel, part, fan)
            for panel, measure in zip(column, () if fans else result.measures, strict=False):
                _histograms(panel, part, measure)
        yields = result.yields() if study.points == 1 else {}
        good = f", yield {100 * yields['all limits']:.2f} %" if yields else ""
        headed(figure, f"{study.graph.name}: {count(len(result.numbers), 'run')}{good}")
        _legend(figure)
    return figure


def save_study_plots(result: StudyResult, path: Path, endings: Sequence[str]) -> list[str]:
    """Write the picture in several formats, laid out once; returns the names of the files."""
    figure, names = plot_study(result), []
    for ending in endings:
        names.append(save_figure(figure, path.with_suffix(f".{ending}")).name)
        figure.set_layout_engine("none")
    return names


def _legend(figure: "Figure") -> None:
    """Draw one legend for all panels, below them so that it hides nothing."""
    found = [panel.get_legend_handles_labels() for panel in figure.axes]
    entries = {label: handle for handles, labels in found for handle, label in zip(handles, labels, strict=True)}
    if len(entries) > 1 or LIMIT in entries:
        widths = [len(label) + SPACE for label in entries]
        columns = len(entries) if sum(widths) <= LETTERS else max(1, LETTERS // max(widths))
        figure.legend(entries.values(), entries, loc="outside lower center", ncols=columns, fontsize=8)


def _fans(panel: Any, result: StudyResult, fan: Aged) -> None:
    """The fan of a measure over the epochs, or one for each point of the study."""
    told_apart, ages = parts(result), result.study.epochs[fan.first :]
    for color, (name, part) in zip(cycle(COLORS), told_apart.items(), strict=False):
        values = fan.values(part)
        if not len(values):
            continue
        if len(told_apart) == 1:
            _fan(panel, ages, values, color, INK, "median", "{:g} to {:g} %")
        else:
            _fan(panel, ages, values, color, color, name, "")
    panel.set_ylabel(fan.label)
    _limits(panel.axhline, near(fan.limits, fan.values(result)))


def _fan(panel: Any, ages: tuple[float, ...], values: Any, color: str, ink: str, median: str, edges: str) -> None:
    size, unit = (YEAR, "years") if ages[-1] >= YEAR else (HOUR, "hours")
    at, through = np.array(ages) / size, 1.0
    for low, high, strength in FAN:
        rows = np.percentile(values, (low, high), axis=0)
        panel.fill_between(at, *rows, color=color, alpha=strength, linewidth=0.0)
        through *= 1.0 - strength  # bands lie above each other: the legend shows the last one as it looks
        panel.fill_between([], [], color=color, alpha=1.0 - through, linewidth=0.0, label=edges.format(low, high))
    marker = "o" if len(at) <= MARKED else ""
    panel.plot(at, np.median(values, axis=0), color=ink, marker=marker, markersize=3, label=median)
    panel.set_xlabel(f"age [{unit}]")


def _histograms(panel: Any, result: StudyResult, measure: PlannedMeasure) -> None:
    """The first and the last epoch, or the last one of each point of the study."""
    told_apart, epochs = parts(result), result.study.epochs
    youngest, oldest = age_text(epochs[0]), age_text(epochs[-1])
    for color, (name, part) in zip(cycle(COLORS), told_apart.items(), strict=False):
        values = whole(part, measure.name)
        if not len(values):
            continue
        edges = np.histogram_bin_edges(values[:, [0, -1][: len(epochs)]], bins="auto")
        if len(told_apart) > 1:
            panel.hist(values[:, -1], bins=edges, color=color, alpha=0.6, label=name)
            continue
        panel.hist(values[:, 0], bins=edges, color=color, alpha=0.8, label=youngest if len(epochs) > 1 else "")
        if len(epochs) > 1:
            panel.hist(values[:, -1], bins=edges, histtype="step", color=INK, label=oldest)
    at = f" at {oldest}" if len(told_apart) > 1 and len(epochs) > 1 else ""
    panel.set_xlabel(label_of(measure) + at)
    panel.set_ylabel("runs")
    panel.locator_params(axis="x", nbins=6)
    limit = result.study.limits.get(measure.name, Limit())
    _limits(panel.axvline, near((limit.at_least, limit.at_most), result[measure.name]))


def _limits(draw: Any, limits: Sequence[float]) -> None:
    for limit in limits:
        draw(limit, color=ORANGE, linestyle="--", label=LIMIT)
