"""Factors at a wire with which a loop is stable, found by following its slowest pole.

The growth g, the logarithm of the largest size of a pole, is continuous in the factor. Between two places it keeps its
sign if it changes by less than half of itself, at their middle too; any other step is halved, down to a thousandth.
Growths that rounding hides count neither as stable nor as unstable.
"""

from collections.abc import Callable, Iterator

from proofmass.runner.analysis.linearisation.period_map import Array
from proofmass.runner.analysis.margins.frequencies import zero_between

_QUIET = 0.5  # part of itself by which a growth may change in a step
_SHORTEST = 1e-3  # step that is not halved
_HIDDEN = 1e-12  # growth that rounding may hide

Growth = Callable[[float], float]


def stable_intervals(growth: Growth, places: Array) -> Iterator[tuple[float, float]]:
    """Yield the intervals between the first place and the last in which a growth is negative, in order."""
    begin, low, stable = float(places[0]), float(places[0]), None
    for high, value in _told(growth, places):
        if stable is not None and (value < 0.0) != stable:
            edge = zero_between(growth, low, high)
            if stable:
                yield begin, edge
            begin = edge
        low, stable = high, value < 0.0
    if stable:
        yield begin, float(places[-1])


def _told(growth: Growth, places: Array) -> Iterator[tuple[float, float]]:
    """Yield places and growths, so dense that no sign is passed over, without those that rounding hides."""
    low, at_low = float(places[0]), growth(float(places[0]))
    yield from [(low, at_low)] * (abs(at_low) > _HIDDEN)
    for high in map(float, places[1:]):
        at_high = growth(high)
        for x, value in _between(growth, low, at_low, high, at_high):
            yield from [(x, value)] * (abs(value) > _HIDDEN)
        low, at_low = high, at_high


def _between(growth: Growth, low: float, at_low: float, high: float, at_high: float) -> Iterator[tuple[float, float]]:
    """Yield the places beyond the first, the middle included, since a growth may dip between two that are alike."""
    if high - low > _SHORTEST and max(abs(at_low), abs(at_high)) > _HIDDEN:
        middle = 0.5 * (low + high)
        at_middle = growth(middle)
        values = (at_low, at_middle, at_high)
        if at_low != at_high and max(values) - min(values) > _QUIET * min(map(abs, values)):
            yield from _between(growth, low, at_low, middle, at_middle)
            yield from _between(growth, middle, at_middle, high, at_high)
            return
    yield high, at_high
