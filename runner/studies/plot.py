"""Picture of a study: each measure as a histogram, or as a fan of percentiles over its epochs."""

from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.runner.engine.result import Array
from proofmass.runner.output.plot import BLUE, INK, ORANGE, PAPER, STYLE, save_figure
from proofmass.runner.studies.ages import HOUR, YEAR, age_text, recalibration_text
from proofmass.runner.studies.result import StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = (BLUE, ORANGE, "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # of Okabe and Ito
MARKED = 24  # epochs up to which each has a dot
FAN = ((1.0, 99.0, 0.2), (10.0, 90.0, 0.3), (25.0, 75.0, 0.4))  # percentiles and how strongly they are drawn


def plot_study(result: StudyResult) -> "Figure":
    """A figure with a panel per measure, in its unit, limits dashed."""
    import matplotlib
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 1.2 + 2.6 * len(result.measures)), facecolor=PAPER, layout="constrained")
        panels = figure.subplots(len(result.measures), squeeze=False)[:, 0]
        for panel, measure in zip(panels, result.measures, strict=True):
            unit = f" [{measure.unit}]" if measure.unit != "1" else ""
            values = _whole(result, measure.name)
            if not len(values):
                continue
            if len(result.study.epochs) > 1:
                _fans(panel, result, measure.name)
                panel.set_ylabel(measure.name + unit)
            else:
                panel.hist(values[:, 0], bins="auto", color=BLUE)
                panel.set_xlabel(measure.name + unit)
                panel.set_ylabel("runs")
            _limits(panel.axhline if len(result.study.epochs) > 1 else panel.axvline, result, measure.name)
        yields = result.yields() if len(result.study.recalibration.every) == 1 else {}
        good = f", yield {100 * yields['all limits']:.2f} %" if yields else ""
        figure.suptitle(f"{result.study.graph.name}: {len(result.numbers):,} runs{good}".replace("$", r"\$"))
    return figure


def plot_measure(result: StudyResult, name: str) -> "Figure":
    """One measure: histograms at the first and the last epoch, and beside them its fan over the epochs."""
    import matplotlib
    from matplotlib.figure import Figure

    epochs, measure = result.study.epochs, next(m for m in result.measures if m.name == name)
    values = _whole(result, name)
    label = name + (f" [{measure.unit}]" if measure.unit != "1" else "")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.2), facecolor=PAPER, layout="constrained")
        panels = figure.subplots(1, 1 if len(epochs) < 2 else 2, squeeze=False)[0]
        if len(values):
            _histograms(panels[0], values, epochs)
            _limits(panels[0].axvline, result, name)
        if len(values) and len(epochs) > 1:
            _fans(panels[1], result, name)
            _limits(panels[1].axhline, result, name)
            panels[1].set_ylabel(label)
        panels[0].set_xlabel(label)
        panels[0].set_ylabel("runs")
    return figure


def save_study_plot(result: StudyResult, path: str | Path) -> Path:
    """Write the picture; its form follows from the ending."""
    return save_figure(plot_study(result), path)


def _whole(result: StudyResult, name: str) -> Array:
    """Values of a measure of the runs that have it at every epoch."""
    return result[name][np.isfinite(result[name]).all(axis=1)]


def _fans(panel: Any, result: StudyResult, name: str) -> None:
    """The fan of a measure over the epochs, or one for each interval between calibrations."""
    parts = result.by_recalibration()
    for color, (every, part) in zip(cycle(COLORS), parts.items(), strict=False):
        values = _whole(part, name)
        if not len(values):
            continue
        if len(parts) == 1:
            _fan(panel, result.study.epochs, values, color, INK, "median", "{:g} to {:g} %")
        else:
            _fan(panel, result.study.epochs, values, color, color, recalibration_text(every), "")


def _fan(panel: Any, ages: tuple[float, ...], values: Any, color: str, ink: str, median: str, edges: str) -> None:
    size, unit = (YEAR, "years") if ages[-1] >= YEAR else (HOUR, "hours")
    at = np.array(ages) / size
    for low, high, strength in FAN:
        rows = np.percentile(values, (low, high), axis=0)
        panel.fill_between(at, *rows, color=color, alpha=strength, linewidth=0.0, label=edges.format(low, high))
    marker = "o" if len(at) <= MARKED else ""
    panel.plot(at, np.median(values, axis=0), color=ink, marker=marker, markersize=3, label=median)
    panel.set_xlabel(f"age [{unit}]")
    panel.legend(fontsize=8)


def _histograms(panel: Any, values: Any, epochs: tuple[float, ...]) -> None:
    edges = np.histogram_bin_edges(values[:, [0, -1]], bins="auto")
    panel.hist(values[:, 0], bins=edges, color=BLUE, alpha=0.8, label=age_text(epochs[0]))
    if len(epochs) > 1:
        panel.hist(values[:, -1], bins=edges, histtype="step", color=INK, label=age_text(epochs[-1]))
        panel.legend(fontsize=8)


def _limits(draw: Any, result: StudyResult, name: str) -> None:
    """The limits that lie near the values; those further away would only squeeze the picture."""
    limit, values = result.study.limits.get(name), result[name][np.isfinite(result[name])]
    for edge in (limit.at_least, limit.at_most) if limit else ():
        if np.isfinite(edge) and values.min() - np.ptp(values) <= edge <= values.max() + np.ptp(values):
            draw(edge, color=ORANGE, linestyle="--")
