"""The descent that all searches for norms share: the largest of some sizes falls, and what is
unknown beside them.

The largest of logarithms l_k is smooth as log(sum exp(s l_k)) / s, with a sharpness s that grows.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np
import scipy.optimize

from proofmass.runner.host.arrays import Array

_STEPS = 60  # for each sharpness
_NOWHERE = 1e3
Smooth = Callable[[Array, float], tuple[float, Array]]  # of matrices and a sharpness: a value, and its slopes


def descended(smooth: Smooth, shape: tuple[int, ...], sharpness: Sequence[float], enough: float = -math.inf) -> Array:
    """Return matrices with a small value of `smooth`, from unit matrices: a value below `enough` ends the descent."""

    def flat(x: Array, sharp: float) -> tuple[float, Array]:
        try:
            value, slopes = smooth(x.reshape(shape), sharp)
        except np.linalg.LinAlgError:  # there is no such norm
            return _NOWHERE, np.zeros(x.size)
        return value, slopes.ravel()

    def ends(intermediate_result: scipy.optimize.OptimizeResult) -> None:
        if intermediate_result.fun < enough:
            raise StopIteration

    more = {"jac": True, "method": "L-BFGS-B", "callback": ends, "options": {"maxiter": _STEPS}}
    x = np.broadcast_to(np.eye(shape[-1]), shape).ravel()
    for sharp in sharpness:
        if flat(x, sharp)[0] < enough:
            break
        x = scipy.optimize.minimize(flat, x, args=(sharp,), **more).x
    return np.asarray(x.reshape(shape))


def largest(logs: Array, sharpness: float) -> tuple[float, Array]:
    """Return a smooth maximum, and its slopes."""
    parts = np.exp(sharpness * (logs - logs.max()))
    return float(logs.max()) + math.log(parts.sum()) / sharpness, parts / parts.sum()


def unknown(left: Array, rest: Array, right: Array) -> tuple[float, Array, Array]:
    """Return the Frobenius norm of abs(left) rest abs(right), and its slopes by both."""
    before, after = np.abs(left) @ rest, rest @ np.abs(right)
    both = before @ np.abs(right)
    size = float(np.linalg.norm(both)) or 1e-300
    return size, np.sign(left) * (both @ after.T) / size, np.sign(right) * (before.T @ both) / size
