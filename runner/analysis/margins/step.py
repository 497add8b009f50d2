"""The answer of a closed loop, T = L / (1 + L), to a unit step that is added at its wire."""

import math

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.host.arrays import Array

WITHIN = 0.02  # of the final value, in which a step has settled
SHOWN = 1.6  # settling times that a picture shows
_DECAYED = 1e-4  # of the slowest pole at the end
_FEWEST, _MOST = 64, 1 << 18  # periods
_POINTS = 32.0  # of the fastest time constant of a continuous loop
_GROWN = 6.0  # time constants of an unstable pole that a picture shows


def doubled(columns: Array, power: Array, count: int) -> tuple[Array, Array]:
    """Return at least `count` columns, each the power times the one before, and the power that leads beyond them."""
    while columns.shape[1] < count:
        columns, power = np.hstack([columns, power @ columns]), power @ power
    return columns, power


def sampled_step(margins: Margins) -> tuple[Array, Array, Array, Array, float]:
    """Return A, B, C and D of the closed loop for a constant added at its wire, and the seconds between two values.

    All values of the wire in a period are rows of C and D. A loop in continuous time is sampled often.
    """
    system, poles = margins.system, margins.poles
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    closed, entry = np.real(system.closed()), (b @ inverse).sum(axis=1)
    step = margins.period
    if system.continuous:
        step = 1.0 / (_POINTS * float(np.max(np.abs(poles), initial=0.0) or 1.0))
        exponential = scipy.linalg.expm(_whole(closed, entry, 0.0) * step)
        closed, entry = exponential[:-1, :-1], exponential[:-1, -1]
    whole = np.asarray(closed, dtype=np.float64), np.asarray(entry, dtype=np.float64)[:, None]
    return *whole, inverse @ c, (d @ inverse).sum(axis=1)[:, None], step


def step_response(margins: Margins) -> tuple[Array, Array]:
    """Return times in seconds, and values at the wire, a row each, with all of a period."""
    closed, entry, out, direct, step = sampled_step(margins)
    poles = np.exp(margins.poles * step) if margins.system.continuous else margins.poles
    speed = abs(math.log(min(max(float(np.max(np.abs(poles), initial=0.0)), 1e-300), 1e300)))
    count = 1 << math.ceil(math.log2(min(max(-math.log(_DECAYED) / max(speed, 1e-12), _FEWEST), _MOST)))
    columns = np.zeros((len(closed) + 1, 1))
    power = _whole(closed, entry[:, 0], 1.0)
    columns[-1] = 1.0
    columns, _ = doubled(columns, power, count)  # x[n + 1] = A x[n] + b from rest
    values = out @ columns[:-1] + direct
    return np.asarray(np.arange(count) * step, dtype=np.float64), np.asarray(values.T, dtype=np.float64)


def shown_step(margins: Margins) -> tuple[Array, Array]:
    """Return times and values in all ticks, until a stable loop has settled, or an unstable one has grown."""
    times, values = step_response(margins)
    each, end = times[1] / values.shape[1], times[-1]
    times, values = (times[:, None] + each * np.arange(values.shape[1])).ravel(), values.ravel()
    if margins.stable:
        outside = np.flatnonzero(np.abs(values - values[-1]) > WITHIN * np.max(np.abs(values)))
        end = SHOWN * float(times[outside[-1]]) if len(outside) else 0.0
    elif (growth := _growth(margins)) > 0.0:
        end = _GROWN / growth
    count = max(int(np.searchsorted(times, end, side="right")), min(_FEWEST, len(times)))
    return times[:count], values[:count]


def _growth(margins: Margins) -> float:
    """Return the growth of the pole that grows fastest, in 1/s."""
    if margins.system.continuous:
        return float(np.max(margins.poles.real))
    return math.log(float(np.max(np.abs(margins.poles)))) / margins.period


def _whole(a: Array, b: Array, last: float) -> Array:
    whole = np.zeros((len(a) + 1,) * 2)
    whole[:-1, :-1], whole[:-1, -1], whole[-1, -1] = a, b, last
    return whole
