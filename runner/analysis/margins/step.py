"""The answer of a closed loop, T = L / (1 + L), to a unit step that is added at its wire."""

import math

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.lasting import Lasting
from proofmass.runner.analysis.linearisation.step import driven_step, step_response
from proofmass.runner.analysis.linearisation.wire_response import WireResponse
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.host.arrays import Array

_POINTS = 32.0  # of the fastest time constant of a continuous loop
_GROWN = 6.0  # time constants of an unstable pole that a picture shows
_FEWEST, _MOST = 8, 1 << 18  # periods


def closed_loop(margins: Margins) -> WireResponse:
    """Return the closed loop from a constant added at its wire to all values of the wire in a period.

    A loop in continuous time is sampled often. Modes that last, which no figure sees, are left out
    of a stable loop.
    """
    system = margins.system
    _, b, c, d = system.matrices
    inverse = np.linalg.inv(np.eye(len(d)) + d)
    a: Array = np.asarray(np.real(system.closed()), dtype=np.float64)
    b = (b @ inverse).sum(axis=1)[:, None]
    c, d, step = inverse @ c, (d @ inverse).sum(axis=1)[:, None], margins.period
    if system.continuous:
        step = 1.0 / (_POINTS * float(np.max(np.abs(margins.poles), initial=0.0) or 1.0))
        augmented = step * np.vstack([np.hstack([a, b]), np.zeros(len(a) + 1)])
        whole = np.asarray(scipy.linalg.expm(augmented), dtype=np.float64)
        a, b = whole[:-1, :-1], whole[:-1, -1:]
    if margins.stable:
        a, b, c = Lasting(a).without(a, b, c)
    return WireResponse((a, b, c, d), step)


def shown_step(margins: Margins) -> tuple[Array, Array]:
    """Return times and values in all ticks, until a stable loop has settled, or an unstable one has grown."""
    of = closed_loop(margins)
    found = step_response(of) if margins.stable else None
    if found is not None:
        return found.shown()
    growth = math.log(max(of.radius, 1.0))
    return driven_step(of, min(max(math.ceil(_GROWN / growth), _FEWEST), _MOST) if growth else _MOST)
