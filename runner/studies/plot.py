"""Picture of a study: each measure as a histogram, or as a fan of percentiles over its epochs."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.runner.output.plot import BLUE, INK, ORANGE, PAPER, STYLE, save_figure
from proofmass.runner.studies.ages import HOUR, YEAR, age_text
from proofmass.runner.studies.result import StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
            values = result[measure.name]
            values = values[np.isfinite(values).all(axis=1)]
            if not len(values):
                continue
            if len(result.study.epochs) > 1:
                _fan(panel, result.study.epochs, values)
                panel.set_ylabel(measure.name + unit)
            else:
                panel.hist(values[:, 0], bins="auto", color=BLUE)
                panel.set_xlabel(measure.name + unit)
                panel.set_ylabel("runs")
            _limits(panel.axhline if len(result.study.epochs) > 1 else panel.axvline, result, measure.name)
        yields = result.yields()
        good = f", yield {100 * yields['all limits']:.2f} %" if yields else ""
        figure.suptitle(f"{result.study.graph.name}: {len(result.numbers):,} runs{good}".replace("$", r"\$"))
    return figure


def plot_measure(result: StudyResult, name: str) -> "Figure":
    """One measure: histograms at the first and the last epoch, and beside them its fan over the epochs."""
    import matplotlib
    from matplotlib.figure import Figure

    epochs, measure = result.study.epochs, next(m for m in result.measures if m.name == name)
    values = result[name][np.isfinite(result[name]).all(axis=1)]
    label = name + (f" [{measure.unit}]" if measure.unit != "1" else "")
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(9.0, 3.2), facecolor=PAPER, layout="constrained")
        panels = figure.subplots(1, 1 if len(epochs) < 2 else 2, squeeze=False)[0]
        if len(values):
            _histograms(panels[0], values, epochs)
            _limits(panels[0].axvline, result, name)
        if len(values) and len(epochs) > 1:
            _fan(panels[1], epochs, values)
            _limits(panels[1].axhline, result, name)
            panels[1].set_ylabel(label)
        panels[0].set_xlabel(label)
        panels[0].set_ylabel("runs")
    return figure


def save_study_plot(result: StudyResult, path: str | Path) -> Path:
    """Write the picture; its form follows from the ending."""
    return save_figure(plot_study(result), path)


def _fan(panel: Any, ages: tuple[float, ...], values: Any) -> None:
    size, unit = (YEAR, "years") if ages[-1] >= YEAR else (HOUR, "hours")
    at = np.array(ages) / size
    for low, high, strength in FAN:
        edges = np.percentile(values, (low, high), axis=0)
        panel.fill_between(at, *edges, color=BLUE, alpha=strength, linewidth=0.0, label=f"{low:g} to {high:g} %")
    panel.plot(at, np.median(values, axis=0), color=INK, marker="o", markersize=3, label="median")
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
