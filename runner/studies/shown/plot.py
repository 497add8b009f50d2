"""Pictures of a study: measures as histograms and as fans of percentiles over the epochs; of its answers and sweeps."""

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from itertools import cycle
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from proofmass.blocks.declaration.shown_units import prefix
from proofmass.graphs.studies.ages import HOUR, YEAR, age_text
from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.counts import count
from proofmass.runner.output.pictures import (
    BLUE,
    COLOURS,
    INK,
    ORANGE,
    axis_label,
    literal,
    name_rows,
    room_for_ticks,
    save_figure,
    sheet,
)
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.influences import Influences
from proofmass.runner.studies.shown.points import parts, swept_parts
from proofmass.runner.studies.shown.sensitivities import Influence, Regression

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LIMIT = "limit"
MOST_COLUMNS = 4  # points of a sweep beside each other
LETTERS, SPACE = 110, 7  # of a row of a legend, and what an entry takes beside its own
MARKED = 24  # epochs up to which each has a dot
FAN = ((1.0, 99.0, 0.2), (10.0, 90.0, 0.3), (25.0, 75.0, 0.4))  # percentiles and their opacity
_PROVED = "proved within tolerances"
_WIDTH, _HEIGHT = 9.0, 3.1  # inches of a row of panels
_LETTERS = 16  # of a line below a panel of points
_BARS, _SCATTERS, _POINTS = 12, 2, 500  # of a tornado, drawn as points, and points
_LINES = 5  # factors whose shares are drawn over the age
_FEW = 2  # curves up to which the scatter of each is drawn

Points = Iterable[tuple[float, AnyArray, float]]  # of a curve: a place, the values of all runs there, their mean


class Aged(NamedTuple):
    """A fan over the epochs: of the values of a measure, or of its change since the epoch from which a limit counts."""

    measure: PlannedMeasure
    label: str
    limits: tuple[float, ...]
    first: int = 0
    change: bool = False

    def values(self, result: StudyResult) -> AnyArray:
        """Return the values by run and epoch from the first on; changes in percent of what each sensor had there."""
        values = whole(result, self.measure.name)[:, self.first :]
        if not self.change:
            return values
        known = values[values[:, 0] != 0.0]
        return np.asarray(100.0 * (known - known[:, :1]) / np.abs(known[:, :1]))


def aged(result: StudyResult, measure: PlannedMeasure) -> list[Aged]:
    """Return the fans of a measure: that of its values, and of its change where limited."""
    limit = result.study.limits.get(measure.name, Limit())
    fans = [Aged(measure, label_of(measure), (limit.at_least, limit.at_most))]
    if math.isfinite(limit.change):
        first, percent = limit.counted(result.study.epochs), 100.0 * limit.change
        since = f" since {age_text(result.study.epochs[first])}" if first else ""
        fans.append(Aged(measure, f"change of {measure.name}{since} [%]", (-percent, percent), first, change=True))
    return fans


def whole(result: StudyResult, name: str) -> AnyArray:
    """Return the values of a measure of the runs that have it at every epoch."""
    return result[name][np.isfinite(result[name]).all(axis=1)]


def label_of(measure: PlannedMeasure) -> str:
    """Name and unit of a measure for an axis."""
    return axis_label(measure.name, measure.unit)


def near(limits: Sequence[float], values: AnyArray) -> list[float]:
    """Return the limits that lie near the values; others would only squeeze the picture."""
    known = values[np.isfinite(values)]
    if not known.size:
        return []
    low, high, span = known.min(), known.max(), np.ptp(known)
    return [limit for limit in limits if math.isfinite(limit) and low - span <= limit <= high + span]


def plot_study(result: StudyResult) -> "Figure":
    """A figure with a panel per measure, in its unit, limits dashed."""
    result = as_shown(result)
    study, columns = result.study, swept_parts(result)
    columns = columns if len(columns) <= MOST_COLUMNS else {"": result}
    fans = [fan for measure in result.measures for fan in aged(result, measure)] if len(study.epochs) > 1 else []
    rows = len(fans or result.measures)
    yields = result.yields() if study.points == 1 else {}
    good = f", yield {100 * yields['all limits']:.2f} %" if yields else ""
    title = f"{study.graph.name}: {count(len(result.numbers), 'run')}{good}"
    with sheet(max(8.0, 5.0 * len(columns)), 1.2 + 2.6 * rows, title) as figure:
        panels = figure.subplots(rows, len(columns), squeeze=False)
        for (name, part), column in zip(columns.items(), panels.T, strict=True):
            column[0].set_title(name, fontsize=10)
            for panel, fan in zip(column, fans, strict=False):
                _fans(panel, part, fan)
            for panel, measure in zip(column, () if fans else result.measures, strict=False):
                _histograms(panel, part, measure)
        _legend(figure)
    return figure


def save_study_plots(result: StudyResult, path: Path, endings: Sequence[str]) -> list[str]:
    """Write the picture in several formats, laid out once; returns the names of the files."""
    figure, names = plot_study(result), []
    for ending in endings:
        names.append(save_figure(figure, path.with_suffix(f".{ending}")).name)
        figure.set_layout_engine("none")
    return names


def plot_distribution(result: StudyResult, measure: PlannedMeasure, proved: Sequence[float] = ()) -> "Figure":
    """Histograms of a measure at the first and the last epoch, and beside them the fans over the epochs.

    What is `proved` of it for every sensor is a line in the histograms.
    """
    fans = aged(result, measure) if len(result.study.epochs) > 1 else []
    with sheet(_WIDTH, _HEIGHT) as figure:
        first, *others = figure.subplots(1, 1 + len(fans), squeeze=False)[0]
        _histograms(first, result, measure)
        for bound in near(proved, result[measure.name]):
            first.axvline(bound, color=INK, linestyle="-.", label=_PROVED)
        for panel, fan in zip(others, fans, strict=True):
            _fans(panel, result, fan)
        _legend(figure)
    return figure


def plot_influences(influences: Influences) -> "Figure":
    """Bars of the effects of one standard deviation, and the measure by its strongest factors."""
    label, strongest = label_of(influences.measure), influences.regression.influences[:_BARS]
    scattered = [influence.parameters[0] for influence in strongest[:_SCATTERS]]
    with sheet(_WIDTH, max(_HEIGHT, 0.9 + 0.22 * len(strongest))) as figure:
        places = figure.add_gridspec(1, 1 + len(scattered), width_ratios=[1.6, *[1.0] * len(scattered)])
        tornado, others = figure.add_subplot(places[0]), list["Axes"]()
        for place in range(len(scattered)):
            others.append(figure.add_subplot(places[1 + place], sharey=others[0] if others else None))
        effects = [influence.effect for influence in strongest]
        colours = [BLUE if effect >= 0.0 else ORANGE for effect in effects]
        halves = [influence.effect_half for influence in strongest]
        tornado.barh(range(len(effects)), effects, xerr=halves, color=colours, ecolor=INK, height=0.7)
        tornado.axvline(0.0, color=INK, linewidth=0.8)
        name_rows(tornado, [_short(influence) for influence in strongest])
        tornado.set_xlabel(f"{label} for one standard deviation")
        for panel, name in zip(others, scattered, strict=True):
            x, y = influences.factors.columns[name][:_POINTS], influences.values[:_POINTS]
            factor, unit = _finer(influences.factors.units[name], float(np.abs(x).max()))
            panel.plot(factor * x, y, "o", color=BLUE, alpha=0.6, markersize=3, markeredgewidth=0.0)
            panel.set_xlabel(axis_label(_in_lines(name), unit))
            panel.tick_params(labelleft=panel is others[0])
        if others:
            others[0].set_ylabel(label)
        figure.draw_without_rendering()  # only then are the widths of the panels known
        for panel in others:
            room_for_ticks(panel)
    return figure


def plot_shares(ages: Sequence[float], regressions: Sequence[Regression]) -> "Figure":
    """The shares of the variance of a measure that its strongest factors explain, over the age."""
    size, unit = _scale(ages)
    total = defaultdict[str, float](float)
    for influence in (influence for regression in regressions for influence in regression.influences):
        total[influence.parameter] += influence.share
    with sheet(_WIDTH, _HEIGHT) as figure:
        panel, at = figure.subplots(), np.array(ages) / size
        for factor, colour in zip(sorted(total, key=lambda factor: -total[factor])[:_LINES], COLOURS, strict=False):
            shares = [100.0 * sum(i.share for i in r.influences if i.parameter == factor) for r in regressions]
            panel.plot(at, shares, color=colour, label=literal(factor))
        panel.plot(at, [100.0 * r.explained for r in regressions], "--", color=INK, label="all factors")
        panel.set(xlabel=f"age [{unit}]", ylabel="share of variance [%]")
        _legend(figure)
    return figure


def plot_lifetimes(lives: Lifetimes) -> "Figure":
    """The yield by age, and the survival with its band beside Weibull's law."""
    size, unit = _scale(lives.ages)
    at, shares, half = np.array(lives.ages) / size, 100.0 * lives.surviving, 100.0 * lives.band
    with sheet(_WIDTH, _HEIGHT) as figure:
        good, survival = figure.subplots(1, 2)
        low, high = (100.0 * np.array(row) for row in zip(*lives.good_intervals, strict=True))
        _band(good, at, low, high, "95 % at each age", alpha=0.25)
        good.plot(at, 100.0 * lives.good, color=BLUE, label="within limits")
        good.set_ylabel(literal(f"within {lives.limit} [%]"))
        low, high = np.maximum(shares - half, 0.0), np.minimum(shares + half, 100.0)
        _band(survival, at, low, high, "95 % at all ages together", alpha=0.12)
        survival.plot(at, shares, color=BLUE, label="never out of tolerance")
        survival.set_ylabel(literal(f"never out of {lives.limit} [%]"))
        if lives.law is not None:
            fine = np.linspace(0.0, lives.ages[-1], 60)
            survival.plot(fine / size, 100.0 * lives.law.survival(fine), "--", color=INK, label="Weibull's law")
        for panel in (good, survival):
            panel.set_xlabel(f"age [{unit}]")
        _legend(figure)
    return figure


def plot_curves(curves: Mapping[str, Points], x_label: str, measure: PlannedMeasure) -> "Figure":
    """A measure at the last age over a parameter: the mean of the sensors, and of few curves 98 % of them."""
    known = [(name, [point for point in points if len(point[1])]) for name, points in curves.items()]
    known = [(name, points) for name, points in known if points]
    with sheet(_WIDTH, _HEIGHT) as figure:
        panel = figure.subplots()
        for (name, points), colour in zip(known, cycle(COLOURS), strict=False):
            at, _, means = zip(*points, strict=True)
            if len(known) <= _FEW:
                low, high = np.transpose([np.percentile(column, (1.0, 99.0)) for _, column, _ in points])
                _band(panel, at, low, high, "" if name else "1 to 99 %", colour, alpha=0.15)
            panel.plot(at, means, color=colour, label=literal(name) or "mean")
        panel.set(xlabel=x_label, ylabel=label_of(measure))
        _legend(figure)
    return figure


def _in_lines(name: str) -> str:
    """Return the name of a factor in lines that stand below a narrow panel."""
    first, of, rest = name.rpartition("change of ")
    block, dot, parameter = rest.rpartition(".")
    return first + of.replace("of ", "of\n") + (f"{block}.\n{parameter}" if dot and len(rest) > _LETTERS else rest)


def _finer(unit: str, largest: float) -> tuple[float, str]:
    """Return a factor and a unit in which numbers up to `largest` need no power of ten."""
    if unit in ("", "1"):
        return (1e6, "ppm") if largest < 1e-3 else (1.0, unit)
    return prefix(unit, largest)


def _legend(figure: "Figure") -> None:
    """Draw one legend for all panels, below them so that it hides nothing."""
    found = [panel.get_legend_handles_labels() for panel in figure.axes]
    entries = {label: handle for handles, labels in found for handle, label in zip(handles, labels, strict=True)}
    if len(entries) > 1 or LIMIT in entries or _PROVED in entries:
        widths = [len(label) + SPACE for label in entries]
        columns = len(entries) if sum(widths) <= LETTERS else max(1, LETTERS // max(widths))
        figure.legend(entries.values(), entries, loc="outside lower center", ncols=columns, fontsize=8)


def _band(panel: Any, at: Any, low: AnyArray, high: AnyArray, label: str, colour: str = BLUE, *, alpha: float) -> None:
    panel.fill_between(at, low, high, color=colour, alpha=alpha, linewidth=0.0, label=label)


def _fans(panel: Any, result: StudyResult, fan: Aged) -> None:
    """The fan of a measure over the epochs, or one for each point of the study."""
    told_apart, ages = parts(result), result.study.epochs[fan.first :]
    for color, (name, part) in zip(cycle(COLOURS), told_apart.items(), strict=False):
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
    size, unit = _scale(ages)
    at, through = np.array(ages) / size, 1.0
    for low, high, strength in FAN:
        below, above = np.percentile(values, (low, high), axis=0)
        _band(panel, at, below, above, "", color, alpha=strength)
        through *= 1.0 - strength  # bands add up: the legend shows the last as it looks
        panel.fill_between([], [], color=color, alpha=1.0 - through, linewidth=0.0, label=edges.format(low, high))
    marker = "o" if len(at) <= MARKED else ""
    panel.plot(at, np.median(values, axis=0), color=ink, marker=marker, markersize=3, label=median)
    panel.set_xlabel(f"age [{unit}]")


def _histograms(panel: Any, result: StudyResult, measure: PlannedMeasure) -> None:
    """The first and the last epoch, or the last one of each point of the study."""
    told_apart, epochs = parts(result), result.study.epochs
    youngest, oldest = age_text(epochs[0]), age_text(epochs[-1])
    several, ages = len(told_apart) > 1, len(epochs) > 1
    for color, (name, part) in zip(cycle(COLOURS), told_apart.items(), strict=False):
        values = whole(part, measure.name)
        if not len(values):
            continue
        edges = np.histogram_bin_edges(values[:, -1] if several else values[:, [0, -1][: len(epochs)]], bins="auto")
        if several:
            _bars(panel, values[:, -1], edges, name, color=color, alpha=0.6, fill=True)
            continue
        _bars(panel, values[:, 0], edges, youngest if ages else "", color=color, alpha=0.8, fill=True)
        if ages:
            _bars(panel, values[:, -1], edges, oldest, color=INK)
    panel.set(xlabel=label_of(measure) + (f" at {oldest}" if several and ages else ""), ylabel="runs")
    if len(constant := set(whole(result, measure.name).ravel())) == 1:
        panel.set_xticks([*constant])
    room_for_ticks(panel)
    limit = result.study.limits.get(measure.name, Limit())
    _limits(panel.axvline, near((limit.at_least, limit.at_most), result[measure.name]))


def _bars(panel: Any, values: AnyArray, edges: AnyArray, label: str, **style: Any) -> None:
    panel.stairs(np.histogram(values, edges)[0], edges, label=label, **style)


def _limits(draw: Any, limits: Sequence[float]) -> None:
    for limit in limits:
        draw(limit, color=ORANGE, linestyle="--", label=LIMIT)


def _scale(ages: Sequence[float]) -> tuple[float, str]:
    return (YEAR, "years") if ages[-1] >= YEAR else (HOUR, "hours")


def _short(influence: Influence) -> str:
    """Return the first parameter of a factor, and how many move with it."""
    first, *others = influence.parameters
    return f"{first} and {len(others)} more" if others else first
