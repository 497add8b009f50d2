"""Weibull's law of lifetimes, S(t) = exp(-(t / scale)^shape), fitted to sensors that are looked at
only now and then.

Of a sensor that leaves its tolerance between two looks only the interval is known: the likelihood
is that of interval-censored data, sum d_i log(S(t_i-1) - S(t_i)) + c log S(t_end) (Meeker and
Escobar, "Statistical methods for reliability data" (1998), sections 7.2 and 8.4). With x = log
shape, y = log scale, intervals are Wald's there, from the observed information.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.studies.outcome.intervals import LEVEL, Bounds

FEWEST = 5  # sensors that must have left their tolerance
Loss = Callable[[AnyArray], float]
_STEP = 1e-4  # of logarithms, for differences
_LONGEST = 0.5  # step of a logarithm
_NEAR = 1e-9
_ITERATIONS = 100
_WIDEST = 1e3  # factor from an estimate to an end of its interval


@dataclass(frozen=True)
class Weibull:
    """Shape and scale with their intervals, and the age at which a part of 1 % has left."""

    shape: float
    scale: float  # seconds: 63 % have left by then
    shape_interval: Bounds
    scale_interval: Bounds
    one_percent: float  # seconds
    one_percent_interval: Bounds

    def survival(self, ages: AnyArray) -> AnyArray:
        """Return the part that is left at ages in seconds."""
        return np.asarray(np.exp(-((np.asarray(ages) / self.scale) ** self.shape)))


def weibull(ages: Sequence[float], left: Sequence[float], surviving: float) -> Weibull | None:
    """Return the law that fits best: `left[i]` sensors left between ages i and i + 1, `surviving` never did.

    None where fewer than five left, all of them in one interval, or so that an end of an interval
    is a thousand times the estimate: no law follows from that.
    """
    edges, counts = np.asarray(ages, dtype=float), np.asarray(left, dtype=float)
    if counts.sum() < FEWEST or np.count_nonzero(counts) < 2:
        return None
    size = float(edges[-1])
    edges = edges / size

    def loss(point: AnyArray) -> float:
        with np.errstate(all="ignore"):
            hazard = np.where(edges > 0.0, (np.maximum(edges, 1e-300) / math.exp(point[1])) ** math.exp(point[0]), 0.0)
            # log(S(a) - S(b)) = -H(a) + log(1 - exp(-(H(b) - H(a))))
            between = -hazard[:-1] + np.log(-np.expm1(-np.diff(hazard)))
            total = np.where(counts > 0, counts * between, 0.0).sum() - surviving * hazard[-1]
        return float(-total) if math.isfinite(total) else 1e300

    last = surviving / (surviving + counts.sum())
    rough = math.log(max(-math.log(min(max(last, 1e-3), 1.0 - 1e-3)), 1e-3))
    starts = [np.array([math.log(shape), -rough / shape]) for shape in (1.0, 3.0)]
    best = min((_minimum(loss, begin) for begin in starts), key=loss)
    variance = _inverse(_information(loss, best))
    if variance is None:
        return None
    # start-up time: this part of SciPy takes 0.15 s
    from scipy.special import ndtri

    aside = float(ndtri(0.5 + 0.5 * LEVEL))
    # log of the age at which 1 % have left: y + log(-log 0.99) / shape
    level = math.log(-math.log1p(-0.01))
    inverse = math.exp(-best[0])
    gradient = np.array([-level * inverse, 1.0])
    at, error = best[1] + level * inverse, math.sqrt(max(float(gradient @ variance @ gradient), 0.0))
    halves = aside * np.sqrt(np.maximum(np.diag(variance), 0.0))
    if halves.max() > math.log(_WIDEST):
        return None
    shapes, scales = _ends(best[0], halves[0], 1.0), _ends(best[1], halves[1], size)
    first = size * math.exp(at), _ends(at, aside * error, size)
    return Weibull(math.exp(best[0]), size * math.exp(best[1]), shapes, scales, *first)


def _ends(logarithm: float, half: float, unit: float) -> Bounds:
    return unit * math.exp(logarithm - half), unit * math.exp(logarithm + half)


def _minimum(loss: Loss, begin: AnyArray) -> AnyArray:
    """Return where the loss is least, by Newton's method; steps are halved until they descend."""
    at, value = begin, loss(begin)
    for _ in range(_ITERATIONS):
        gradient, curved = _gradient(loss, at), _information(loss, at)
        least = float(np.linalg.eigvalsh(curved)[0]) if np.isfinite(curved).all() else -1.0
        curved = curved + max(0.0, 1e-3 * abs(np.trace(curved)) - least) * np.eye(2) if least <= 0.0 else curved
        step = np.linalg.solve(curved, gradient) if np.isfinite(curved).all() else gradient
        step = step * min(1.0, _LONGEST / max(float(np.abs(step).max()), 1e-300))
        while loss(at - step) > value and float(np.abs(step).max()) > 1e-12:
            step = 0.5 * step
        if float(np.abs(step).max()) < _NEAR:
            break
        at, value = at - step, loss(at - step)
    return at


def _gradient(loss: Loss, at: AnyArray) -> AnyArray:
    return np.array([(loss(at + s) - loss(at - s)) / (2.0 * _STEP) for s in _STEP * np.eye(2)])


def _information(loss: Loss, at: AnyArray) -> AnyArray:
    """Return second derivatives by central differences."""
    steps = _STEP * np.eye(2)

    def second(first: AnyArray, other: AnyArray) -> float:
        signs = ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))
        return sum(sign * loss(at + a * first + b * other) for a, b, sign in signs) / (4.0 * _STEP * _STEP)

    return np.array([[second(first, other) for other in steps] for first in steps])


def _inverse(matrix: AnyArray) -> AnyArray | None:
    """Return the inverse of a positive definite matrix, else None."""
    if not np.isfinite(matrix).all() or matrix[0, 0] <= 0.0 or np.linalg.det(matrix) <= 0.0:
        return None
    return np.asarray(np.linalg.inv(matrix))
