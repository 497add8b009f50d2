"""Zeros and minima of a function between places, for many pairs at once.

scipy.optimize has them too, but takes as long to import as the margins of most loops.

Factors at a wire with which a loop is stable are found by following its slowest pole. Its growth g,
the logarithm of the largest size of a pole, is continuous in the factor. Between two places it
keeps its sign if it changes by less than half of itself, at their middle too; any other step is
halved, down to a thousandth. Growths that rounding hides count neither as stable nor as unstable.
"""

import math
from collections.abc import Callable, Iterator
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from proofmass.runner.host.arrays import Array

RealCurve = Callable[[Array], Array]
_STEPS = 120
_EXACT = 1e-15  # relative accuracy of a zero
_LOWEST, _FLAT = 1e-10, 1e-8  # accuracy of a minimum's place: relative, and of its bracket
_ROUNDING = 1e-15
_GOLDEN = 0.5 * (3.0 - math.sqrt(5.0))
_QUIET = 0.5  # part of itself by which a growth may change in a step
_SHORTEST = 1e-3  # step that is not halved
_FAR = 1e300  # growth that stands for infinity
HIDDEN = 1e-12  # growth that rounding may hide

Growths = Callable[[npt.NDArray[Any]], Array]  # of many places at once


def zeros_between(function: RealCurve, low: Array, high: Array, scale: float = 1.0) -> Array:
    """The zeros of a function that changes its sign between two places, for many pairs, but for rounding.

    It is that of a place, or of the `scale` where that is more. The way there is inverse quadratic
    interpolation where that is safe, else bisection (Chandrupatla, Advances in Engineering Software
    28, 1997, 145).
    """
    if not len(low):
        return np.zeros(0)
    x1, x2 = np.array(high, dtype=float), np.array(low, dtype=float)
    f1, f2 = (np.array(function(x), dtype=float) for x in (x1, x2))
    found = np.where(np.abs(f1) < np.abs(f2), x1, x2)
    live, part = np.flatnonzero(f1 * f2 < 0.0), np.full(len(low), 0.5)
    x1, x2, f1, f2, part = (of[live] for of in (x1, x2, f1, f2, part))
    for _ in range(_STEPS):
        if not len(live):
            break
        x = x1 + part * (x2 - x1)
        f = np.array(function(x), dtype=float)
        same = np.sign(f) == np.sign(f1)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, f
        found[live] = np.where(np.abs(f2) < np.abs(f1), x2, x1)
        least = (_EXACT * np.maximum(scale, np.abs(found[live]))) / np.abs(x2 - x1)
        with np.errstate(divide="ignore", invalid="ignore"):
            xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            curved = f1 / (f2 - f1) * f3 / (f2 - f3) + (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        safe = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        part = np.clip(np.where(safe, curved, 0.5), least, 1.0 - least)
        on = (least <= 0.5) & (np.minimum(np.abs(f1), np.abs(f2)) > 0.0)
        live = live[on]
        x1, x2, f1, f2, part = (of[on] for of in (x1, x2, f1, f2, part))
    return found


def lowest_between(function: RealCurve, low: Array, middle: Array, high: Array) -> tuple[Array, Array]:
    """Return places and values of the minima in brackets, their middles lower than their ends.

    Parabolas through three places, and every third time the golden section of the longer part.
    """
    a, b, c = (np.array(x, dtype=float) for x in (low, middle, high))
    fa, fb, fc = (np.array(function(x), dtype=float) for x in (a, b, c))
    near = np.maximum(np.minimum(_LOWEST * np.abs(b), _FLAT * (c - a)), _ROUNDING * np.abs(b))
    for step in range(_STEPS):
        wide = (c - a > near) & (np.maximum(fa, fc) > fb)
        if not wide.any():
            break
        golden = np.where(c - b > b - a, b + _GOLDEN * (c - b), b - _GOLDEN * (b - a))
        with np.errstate(divide="ignore", invalid="ignore"):
            up, down = (b - a) * (fb - fc), (b - c) * (fb - fa)
            vertex = b - 0.5 * ((b - a) * up - (b - c) * down) / (up - down)
        least = 0.25 * near
        vertex = np.where(np.abs(vertex - b) < least, b + np.where(c - b > b - a, least, -least), vertex)
        x = np.where((vertex > a) & (vertex < c) & (step % 3 != 2), vertex, golden)
        x = np.where(wide, x, b)
        f = np.where(wide, function(x), fb)
        lower = f < fb
        end, f_end, is_left = np.where(lower, b, x), np.where(lower, fb, f), lower == (x > b)
        a, fa = np.where(wide & is_left, end, a), np.where(wide & is_left, f_end, fa)
        c, fc = np.where(wide & ~is_left, end, c), np.where(wide & ~is_left, f_end, fc)
        b, fb = np.where(lower, x, b), np.where(lower, f, fb)
    return b, fb


def stable_intervals(growths: Growths, places: Array) -> Iterator[tuple[float, float]]:
    """Yield the intervals between the first place and the last of negative growth, in order."""
    begin, low, stable = float(places[0]), float(places[0]), None
    for high, value in _told(growths, places):
        if abs(value) <= HIDDEN:
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
            if high - low > _SHORTEST and max(abs(known[low]), abs(known[high])) > HIDDEN
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
