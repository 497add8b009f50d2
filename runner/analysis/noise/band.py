"""Integrals of a density over a band, by Gauss and Legendre's rule between the frequencies at which it bends."""

from collections.abc import Callable

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.runner.analysis.linearisation.wire_response import resonances
from proofmass.runner.analysis.noise.noise_map import NoiseMap
from proofmass.runner.host.arrays import Array

_NODES = 16
_RELATIVE = 1e-11  # of the whole integral: change of a panel's part by halving the panel
_HALVINGS = 40
_PANELS = 1 << 17  # at most, that are halved at once
_NO_INTEGRAL = "the density has no integral to eleven digits"
_RATIO = 4.0  # of the distances from the middle of a resonance at which panels end


def rule(density: Callable[[Array], Array], ends: Array) -> tuple[Array, Array, Array]:
    """Points and weights by which each column of a density is integrated over some panels, and the integrals.

    Each panel is halved until its part of the integral no longer changes. Raises `ModelError` if
    that does not end.
    """
    node, weight = np.polynomial.legendre.leggauss(_NODES)

    def parts(left: Array, right: Array) -> tuple[Array, Array, Array]:
        """Points, weights and integral of each panel."""
        half = 0.5 * (right - left)[:, None]
        points, weights = half * node + 0.5 * (left + right)[:, None], half * weight
        values = density(points.ravel()).reshape(len(left), _NODES, -1)
        return points, weights, np.asarray(np.einsum("pn,pnk->pk", weights, values))

    left, right = np.asarray(ends[:-1]), np.asarray(ends[1:])
    before, integral = parts(left, right)[2], 0.0
    settled: list[tuple[Array, Array]] = []
    for _ in range(_HALVINGS):
        middle = 0.5 * (left + right)
        left, right = np.stack([left, middle], axis=1).ravel(), np.stack([middle, right], axis=1).ravel()
        points, weights, latest = parts(left, right)
        pairs = latest.reshape(len(before), 2, -1).sum(axis=1)
        limit = _RELATIVE * np.abs(integral + pairs.sum(axis=0)).sum()
        done = np.repeat(np.all(np.abs(pairs - before) <= limit, axis=1), 2)
        settled.append((points[done], weights[done]))
        integral = integral + latest[done].sum(axis=0)
        left, right, before = left[~done], right[~done], latest[~done]
        if not len(left):
            points, weights = (np.concatenate(several).ravel() for several in zip(*settled, strict=True))
            return points, weights, np.asarray(integral)
        if len(left) > _PANELS:
            break
    got = f"it still changes between {left[0]:g} Hz and {right[-1]:g} Hz"
    expected = "a band without a resonance that is not damped"
    raise ModelError([Problem(message=_NO_INTEGRAL, key="band", got=got, expected=expected)])


def within(of: NoiseMap, band: tuple[float, float]) -> tuple[float, float]:
    """Return the part of a band that values of an output have; raises `ModelError` where there is none."""
    top = 0.5 * of.rate
    if not 0.0 <= band[0] < min(band[1], top):
        got = f"{band[0]:g} Hz to {band[1]:g} Hz"
        expected = f"within 0 Hz to {top:g} Hz, half the rate of the output"
        raise ModelError([Problem(message="the band is empty", key="band", got=got, expected=expected)])
    return band[0], min(band[1], top)


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
