"""Integrals of a density over a band, by Gauss and Legendre's rule between the frequencies at which it bends."""

from collections.abc import Callable

import numpy as np

from proofmass.runner.analysis.linearisation.period_map import Array
from proofmass.runner.analysis.noise.noise_map import NoiseMap

_NODES = 16
_RELATIVE = 1e-11  # change of the integral by halving all steps
_HALVINGS = 6
_RATIO = 4.0  # of the distances from the middle of a resonance at which panels end
_PER_DECADE = 60


def integral(density: Callable[[Array], Array], ends: Array) -> Array:
    """The integral of each column of a density from the first to the last of some frequencies."""
    point, weight = np.polynomial.legendre.leggauss(_NODES)
    before, total = None, np.zeros(0)
    for _ in range(_HALVINGS):
        half = 0.5 * np.diff(ends)
        middle = 0.5 * (ends[:-1] + ends[1:])
        values = density((middle[:, None] + half[:, None] * point).ravel())
        total = (half[:, None] * weight).ravel() @ values
        if before is not None and np.all(np.abs(total - before) <= _RELATIVE * np.abs(total).sum()):
            break
        before, ends = total, np.sort(np.concatenate([ends, middle]))
    return np.asarray(total)


def mean_squares(of: NoiseMap, band: tuple[float, float]) -> Array:
    """Mean square of the part of the output in a band, by each source."""
    low, high = band[0], min(band[1], of.rate / 2.0)
    return integral(of.densities, bends(of, low, high)) if high > low else np.zeros(len(of.sources))


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


def resonances(of: NoiseMap) -> list[tuple[float, float]]:
    """Frequency and half width of the poles, folded up to half the rate of the output."""
    found = []
    for pole in of.poles:
        if abs(pole) < 1e-3:
            continue
        frequency = abs(float(np.angle(pole))) / (2.0 * np.pi * of.period)
        width = max(abs(float(np.log(np.abs(pole)))), 1e-9) / (2.0 * np.pi * of.period)
        for turn in range(of.values // 2 + 1):
            found += [(abs(turn / of.period + side * frequency), width) for side in (1.0, -1.0)]
    return sorted({(f, w) for f, w in found if f <= of.rate / 2.0})


def grid(of: NoiseMap, low: float, high: float) -> Array:
    """Frequencies to show a density at: evenly on a logarithmic axis, and denser about resonances."""
    count = max(2, int(_PER_DECADE * np.log10(high / low)) + 1)
    points = [np.geomspace(low, high, count)]
    sharp = [(f, w) for f, w in resonances(of) if f > 0.0 and w < 0.1 * f][:50]
    points += [f + w * np.array([-8.0, -4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0, 8.0]) for f, w in sharp]
    every = np.unique(np.concatenate(points))
    return np.asarray(every[(every >= low) & (every <= high)])
