"""Covariances of the states of a linear map, and units that follow from them."""

from typing import Any

import numpy as np

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.host.arrays import Array

_DOUBLINGS = 64
_FADING = 0.999  # factor in a period, for the units of states that may wander
_ROUNDING = 1e-16


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

    Balancing would tear a chain of filters apart. States that wander have the rms that they reach
    in some periods. What grows has the units of `balanced`.
    """
    scale = _rms(a, entering)
    return balanced(a) if scale is None else (a * scale / scale[:, None], scale)


def alike(a: Array, entering: Array) -> tuple[Array, Array]:
    """Return A in units that balance what one state adds to the rms of another, and these units.

    What is less than rounding there has no say: a state that is gone after a period would have a tiny unit.
    """
    scale = _rms(a, entering)
    added = a if scale is None else np.where(np.abs(a) * scale > _ROUNDING * scale[:, None], a, 0.0)
    units = balanced(added)[1]
    return a * units / units[:, None], units


def _rms(a: Array, entering: Array) -> Array | None:
    """Return the rms of each state, and 1 of those that nothing moves; None where they grow."""
    with np.errstate(over="ignore", invalid="ignore"):
        squares = np.diag(summed(a * _FADING, entering @ entering.T))
    return np.sqrt(np.where(squares > 0.0, squares, 1.0)) if np.isfinite(squares).all() else None
