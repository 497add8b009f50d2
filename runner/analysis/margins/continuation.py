"""Factors at a wire with which a loop is stable, found by following its slowest pole.

The growth g, the logarithm of the largest size of a pole, is continuous in the factor. Between two places it keeps its
sign if it changes by less than half of itself, at their middle too; any other step is halved, down to a thousandth.
Growths that rounding hides count neither as stable nor as unstable.
"""

from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from proofmass.runner.analysis.margins.bracketed import zeros_between
from proofmass.runner.host.arrays import Array

_QUIET = 0.5  # part of itself by which a growth may change in a step
_SHORTEST = 1e-3  # step that is not halved
_FAR = 1e300  # growth that stands for infinity
_HIDDEN = 1e-12  # growth that rounding may hide

Growths = Callable[[npt.NDArray[Any]], Array]  # of many places at once


def stable_intervals(growths: Growths, places: Array) -> Iterator[tuple[float, float]]:
    """Yield the intervals between the first place and the last in which a growth is negative, in order."""
    begin, low, stable = float(places[0]), float(places[0]), None
    for high, value in _told(growths, places):
        if abs(value) <= _HIDDEN:
            continue
        if stable is not None and (value < 0.0) != stable:
            (edge,) = zeros_between(lambda x: np.clip(growths(x), -_FAR, _FAR), np.array([low]), np.array([high]))
            if stable:
                yield begin, float(edge)
            begin = float(edge)
        low, stable = high, value < 0.0
    if stable:
        yield begin, float(places[-1])


def _told(growths: Growths, places: Array) -> list[tuple[float, float]]:
    """Return places and growths in order, so dense that no sign is passed over.

    A growth may dip between two places at which it is alike: their middle is looked at too.
    """
    known = dict(zip(places.tolist(), growths(places).tolist(), strict=True))
    steps = list(pairwise(places.tolist()))
    while steps:
        steps = [
            (low, high)
            for low, high in steps
            if high - low > _SHORTEST and max(abs(known[low]), abs(known[high])) > _HIDDEN
        ]
        middles = [0.5 * (low + high) for low, high in steps]
        values = growths(np.array(middles)).tolist() if steps else []
        halves = []
        for (low, high), middle, value in zip(steps, middles, values, strict=True):
            three = (known[low], value, known[high])
            if known[low] != known[high] and max(three) - min(three) > _QUIET * min(map(abs, three)):
                known[middle] = value
                halves += [(low, middle), (middle, high)]
        steps = halves
    return sorted(known.items())
