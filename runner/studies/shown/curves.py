"""Curves of a measure over what is swept: by the points of a study, and by its variants, each compiled anew."""

import re
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from proofmass.graphs.studies.ages import age_text
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.output.counts import is_number
from proofmass.runner.output.page import picture
from proofmass.runner.output.pictures import axis_label
from proofmass.runner.output.sweeps import axis_of, name_places
from proofmass.runner.plan.planned import PlannedMeasure
from proofmass.runner.studies.outcome.result import StudyResult, as_shown
from proofmass.runner.studies.shown.plot import plot_curves

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_IS, _AND = " = ", ", "  # as `variants_of` names variants of a sweep
_NEXT = re.compile(rf"{_AND}(?=[^,=]+{_IS})")
Curves = dict[str, list[tuple[float, AnyArray, float]]]


def sweep_picture(result: StudyResult, measure: PlannedMeasure, name: str) -> str:
    """Return a measure against a swept parameter as SVG, a curve for each choice of others."""
    study = result.study
    curves = Curves()
    for point in range(study.points):
        swept = study.point(point)
        others = [f"{study.name_of(other)} = {value:g}" for other, value in swept.items() if other != name]
        if len(study.recalibration.every) > 1:
            every = study.recalibrated_every(point)
            others.append(f"recalibrated {'never' if every == np.inf else age_text(every)}")
        there = result.some(result.numbers % study.points == point, study.points)
        curves.setdefault(_AND.join(others), []).append(_at(swept[name], there, measure))
    return _drawn(curves, study.name_of(name), study.unit_of(name), measure)


def variant_pictures(results: Mapping[str, StudyResult]) -> list[tuple[str, str]]:
    """Return for each parameter of several values a title, and pictures of measures as SVG."""
    results = {name: as_shown(result, results.values()) for name, result in results.items()}
    swept = {name: _swept(name) for name in results}
    keys = dict.fromkeys(key for values in swept.values() for key in values)
    several = (key for key in keys if len({values.get(key) for values in swept.values()} - {None}) > 1)
    return [(f"over {key}", _over(results, swept, key)) for key in several]


def _over(results: Mapping[str, StudyResult], swept: Mapping[str, Mapping[str, str]], key: str) -> str:
    texts = list(dict.fromkeys(values[key] for values in swept.values() if key in values))
    values = [float(text) if is_number(text) else text for text in texts]
    places, unit = axis_of(values)
    at, pictures = dict(zip(texts, places, strict=True)), []
    for measure in next(iter(results.values())).measures:
        curves = Curves()
        for name, result in results.items():
            if key in swept[name] and result.unit_of(measure.name) == measure.unit:
                others = _AND.join(part for part in _parts(name) if not part.startswith(f"{key}{_IS}"))
                curves.setdefault(others, []).append(_at(at[swept[name][key]], result, measure))
        pictures.append(_drawn(curves, key, unit, measure, lambda panel: name_places(panel, places, values, unit)))
    return "".join(pictures)


def _at(place: float, result: StudyResult, measure: PlannedMeasure) -> tuple[float, AnyArray, float]:
    """Return a point of a curve: values at the last age, and their mean, in which each sensor counts once."""
    values = result[measure.name][:, -1]
    means = result.of_draws(values)
    means = means[np.isfinite(means)]
    return place, values[np.isfinite(values)], float(means.mean()) if len(means) else np.nan


def _drawn(
    curves: Curves, name: str, unit: str, measure: PlannedMeasure, named: Callable[["Axes"], None] | None = None
) -> str:
    known = {label: sorted(points, key=lambda point: point[0]) for label, points in curves.items()}
    figure = plot_curves(known, axis_label(name, unit), measure)
    if named:
        named(figure.axes[0])
    return picture(figure, f"{measure.name} over {name}")


def _swept(name: str) -> dict[str, str]:
    """Return the swept values in the name of a variant.

    >>> _swept("cheap, adc.bits = 12")
    {'adc.bits': '12'}
    """
    pairs = (part.partition(_IS) for part in _parts(name))
    return {key: value for key, equals, value in pairs if equals}


def _parts(name: str) -> list[str]:
    """Return the name of a variant and its swept values, each with its key; a list has commas of its own.

    >>> _parts("cheap, fir.taps = [1, 2], adc.bits = 12")
    ['cheap', 'fir.taps = [1, 2]', 'adc.bits = 12']
    """
    return _NEXT.split(name)
