"""Picture of a study: each measure as a histogram, or as a fan of percentiles over its epochs."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.runner.output.plot import BLUE, INK, ORANGE, PAPER, STYLE, save_figure
from proofmass.runner.studies.result import YEAR, StudyResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FAN = ((1.0, 99.0, 0.2), (10.0, 90.0, 0.3), (25.0, 75.0, 0.4))  # percentiles and how strongly they are drawn
_HOUR = 3600.0


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
            _limits(panel, result, measure.name)
        yields = result.yields()
        good = f", yield {100 * yields['all limits']:.2f} %" if yields else ""
        figure.suptitle(f"{result.study.graph.name}: {len(result.numbers):,} runs{good}".replace("$", r"\$"))
    return figure


def save_study_plot(result: StudyResult, path: str | Path) -> Path:
    """Write the picture; its form follows from the ending."""
    return save_figure(plot_study(result), path)


def _fan(panel: Any, ages: tuple[float, ...], values: Any) -> None:
    size, unit = (YEAR, "years") if ages[-1] >= YEAR else (_HOUR, "hours")
    at = np.array(ages) / size
    for low, high, strength in FAN:
        edges = np.percentile(values, (low, high), axis=0)
        panel.fill_between(at, *edges, color=BLUE, alpha=strength, linewidth=0.0, label=f"{low:g} to {high:g} %")
    panel.plot(at, np.median(values, axis=0), color=INK, marker="o", markersize=3, label="median")
    panel.set_xlabel(f"age [{unit}]")
    panel.legend(fontsize=8)


def _limits(panel: Any, result: StudyResult, name: str) -> None:
    limit = result.study.limits.get(name)
    draw = panel.axhline if len(result.study.epochs) > 1 else panel.axvline
    for edge in (limit.at_least, limit.at_most) if limit else ():
        if np.isfinite(edge):
            draw(edge, color=ORANGE, linestyle="--")
