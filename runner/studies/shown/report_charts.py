"""Charts of the report of a study: distributions, fans, influences, survival, curves over a sweep."""

from collections.abc import Sequence
from itertools import cycle

import numpy as np

from proofmass.blocks.declaration.shown_units import pretty
from proofmass.graphs.studies.ages import HOUR, YEAR, age_text
from proofmass.graphs.studies.study_tables import Limit
from proofmass.runner.output.charts import BLUE, COLOURS, INK, Panel, chart
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.lifetimes import Lifetimes
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.shown.aged import LIMIT, Aged, aged, label_of, near, whole
from proofmass.runner.studies.shown.influences import Influences
from proofmass.runner.studies.shown.plot import FAN
from proofmass.runner.studies.shown.points import parts
from proofmass.runner.studies.shown.sensitivities import Influence, Regression

_BARS = 12  # factors of a tornado
_SCATTERS = 2
_POINTS = 1000  # of a scatter plot
_LINES = 5  # factors whose shares are drawn over the age


def distribution_chart(result: StudyResult, measure: PlannedMeasure) -> str:
    """Return histograms at the first and the last epoch, and beside them the fans over the epochs."""
    panels = [_histograms(result, measure)]
    if len(result.study.epochs) > 1:
        panels += [_fans(result, fan) for fan in aged(result, measure)]
    return chart(panels, f"distribution of {measure.name}")


def influences_chart(influences: Influences) -> str:
    """Return bars of the effects of one standard deviation, and the measure against its strongest factors."""
    label = label_of(influences.measure)
    strongest = influences.regression.influences[:_BARS]
    tornado = Panel(f"{label} for one standard deviation", share=1.6)
    tornado.rows([_short(i) for i in strongest], [i.effect for i in strongest], [i.effect_half for i in strongest])
    panels = [tornado]
    for influence in strongest[:_SCATTERS]:
        first = influence.parameters[0]
        unit = pretty(influences.factors.units[first])
        panel = Panel(first + (f" [{unit}]" if unit != "1" else ""), "" if len(panels) > 1 else label)
        panel.points(influences.factors.columns[first][:_POINTS], influences.values[:_POINTS])
        panels.append(panel)
    return chart(panels, f"influences on {influences.measure.name}")


def shares_chart(ages: Sequence[float], regressions: Sequence[Regression], name: str) -> str:
    """Return the shares of the variance of a measure that its strongest factors explain, over the age."""
    size, unit = _scale(ages[-1])
    total = dict[str, float]()
    for regression in regressions:
        for influence in regression.influences:
            total[influence.parameter] = total.get(influence.parameter, 0.0) + influence.share
    panel = Panel(f"age [{unit}]", "share of variance [%]")
    for factor, colour in zip(sorted(total, key=lambda factor: -total[factor])[:_LINES], COLOURS, strict=False):
        shares = [100.0 * sum(i.share for i in r.influences if i.parameter == factor) for r in regressions]
        panel.line(np.array(ages) / size, shares, colour, factor)
    panel.line(np.array(ages) / size, [100.0 * r.explained for r in regressions], INK, "all factors", True)
    return chart([panel], f"what scatters {name} at each age")


def survival_chart(lives: Lifetimes) -> str:
    """Return the yield by age, and the survival with its band beside Weibull's law."""
    size, unit = _scale(lives.ages[-1])
    at = np.array(lives.ages) / size
    good = Panel(f"age [{unit}]", f"within {lives.limit} [%]")
    low, high = (100.0 * np.array(row) for row in zip(*lives.good_intervals, strict=True))
    good.band(at, low, high, BLUE, 0.25, "95 % at each age")
    good.line(at, 100.0 * lives.good, BLUE, "within limits")
    survival = Panel(f"age [{unit}]", f"never out of {lives.limit} [%]")
    shares = 100.0 * lives.surviving
    low, high = np.maximum(shares - 100.0 * lives.band, 0.0), np.minimum(shares + 100.0 * lives.band, 100.0)
    survival.band(at, low, high, BLUE, 0.12, "95 % at all ages together")
    survival.line(at, shares, BLUE, "never out of tolerance")
    if lives.law is not None:
        fine = np.linspace(0.0, lives.ages[-1], 60)
        survival.line(fine / size, 100.0 * lives.law.survival(fine), INK, "Weibull's law", dashed=True)
    return chart([good, survival], f"lifetimes of {lives.limit}")


def sweep_chart(result: StudyResult, measure: PlannedMeasure, name: str) -> str:
    """Return a measure against a swept parameter, at the last age: mean and percentiles of the sensors."""
    study, unit = result.study, pretty(result.study.unit_of(name))
    panel = Panel(study.name_of(name) + (f" [{unit}]" if unit != "1" else ""), label_of(measure))
    columns = [
        (values, text) for text, values in _curves(result, measure, name) if any(len(column) for _, column in values)
    ]
    for (points, text), colour in zip(columns, cycle(COLOURS), strict=False):
        known = [(x, column) for x, column in points if len(column)]
        at = [x for x, _ in known]
        if len(columns) <= 2:
            rows = np.array([np.percentile(column, (1.0, 99.0)) for _, column in known])
            panel.band(at, rows[:, 0], rows[:, 1], colour, 0.15, "1 to 99 %" if len(columns) == 1 else "")
        panel.line(at, [float(column.mean()) for _, column in known], colour, text or "mean")
    return chart([panel], f"{measure.name} over {study.name_of(name)}")


def _curves(result: StudyResult, measure: PlannedMeasure, name: str) -> list[tuple[str, list[tuple[float, Array]]]]:
    """Return for each combination of the other swept parameters the values at each value of one."""
    study = result.study
    values, curves = result[measure.name][:, -1], dict[str, list[tuple[float, Array]]]()
    for point in range(study.points):
        swept = study.point(point)
        others = ", ".join(f"{study.name_of(other)} = {value:g}" for other, value in swept.items() if other != name)
        if len(study.recalibration.every) > 1:
            every = study.recalibrated_every(point)
            others += f"{', ' if others else ''}recalibrated {'never' if every == np.inf else age_text(every)}"
        column = values[result.numbers % study.points == point]
        curves.setdefault(others, []).append((swept[name], column[np.isfinite(column)]))
    return [(text, sorted(points, key=lambda point: point[0])) for text, points in curves.items()]


def _fans(result: StudyResult, fan: Aged) -> Panel:
    """Return the fan of a measure over the epochs, or one for each point of the study."""
    told_apart, ages = parts(result), result.study.epochs[fan.first :]
    size, unit = _scale(ages[-1])
    panel, at = Panel(f"age [{unit}]", fan.label), np.array(ages) / size
    for colour, (name, part) in zip(cycle(COLOURS), told_apart.items(), strict=False):
        values = fan.values(part)
        if not len(values):
            continue
        alone = len(told_apart) == 1
        for low, high, strength in FAN:
            rows = np.percentile(values, (low, high), axis=0)
            panel.band(at, rows[0], rows[1], colour, strength, f"{low:g} to {high:g} %" if alone else "")
        panel.line(at, np.median(values, axis=0), INK if alone else colour, "median" if alone else name)
    for limit in near(fan.limits, fan.values(result)):
        panel.rule(limit, False, label=LIMIT)
    return panel


def _histograms(result: StudyResult, measure: PlannedMeasure) -> Panel:
    """Return the first and the last epoch, or the last one of each point of the study."""
    told_apart, epochs = parts(result), result.study.epochs
    youngest, oldest = age_text(epochs[0]), age_text(epochs[-1])
    several, aged = len(told_apart) > 1, len(epochs) > 1
    panel = Panel(label_of(measure) + (f" at {oldest}" if several and aged else ""), "runs", counts=True)
    for colour, (name, part) in zip(cycle(COLOURS), told_apart.items(), strict=False):
        values = whole(part, measure.name)
        if not len(values):
            continue
        edges = np.histogram_bin_edges(values[:, -1] if several else values[:, [0, -1][: len(epochs)]], bins="auto")
        if several:
            panel.bars(edges, np.histogram(values[:, -1], edges)[0], colour, name, opacity=0.5)
            continue
        panel.bars(edges, np.histogram(values[:, 0], edges)[0], colour, youngest if aged else "")
        if aged:
            panel.bars(edges, np.histogram(values[:, -1], edges)[0], INK, oldest, outline=True)
    limit = result.study.limits.get(measure.name, Limit())
    for edge in near((limit.at_least, limit.at_most), result[measure.name]):
        panel.rule(edge, True, label=LIMIT)
    return panel


def _scale(oldest: float) -> tuple[float, str]:
    return (YEAR, "years") if oldest >= YEAR else (HOUR, "hours")


def _short(influence: Influence) -> str:
    """Return the first parameter of a factor, and how many move with it."""
    first, *others = influence.parameters
    return f"{first} and {len(others)} more" if others else first
