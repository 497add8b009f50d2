"""Curves over what variants of a study differ by: a measure against a parameter for which each is compiled anew."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle

import numpy as np

from proofmass.runner.output.charts import COLOURS, Panel, chart
from proofmass.runner.output.sweeps import axis_of
from proofmass.runner.run.result import Array
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.aged import label_of

_IS, _AND = " = ", ", "  # as `variants_of` names variants of a sweep
_FEW = 2  # curves, below which scatter is drawn


def variant_charts(results: Mapping[str, StudyResult]) -> list[tuple[str, str]]:
    """Return a chart of all measures for each swept parameter that has several values, with a title."""
    results = {name: as_shown(result) for name, result in results.items()}
    swept = {name: _swept(name) for name in results}
    keys = dict.fromkeys(key for values in swept.values() for key in values)
    charts = []
    for key in keys:
        if len({values.get(key) for values in swept.values()} - {None}) > 1:
            panels = list(_panels(results, swept, key))
            charts.append((f"over {key}", "".join(chart([panel], f"{title} over {key}") for title, panel in panels)))
    return charts


def _swept(name: str) -> dict[str, str]:
    """Return the swept values in the name of a variant.

    >>> _swept("cheap, adc.bits = 12")
    {'adc.bits': '12'}
    """
    pairs = (part.partition(_IS) for part in name.split(_AND))
    return {key: value for key, equals, value in pairs if equals}


def _panels(
    results: Mapping[str, StudyResult], swept: Mapping[str, Mapping[str, str]], key: str
) -> Iterator[tuple[str, Panel]]:
    values = list(dict.fromkeys(values[key] for values in swept.values() if key in values))
    places, unit = axis_of([float(value) if _is_number(value) else value for value in values])
    at = dict(zip(values, places, strict=True))
    curves: dict[str, list[tuple[float, StudyResult]]] = {}
    for name, result in results.items():
        if key in swept[name]:
            others = _AND.join(part for part in name.split(_AND) if not part.startswith(f"{key}{_IS}"))
            curves.setdefault(others, []).append((at[swept[name][key]], result))
    for measure in next(iter(results.values())).measures:
        panel = Panel(key + (f" [{unit}]" if unit else ""), label_of(measure))
        for (label, points), colour in zip(curves.items(), cycle(COLOURS), strict=False):
            _draw(panel, sorted(points, key=lambda p: p[0]), measure.name, colour, label, len(curves) <= _FEW)
        yield measure.name, panel


def _draw(
    panel: Panel, points: Sequence[tuple[float, StudyResult]], measure: str, colour: str, label: str, scatter: bool
) -> None:
    """Draw the mean at the last age, and if wished what 98 % of the sensors have."""
    known = [(x, _last(result, measure)) for x, result in points if measure in result.values]
    known = [(x, column) for x, column in known if len(column)]
    at = [x for x, _ in known]
    if scatter and known:
        rows = np.array([np.percentile(column, (1.0, 99.0)) for _, column in known])
        panel.band(at, rows[:, 0], rows[:, 1], colour, 0.15, "" if label else "1 to 99 %")
    panel.line(at, [float(column.mean()) for _, column in known], colour, label or "mean")


def _last(result: StudyResult, measure: str) -> Array:
    column = result[measure][:, -1]
    return np.asarray(column[np.isfinite(column)])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
