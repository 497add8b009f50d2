"""Overshoot and settling time of a closed loop's answer to a step, T = L / (1 + L)."""

import math

import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.step import WITHIN, step_response


def step_figures(margins: Margins) -> dict[str, float]:
    """Return the overshoot in per cent and the settling time within 2 % in seconds, of the mean over each period."""
    times, rows = step_response(margins)
    values = rows.mean(axis=1)
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


def _final(system: OpenLoop) -> float:
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    closed = np.real(system.closed())
    rest = -closed if system.continuous else np.eye(len(closed)) - closed
    alike, scale = balanced(rest)
    entry = (b @ inverse).sum(axis=1) / scale
    held = scale * np.linalg.lstsq(alike, entry)[0]  # the loop may not see some mode that lasts
    return float(((inverse @ c) @ held + (d @ inverse).sum(axis=1)).mean())
