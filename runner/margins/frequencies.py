"""Frequencies at which something happens, refined until rounding ends it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.optimize

from proofmass.runner.margins.open_loop import Complex, OpenLoop
from proofmass.runner.margins.period_map import Array

_PER_DECADE = 60
_ROUNDING = 1e-12
_ABOUT_A_POLE = np.concatenate([-np.geomspace(1e-2, 30.0, 24), [0.0], np.geomspace(1e-2, 30.0, 24)])
Measure = Callable[[Complex], Array]
_brentq: Any = scipy.optimize.brentq
_minimize: Any = scipy.optimize.minimize_scalar


def grid(system: OpenLoop) -> Array:
    """Angular frequencies up to half the rate of the wire, denser about open- and closed-loop poles."""
    period, last = system.map.period, math.pi / system.sample
    poles = np.concatenate([system.open_poles, system.poles])
    logs: Complex = np.log(poles[np.abs(poles) > 1e-6])
    corners = np.abs(logs)[np.abs(logs) > 1e-9] / period
    lowest = 1e-3 * min(float(np.min(corners, initial=last)), last)
    decades = math.log10(last / lowest)
    points = [np.geomspace(lowest, last, 2 + int(_PER_DECADE * decades))]
    points.append(np.linspace(0.0, last, 16 * (len(poles) + 16) * system.per_period)[1:])
    for log in logs[np.abs(logs.real) < 1.0]:
        for turn in range(system.per_period):
            centre = (abs(log.imag) + 2.0 * math.pi * turn) / period
            width = abs(log.real) if abs(log.real) > 1e-9 else 1e-2  # on the unit circle rounding hides what is nearer
            points.append(centre + width / period * _ABOUT_A_POLE)
    w = np.unique(np.concatenate(points))
    w = w[(w >= lowest) & (w <= last)]
    on_circle = system.open_poles[np.abs(np.abs(system.open_poles) - 1.0) < 1e-9]
    distance = np.abs(np.exp(1j * w * period)[:, None] - on_circle)
    far: Array = w[np.min(distance, axis=1, initial=2.0) > 1e-6]  # from where L is infinite, or is but for a zero
    return far


@dataclass(frozen=True)
class Samples:
    """What a system answers on a grid of frequencies, and how it is found between them."""

    answer: Callable[[Array], Complex]
    w: Array
    values: Complex

    @classmethod
    def on(cls, w: Array, answer: Callable[[Array], Complex]) -> "Samples":
        """The answers on a grid."""
        return cls(answer, w, answer(w))

    def up_to(self, w: float) -> "Samples":
        """The part below a frequency."""
        return replace(self, w=self.w[self.w < w], values=self.values[self.w < w])


def crossings(samples: Samples, measure: Measure) -> list[float]:
    """Frequencies at which a measure of the answer is zero, those between two points where it only dips too."""
    w, values = _with_dips(samples, measure)
    size = np.abs(samples.answer(w)) if samples.values.ndim == 1 else 1.0
    told = np.flatnonzero((np.abs(values) > _ROUNDING * size) & np.isfinite(values))  # of the others no sign is known
    curve, w, values = _curve(samples, measure), w[told], values[told]
    places = np.flatnonzero(np.sign(values[:-1]) != np.sign(values[1:]))
    return [zero_between(curve, float(w[i]), float(w[i + 1])) for i in places]


def highest(samples: Samples, measure: Measure) -> tuple[float, float]:
    """Frequency and value at which a measure of the answer is largest."""
    w, values, curve = samples.w, measure(samples.values), _curve(samples, measure)
    best = int(np.argmax(values))
    found = (float(w[best]), float(values[best]))
    for i in map(int, np.flatnonzero(values >= 0.98 * values[best])):
        before, after = max(i - 1, 0), min(i + 1, len(w) - 1)
        if values[i] >= max(values[before], values[after]):
            found = max(found, _refined(curve, float(w[before]), float(w[after])), key=lambda pair: pair[1])
    return found


def _with_dips(samples: Samples, measure: Measure) -> tuple[Array, Array]:
    """The points, and where the measure comes nearest to zero between points of one sign."""
    w, values, curve = samples.w, measure(samples.values), _curve(samples, measure)
    size = np.abs(values)
    inner = np.flatnonzero((size[1:-1] < size[:-2]) & (size[1:-1] < size[2:])) + 1
    inner = inner[(np.sign(values[inner - 1]) == np.sign(values[inner + 1]))]
    added = [_refined(lambda v: -abs(curve(v)), float(w[i - 1]), float(w[i + 1]))[0] for i in inner]
    joined = np.concatenate([w, added])
    order = np.argsort(joined)
    return joined[order], np.concatenate([values, [curve(v) for v in added]])[order]


def _curve(samples: Samples, measure: Measure) -> Callable[[float], float]:
    return lambda w: float(measure(samples.answer(np.array([w])))[0])


def _refined(curve: Callable[[float], float], low: float, high: float) -> tuple[float, float]:
    options = {"xatol": 1e-10 * high}
    found = _minimize(lambda v: -curve(v), bounds=(low, high), method="bounded", options=options)
    return float(found.x), -float(found.fun)


def zero_between(function: Callable[[float], float], low: float, high: float) -> float:
    """The zero of a function that changes its sign between two places, but for rounding."""
    ends = (function(low), function(high))
    if ends[0] * ends[1] >= 0.0:
        return low if abs(ends[0]) < abs(ends[1]) else high
    return float(_brentq(function, low, high, xtol=1e-14, rtol=1e-14))
