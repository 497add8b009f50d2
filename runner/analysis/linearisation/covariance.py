"""Covariances of the states of a linear map, and units by which each state has a variance of one."""

from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.host.arrays import Array

_DOUBLINGS = 64
_FADING = 0.999  # factor in a period, for the units of states that may wander


def summed(a: Array, first: Any, other: Array | None = None) -> Array:
    """X in X = A X A' + first, by doubling: exact to rounding whatever the units of the states are.

    With another matrix B it is X = A X B' + first.
    """
    total, power = np.array(first, dtype=float), np.array(a, dtype=float)
    right = power if other is None else np.array(other, dtype=float)
    for _ in range(_DOUBLINGS):
        more = power @ total @ right.T
        total = total + more
        if np.all(np.abs(more) <= 1e-18 * np.abs(total)):
            break
        power, right = power @ power, right @ right
    return np.asarray(total)


def in_rms(a: Array, entering: Array) -> tuple[Array, Array]:
    """Return A in units of the rms of each state, and these units, by what enters in numbers of unit variance.

    Balancing would tear a chain of filters apart, and take as tiny what is gone after a period.
    States that wander have the rms that they reach in some periods. What grows has the units of
    `balanced`.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        squares = np.diag(summed(a * _FADING, entering @ entering.T))
    if not np.isfinite(squares).all():
        return balanced(a)
    scale = np.sqrt(np.where(squares > 0.0, squares, 1.0))
    return a * scale / scale[:, None], scale
