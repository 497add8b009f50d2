"""Norms for a path at rest: of A, and of I - R M with the R that leaves most room.

I - R M is R's image of what M is off by: for a norm that is given it is convex in R. In the
coordinates of T, with K = T^-1 R M T, both are moved: I - (I + Y) K (I + X) has the slopes - u (K
(I + X) v)' by Y and - (K' (I + Y)' u) v' by X, of its singular vectors. It is that of T (I + X) and
T (I + X) (I + Y) T^-1 R.
"""

import math
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from proofmass.runner.design.proof.at_rest import at_rest
from proofmass.runner.design.proof.closed_loop import Family, OpenCorners
from proofmass.runner.design.proof.contraction import Norm, covariance_norm, first_norm
from proofmass.runner.design.proof.descent import descended, largest, unknown
from proofmass.runner.host.arrays import Array

_NOISE = (1e-1, 1e-2)  # of covariances, in all directions
_GROWN = 1.2  # by which they count what the matrix does
_SHARPNESS = (20.0, 200.0, 2_000.0)  # of the smooth maximum that is descended
_ENOUGH = 0.95  # a norm with which a descent ends
_LEAST_PART = 1e-40  # of the largest entry of a row, for which each counts: 2^-300, a checker's unit, is far below


@dataclass(frozen=True)
class Start:
    """A transformation from which a search for a norm begins, and what it multiplied M by."""

    transform: Array
    left: Array | None = None
    alone: bool = False  # it serves, or none does


def norm_at_rest(of: OpenCorners, limit: float, start: Start | None) -> Norm | None:
    """Return norms of A and of I - R M, side by side; None where the mean of the corners does not decay.

    Those of a `start` are taken where they serve.
    """
    n = of.order
    if start is not None and start.left is not None:
        given = Norm(start.transform, at_rest(of, limit, start.left))
        if given.contracts():
            return given
    family = at_rest(of, limit)
    poles, rest = family.parts()
    root = _root_of_poles(poles, None if start is None else start.transform[:n, :n]) if n else np.eye(0)
    if root is None:
        return None
    turned, left = _descended(_first(rest), family)
    return Norm(np.asarray(scipy.linalg.block_diag(root, turned)), at_rest(of, limit, left))


def _root_of_poles(poles: Family, given: Array | None) -> Array | None:
    """Return a transformation in which A contracts, or the best that is found."""
    known = None if given is None else Norm(given, poles)
    if known is not None and known.contracts():
        return known.transform
    own = first_norm(poles)
    if own is None:
        return None
    best = min((norm for norm in (known, own) if norm is not None), key=Norm.worst)
    return (best if best.contracts() else best.improved()).transform


def _first(rest: Family) -> Norm:
    """Return a norm in which I - R M is short, and what is unknown of it."""
    sizes = np.abs(rest.centre) + np.abs(rest.moves()).sum(axis=0) + sum(rest.shares.values())
    sizes = sizes + _LEAST_PART * sizes.max(axis=1, initial=0.0)[:, None]
    norms = [Norm(np.eye(len(sizes)), rest)]
    for noise in _NOISE:
        try:
            norms.append(covariance_norm(rest, sizes, _GROWN, noise))
        except (np.linalg.LinAlgError, ValueError):
            continue
    return min(norms, key=lambda norm: norm.worst() + float(np.linalg.norm(norm.rest)))


def _descended(first: Norm, family: Family) -> tuple[Array, Array]:
    """Return a transformation and R with more room than those of a norm."""
    n, rest = len(first.transform), first.rest
    unit = np.eye(n)
    k = unit - first.corners.middle

    def smooth(both: Array, sharpness: float) -> tuple[float, Array]:
        right, left = both
        u, sizes, v = np.linalg.svd(unit - left @ k @ right)
        value, parts = largest(np.log(sizes[:, 0] + 1e-300), sharpness)
        weights = parts / (sizes[:, 0] + 1e-300)
        ahead = np.einsum("kij,kj->ki", k @ right, v[:, 0])
        back = np.einsum("kji,kj->ki", left @ k, u[:, :, 0])
        by_left = -np.einsum("k,ki,kj->ij", weights, u[:, :, 0], ahead)
        by_right = -np.einsum("k,ki,kj->ij", weights, back, v[:, 0])
        size, size_by_left, size_by_right = unknown(left, rest, right)
        return value + size, np.array([by_right + size_by_right, by_left + size_by_left])

    right, left = descended(smooth, (2, n, n), _SHARPNESS, math.log(_ENOUGH))
    turned = first.transform @ right
    assert family.left is not None
    return np.asarray(turned), np.asarray(turned @ left @ first.inverse @ family.left)
