"""Derivatives by named values: those by the parameters that follow from each, times the slopes of their formulas."""

from collections.abc import Collection, Mapping

from proofmass.graphs.model.dependence import Dependence


def slopes_by_values(dependence: Dependence, slopes: Mapping[str, float]) -> dict[str, float]:
    """Return the derivative by each value that moves a parameter with a derivative."""
    by_value = {}
    for value in dependence.numbers:
        terms = [slope * slopes[name] for name, slope in dependence.slopes(value).items() if name in slopes]
        if terms:
            by_value[value] = sum(terms)
    return by_value


def undefined_values(dependence: Dependence, undefined: Collection[str]) -> tuple[str, ...]:
    """Return the values from which a parameter follows that has no derivative."""
    return tuple(value for value in dependence.numbers if not dependence.slopes(value).keys().isdisjoint(undefined))
