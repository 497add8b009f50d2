"""The Allan deviation that a density makes.

    s^2(m T) = integral of S(f) 2 sin^4(pi f m T) / (m^2 sin^2(pi f T)) df, up to half the rate

Where sin^4 turns many times it counts by its mean, 3/8.
"""

from collections.abc import Callable

import numpy as np

from proofmass.runner.host.arrays import Array

_TURNS, _STEPS = 8.0, 1024  # periods of sin^4 that are integrated, and points in them
_LOW = 1e-4  # part of 1 / tau below which the integral is negligible
_POINTS = 400  # points above these periods


def allan_deviation(frequencies: Array, density: Array, period: float, taus: Array) -> Array:
    """The deviation of values that lie a period apart, with a density known at some frequencies."""
    logarithms = np.log(np.maximum(density, 1e-300))

    def at(f: Array) -> Array:
        below = np.maximum(0.0, np.log(frequencies[0] / f))  # below the first frequency the density keeps its slope
        slope = (logarithms[1] - logarithms[0]) / np.log(frequencies[1] / frequencies[0])
        return np.asarray(np.exp(np.interp(np.log(f), np.log(frequencies), logarithms) - slope * below))

    return np.asarray(np.sqrt([_variance(at, period, round(tau / period)) for tau in taus]))


def _variance(density: Callable[[Array], Array], period: float, m: int) -> float:
    top, tau = 0.5 / period, m * period
    turning = min(_TURNS / tau, top)
    f = np.concatenate([np.geomspace(_LOW / tau, 0.1 / tau, 200)[:-1], np.linspace(0.1 / tau, turning, _STEPS)])
    low = density(f) * 2.0 * np.sin(np.pi * f * tau) ** 4 / (m * np.sin(np.pi * f * period)) ** 2
    total = float(np.trapezoid(low, f))
    if turning < top:
        f = np.geomspace(turning, top, _POINTS)
        total += float(np.trapezoid(density(f) * 0.75 / (m * np.sin(np.pi * f * period)) ** 2, f))
    return total
