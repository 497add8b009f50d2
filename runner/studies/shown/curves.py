"""Curves of a measure over what is swept: by the points of a study, and by its variants, each compiled anew."""

from collections.abc import Mapping

import numpy as np

from proofmass.graphs.studies.ages import age_text
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.counts import is_number
from proofmass.runner.output.page import picture
from proofmass.runner.output.pictures import axis_label
from proofmass.runner.output.sweeps import axis_of
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.plot import plot_curves

_IS, _AND = " = ", ", "  # as `variants_of` names variants of a sweep
Curves = dict[str, list[tuple[float, AnyArray]]]


def sweep_picture(result: StudyResult, measure: PlannedMeasure, name: str) -> str:
    """Return a measure against a swept parameter as SVG, a curve for each choice of others."""
    study = result.study
    values, curves = result[measure.name][:, -1], Curves()
    for point in range(study.points):
        swept = study.point(point)
        others = [f"{study.name_of(other)} = {value:g}" for other, value in swept.items() if other != name]
        if len(study.recalibration.every) > 1:
            every = study.recalibrated_every(point)
            others.append(f"recalibrated {'never' if every == np.inf else age_text(every)}")
        column = values[result.numbers % study.points == point]
        curves.setdefault(_AND.join(others), []).append((swept[name], column))
    return _drawn(curves, study.name_of(name), study.unit_of(name), measure)


def variant_pictures(results: Mapping[str, StudyResult]) -> list[tuple[str, str]]:
    """Return for each parameter of several values a title, and pictures of measures as SVG."""
    results = {name: as_shown(result) for name, result in results.items()}
    swept = {name: _swept(name) for name in results}
    keys = dict.fromkeys(key for values in swept.values() for key in values)
    several = (key for key in keys if len({values.get(key) for values in swept.values()} - {None}) > 1)
    return [(f"over {key}", _over(results, swept, key)) for key in several]


def _over(results: Mapping[str, StudyResult], swept: Mapping[str, Mapping[str, str]], key: str) -> str:
    values = list(dict.fromkeys(values[key] for values in swept.values() if key in values))
    places, unit = axis_of([float(value) if is_number(value) else value for value in values])
    at, pictures = dict(zip(values, places, strict=True)), []
    for measure in next(iter(results.values())).measures:
        curves = Curves()
        for name, result in results.items():
            if key in swept[name] and measure.name in result.values:
                others = _AND.join(part for part in name.split(_AND) if not part.startswith(f"{key}{_IS}"))
                curves.setdefault(others, []).append((at[swept[name][key]], result[measure.name][:, -1]))
        pictures.append(_drawn(curves, key, unit, measure))
    return "".join(pictures)


def _drawn(curves: Curves, name: str, unit: str, measure: PlannedMeasure) -> str:
    known = {
        label: [(x, column[np.isfinite(column)]) for x, column in sorted(points, key=lambda point: point[0])]
        for label, points in curves.items()
    }
    return picture(plot_curves(known, axis_label(name, unit), measure), f"{measure.name} over {name}")


def _swept(name: str) -> dict[str, str]:
    """Return the swept values in the name of a variant.

    >>> _swept("cheap, adc.bits = 12")
    {'adc.bits': '12'}
    """
    pairs = (part.partition(_IS) for part in name.split(_AND))
    return {key: value for key, equals, value in pairs if equals}
