"""Overshoot and settling time of a closed loop's answer to a step, T = L / (1 + L)."""

import math

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.host.arrays import Array

WITHIN = 0.02  # of the final value, in which a step has settled
_DECAYED = 1e-4
_FEWEST, _MOST = 64, 1 << 18  # periods
_POINTS = 32.0  # of the fastest time constant of a continuous loop


def step_figures(margins: Margins) -> dict[str, float]:
    """Return the overshoot in per cent and the settling time within 2 % in seconds of a stable loop."""
    times, values = step_of(margins)
    final = _final(margins.system)
    if final == 0.0 or not len(values):
        return {"overshoot": math.inf, "settling_time": math.inf}
    apart = values / final - 1.0
    outside = np.flatnonzero(np.abs(apart) > WITHIN)
    settled = 0.0
    if len(outside):
        last = int(outside[-1])
        if last + 1 >= len(apart):
            settled = math.inf
        else:  # between two values the straight line
            before, after = abs(float(apart[last])), abs(float(apart[last + 1]))
            settled = float(times[last] + (times[last + 1] - times[last]) * (before - WITHIN) / (before - after))
    return {"overshoot": 100.0 * max(float(np.max(apart)), 0.0), "settling_time": settled}


def step_of(margins: Margins) -> tuple[Array, Array]:
    """Return times and values of the answer to a step at the wire, at its mean over a period."""
    system, poles = margins.system, margins.poles
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    closed, entry = np.real(system.closed()), (b @ inverse).sum(axis=1)
    out, through = (inverse @ c).mean(axis=0), float((d @ inverse).sum(axis=1).mean())
    step = margins.period
    if system.continuous:
        step = 1.0 / (_POINTS * float(np.max(np.abs(poles))))
        whole = np.zeros((len(closed) + 1,) * 2)
        whole[:-1, :-1], whole[:-1, -1] = closed, entry
        exponential = scipy.linalg.expm(whole * step)
        closed, entry = exponential[:-1, :-1], exponential[:-1, -1]
        poles = np.exp(poles * step)
    radius = float(np.max(np.abs(poles), initial=0.0))
    wanted = math.log(_DECAYED) / math.log(radius) if 0.0 < radius < 1.0 else _FEWEST
    count = 1 << math.ceil(math.log2(min(max(wanted, _FEWEST), _MOST)))
    states = _states(np.asarray(closed, dtype=np.float64), np.asarray(entry, dtype=np.float64), count)
    return np.asarray(np.arange(count) * step, dtype=np.float64), np.asarray(out @ states + through, dtype=np.float64)


def _states(a: Array, b: Array, count: int) -> Array:
    """Return a column for each period, by doubling: x[n + 1] = A x[n] + b from rest."""
    size = len(a)
    whole = np.zeros((size + 1, size + 1))
    whole[:size, :size], whole[:size, size], whole[size, size] = a, b, 1.0
    columns = np.zeros((size + 1, 1))
    columns[size] = 1.0
    while columns.shape[1] < count:
        columns, whole = np.hstack([columns, whole @ columns]), whole @ whole
    return columns[:size, :count]


def _final(system: OpenLoop) -> float:
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    closed = np.real(system.closed())
    rest = -closed if system.continuous else np.eye(len(closed)) - closed
    alike, scale = balanced(rest)
    entry = (b @ inverse).sum(axis=1) / scale
    held = scale * np.linalg.lstsq(alike, entry)[0]  # the loop may not see some mode that lasts
    return float(((inverse @ c) @ held + (d @ inverse).sum(axis=1)).mean())
