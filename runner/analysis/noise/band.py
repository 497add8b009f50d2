"""Integrals of a density over a band, by Gauss and Legendre's rule between the frequencies at which it bends."""

from collections.abc import Callable

import numpy as np

from proofmass.runner.analysis.linearisation.period_map import Array
from proofmass.runner.analysis.linearisation.wire_response import resonances
from proofmass.runner.analysis.noise.noise_map import NoiseMap

_NODES = 16
_RELATIVE = 1e-11  # change of the integral by halving all steps
_HALVINGS = 6
_RATIO = 4.0  # of the distances from the middle of a resonance at which panels end


def rule(density: Callable[[Array], Array], ends: Array) -> tuple[Array, Array, Array]:
    """Points and weights by which each column of a density is integrated over some panels, and the integrals."""
    point, weight = np.polynomial.legendre.leggauss(_NODES)

    def integrated() -> tuple[Array, Array, Array]:
        half, middle = 0.5 * np.diff(ends), 0.5 * (ends[:-1] + ends[1:])
        points, weights = (middle[:, None] + half[:, None] * point).ravel(), (half[:, None] * weight).ravel()
        return points, weights, np.asarray(weights @ density(points))

    latest = integrated()
    for _ in range(_HALVINGS - 1):
        before, ends = latest[2], np.sort(np.concatenate([ends, 0.5 * (ends[:-1] + ends[1:])]))
        latest = integrated()
        if np.all(np.abs(latest[2] - before) <= _RELATIVE * np.abs(latest[2]).sum()):
            break
    return latest


def mean_squares(of: NoiseMap, band: tuple[float, float]) -> Array:
    """Mean square of the part of the output in a band, by each source."""
    return rule_of(of, band)[2]


def rule_of(of: NoiseMap, band: tuple[float, float]) -> tuple[Array, Array, Array]:
    """Points and weights of the integrals over a band, and the mean squares by each source."""
    low, high = band[0], min(band[1], of.rate / 2.0)
    if not high > low:
        return np.zeros(0), np.zeros(0), np.zeros(len(of.sources))
    return rule(of.densities, bends(of, low, high))


def bends(of: NoiseMap, low: float, high: float) -> Array:
    """Frequencies from low to high between which the density is smooth: about each pole, ever wider apart."""
    ends = {low, high}
    for middle, width in resonances(of):
        apart = width
        while apart < high:
            ends |= {middle - apart, middle + apart}
            apart *= _RATIO
        ends.add(middle)
    inside = np.array(sorted(f for f in ends if low <= f <= high))
    return np.asarray(inside[np.concatenate([[True], np.diff(inside) > 1e-12 * high])])
