"""Bounds of the structured singular value of a complex matrix for independent complex perturbations
of its blocks.

    max over U of rho(U M)  <=  mu(M)  <=  min over D of sigma(D M D^-1)

U has a factor of size 1 for each scalar block, D a positive factor for each block. log sigma is
convex in log D (Sezginer and Overton, IEEE Trans. Automatic Control 35, 1990, 1338), so that
cutting planes find its minimum; for up to three blocks the upper bound is mu itself (Packard and
Doyle, Automatica 29, 1993, 71).
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize

from proofmass.runner.host.arrays import Array, Complex

_LIMIT = 30.0  # of log D
_CUTS = 200
_CLOSE = 1e-9  # between the planes and the best value
_FLAT = 1e-12
_STARTS, _TURNS = 8, 200  # of the power iteration
_WARM = 0.1  # of log D, about a point that is nearly right
_WIDE = 5.0
_programme: Any = scipy.optimize.linprog
_minimise: Any = scipy.optimize.minimize_scalar


class ScaledBound(NamedTuple):
    """An upper bound, and the logarithms of the factors that give it."""

    bound: float
    scales: Array


def upper_bound(
    matrix: Complex, sizes: Sequence[int], begin: Array | None = None, close: float = _CLOSE
) -> ScaledBound:
    """Return the least of the largest singular values over all scalings of such blocks."""
    count = len(sizes)
    start = np.zeros(count) if begin is None else np.asarray(begin, dtype=float)
    value, slope = _largest(matrix, sizes, start)
    if count == 1 or value == -np.inf:
        return ScaledBound(float(np.exp(value)), start)
    if count == 2:
        return _of_two(matrix, sizes)
    best, at = value, start
    centre, radius = start.copy(), 2.0 if begin is None else _WARM
    planes, levels = [np.append(slope[1:], -1.0)], [slope @ start - value]
    for _ in range(_CUTS):
        low = np.maximum(centre[1:] - radius, -_LIMIT)
        high = np.minimum(centre[1:] + radius, _LIMIT)
        scales = _programme(
            np.append(np.zeros(count - 1), 1.0),
            A_ub=np.array(planes),
            b_ub=np.array(levels),
            bounds=[*zip(low, high, strict=True), (None, None)],
            method="highs",
        )
        if scales.x is None:
            break
        point = np.append(0.0, scales.x[:-1])
        value, slope = _largest(matrix, sizes, point)
        planes.append(np.append(slope[1:], -1.0))
        levels.append(slope @ point - value)
        at_edge = bool(np.any(np.abs(point[1:] - centre[1:]) >= radius * (1.0 - 1e-9)))
        if value < best:
            best, at = value, point
            centre = point
            if at_edge:
                radius *= 2.0
        elif not at_edge:
            radius = max(radius * 0.7, 1e-9)
        if best - float(scales.fun) <= close and not at_edge:
            break
    return ScaledBound(float(np.exp(best)), at)


def _of_two(matrix: Complex, sizes: Sequence[int]) -> ScaledBound:
    """Return the bound for two blocks, whose ratio is the one scale: by Brent's method."""
    a = sizes[0]
    norms = np.linalg.norm(matrix[:a, a:]), np.linalg.norm(matrix[a:, :a])
    if min(norms) == 0.0:
        one, two = np.linalg.norm(matrix[:a, :a], 2), np.linalg.norm(matrix[a:, a:], 2)
        return ScaledBound(float(max(one, two)), np.zeros(2))
    middle = 0.5 * float(np.log(norms[0] / norms[1]))
    minimum = _minimise(
        lambda scale: _largest(matrix, sizes, np.array([0.0, scale]))[0],
        bounds=(middle - _WIDE, middle + _WIDE),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return ScaledBound(float(np.exp(minimum.fun)), np.array([0.0, minimum.x]))


def _largest(matrix: Complex, sizes: Sequence[int], scales: Array) -> tuple[float, Array]:
    """Return the logarithm of the largest singular value, and its slope by the scales."""
    factors = np.repeat(np.exp(scales), sizes)
    left, values, right = np.linalg.svd(factors[:, None] * matrix / factors)
    if values[0] <= 0.0:
        return -np.inf, np.zeros(len(sizes))
    part = np.abs(left[:, 0]) ** 2 - np.abs(right[0]) ** 2
    ends = np.cumsum([0, *sizes])
    return float(np.log(values[0])), np.array([part[a:b].sum() for a, b in pairwise(ends.tolist())])


def lower_bound(matrix: Complex, sizes: Sequence[int]) -> tuple[float, Complex]:
    """Return a size a perturbation reaches, and its factors of size one, a factor for each block.

    Power iteration from several starts; the perturbation of a block is one factor for all of its
    values.
    """
    count, rng = len(sizes), np.random.default_rng(0)
    best, factors = 0.0, np.ones(count, dtype=complex)
    for number in range(_STARTS):
        turn = np.exp(2j * np.pi * rng.random(count)) if number else np.ones(count, dtype=complex)
        turn, reached = _turned(matrix, sizes, turn)
        if reached > best:
            best, factors = reached, turn
    return best, factors


def _turned(matrix: Complex, sizes: Sequence[int], turn: Complex) -> tuple[Complex, float]:
    """Turn the factors so that the largest eigenvalue of U M grows, until it does not."""
    reached = 0.0
    ends = np.cumsum([0, *sizes])
    for _ in range(_TURNS):
        values, right = np.linalg.eig(np.repeat(turn, sizes)[:, None] * matrix)
        at = int(np.argmax(np.abs(values)))
        size = float(np.abs(values[at]))
        if size <= reached * (1.0 + _FLAT):
            break
        reached, value, vector = size, values[at], right[:, at]
        left = np.linalg.pinv(right)[at]
        # d value = left dU M right: by the phase of factor i it turns with the part left_i value right_i
        parts = np.array([np.sum(left[a:b] * vector[a:b]) for a, b in pairwise(ends.tolist())])
        turned = turn * np.exp(-1j * np.angle(np.where(np.abs(parts) > 0.0, parts, 1.0)))
        for step in (1.0, 0.5, 0.25, 0.1, 0.03, 0.01):
            mixed = turn * np.exp(1j * step * np.angle(turned / turn))
            tried = float(np.max(np.abs(np.linalg.eigvals(np.repeat(mixed, sizes)[:, None] * matrix))))
            if tried > reached:
                turn = mixed
                break
        else:
            return turn / np.exp(1j * np.angle(value)), reached
    return turn, reached
