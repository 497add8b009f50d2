"""Norms that bound the noise of an output over a box.

With the map [A B; C D] of a period from noise of unit variance, Q bounds what the output has of it:

    Q >= A'Q A + C'C   for all A and C:   its mean square is at most the trace of B'Q B + D'D

With Q = S'S the first is that [S A; C] S^-1 shortens every vector: S^-1 = T is a norm that leaves
the outputs as they are. The second is the sum of the squares of [S B; D]. Both are convex: of what
lies between corners, the corners suffice.

S is descended from that of the middle, for log max tr(B'Q B) + log max of C M^-1 C', M = Q - A'Q A:
the size of S does not matter, and is then the least with which C is short enough. By Q the first
has the slope B B', and the second, of its vector w = M^-1 C'u, the slope A w (A w)' - w w'.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.covariance import summed
from proofmass.runner.derivatives.taylor_model import TaylorModel, joined
from proofmass.runner.design.proof.closed_loop import Family, OpenCorners
from proofmass.runner.design.proof.contraction import Norm, bound_of, first_norm
from proofmass.runner.design.proof.descent import descended, largest, unknown
from proofmass.runner.design.proof.enclosed import Enclosed, quarters
from proofmass.runner.design.proof.rest_norm import Start
from proofmass.runner.host.arrays import Array

_SHARPNESS = (20.0, 200.0, 2_000.0)  # of the smooth maxima that are descended
_WIDER = (0.0, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)  # parts of the largest part of Q that begin in all directions
_NOTHING = 1e-300  # which has a logarithm, where nothing enters a corner or is observed there
_SPARE = 1e-10  # of the norm, beside what lies beyond the corners
_UNKNOWN, _KNOWN = 3.3, 2.02  # by which the square of a norm leaves room for that, by its Frobenius norm and in the end


def with_noise(of: OpenCorners, limit: float) -> Family:
    """Return [A 0; C 0] for all of a box, beside [B; D], whose squares have a `limit`."""
    n, r = of.order, of.values
    states, rest = slice(n), slice(n, None)
    empty = Enclosed.exact(np.zeros((len(of.corners.middle), n + r, r)))
    square = Enclosed.joined([[of.corners[slice(None), states], empty]])
    a, b, c, d = of.terms
    right = (TaylorModel.constant(np.zeros((size, r))) for size in (n, r))
    shares = of.shares(joined([[left, beside] for left, beside in zip((a, c), right, strict=True)]))
    entering = of.corners[slice(None), rest]
    beyond = np.zeros(entering.middle.shape[1:])
    for place, part in ((states, b), (rest, d)):
        beyond[place] = sum(of.shares(part).values(), beyond[place])
    return Family(square, 1, shares, still=r, noise=entering, beyond_noise=beyond, limit=limit)


def rms_at_corners(of: OpenCorners) -> Array:
    """Return the rms of the output at each corner, as a double: infinite where it has no bound."""
    n, squares = of.order, []
    for corner in of.corners.middle:
        a, b, c, d = quarters(corner, n)
        decays = not n or float(np.max(np.abs(np.linalg.eigvals(a)))) < 1.0
        q = summed(a.T, c.T @ c) if decays else None
        squares.append(math.inf if q is None else float(np.trace(b.T @ q @ b)) + float(np.sum(d**2)))
    return np.asarray(np.sqrt(squares))


def norm_of_noise(of: OpenCorners, limit: float, start: Start | None) -> Norm | None:
    """Return a norm with a small bound of the noise; None where the mean of the corners does not decay.

    That of a `start` is taken where it serves.
    """
    family = with_noise(of, limit)
    if start is not None:
        given = Norm(start.transform, family)
        if given.contracts():
            return given
    n = of.order
    if not n:
        return Norm(np.eye(family.still), family)
    states = slice(n)
    poles = replace(
        family,
        corners=family.corners[states, states],
        shares={i: s[:n, :n] for i, s in family.shares.items()},
        still=0,
        noise=None,
    )
    first = first_norm(poles)
    if first is None:
        return None
    first = first if first.contracts() else first.improved()
    try:
        return Norm(np.asarray(scipy.linalg.block_diag(_root(first, family), np.eye(family.still))), family)
    except np.linalg.LinAlgError:
        return None


def _root(first: Norm, family: Family) -> Array:
    """Return T of the least bound found; raises `LinAlgError` where no Q is found at all."""
    n = len(first.transform)
    assert family.noise is not None
    entering = first.inverse @ family.noise.middle[:, :n]
    corners = _Corners(
        first.corners.middle,
        family.corners.middle[:, n:, :n] @ first.transform,
        entering @ np.swapaxes(entering, 1, 2),
        first.rest,
    )
    begin = corners.first()
    s = descended(partial(corners.smooth, begin), begin.shape, _SHARPNESS) @ begin
    beyond = np.abs(s) @ first.rest @ np.abs(np.linalg.inv(s))
    squares, _ = corners.observed(s, _KNOWN * bound_of(beyond) + _SPARE)
    return np.asarray(first.transform @ np.linalg.inv(s * math.sqrt(float(squares.max()) * (1.0 + _SPARE))))


@dataclass(frozen=True)
class _Corners:
    """A, C and B B' at the corners of a box, in the coordinates of a norm in which all A decay."""

    a: Array
    c: Array
    b: Array  # B B'
    rest: Array  # bounds of what lies beyond the corners, of A

    def first(self) -> Array:
        """Return the root of Q of the middle, with as much in all directions as it needs to serve at the corners."""
        a, c = self.a.mean(axis=0), self.c.mean(axis=0)
        q = summed(a.T, c.T @ c)
        unit = np.eye(len(a)) * (float(np.linalg.norm(q, 2)) or 1.0)
        roots = list[tuple[float, Array]]()
        for part in _WIDER:
            with suppress(np.linalg.LinAlgError):
                root = np.asarray(np.linalg.cholesky(q + part * unit).T, dtype=np.float64)
                roots.append((self.smooth(root, np.eye(len(root)), _SHARPNESS[-1])[0], root))
        if not roots:
            raise np.linalg.LinAlgError
        return min(roots, key=lambda one: one[0])[1]

    def observed(self, s: Array, spare: float) -> tuple[Array, Array]:
        """Return the largest values of C M^-1 C', and their w.

        Raises `LinAlgError` where M, less a part of Q, is not positive.
        """
        q = s.T @ s
        lower = np.linalg.cholesky((1.0 - spare) * q - np.swapaxes(self.a, 1, 2) @ q @ self.a)
        u, sizes, _ = np.linalg.svd(np.linalg.solve(lower, np.swapaxes(self.c, 1, 2)), full_matrices=False)
        w = np.linalg.solve(np.swapaxes(lower, 1, 2), u[:, :, :1] * sizes[:, None, :1])[:, :, 0]
        return np.asarray(sizes[:, 0] ** 2 + _NOTHING), np.asarray(w, dtype=np.float64)

    def smooth(self, begin: Array, step: Array, sharpness: float) -> tuple[float, Array]:
        """Return the logarithm of the bound for a step from a root, with its slopes."""
        s = step @ begin
        back = np.asarray(np.linalg.inv(s), dtype=np.float64)
        size, size_by_s, size_by_back = unknown(s, self.rest, back)
        spare = _UNKNOWN * size + _SPARE
        squares, w = self.observed(s, spare)
        entering = np.einsum("ij,kji->k", s.T @ s, self.b) + _NOTHING
        moved = np.einsum("kij,kj->ki", self.a, w)
        value, slope, weights = 0.0, np.zeros_like(begin), entering
        for sizes, slopes in (
            (entering, self.b),
            (squares, moved[:, :, None] * moved[:, None] - (1.0 - spare) * w[:, :, None] * w[:, None]),
        ):
            logarithm, parts = largest(np.log(sizes), sharpness)
            value, weights = value + logarithm, parts / sizes
            slope += np.einsum("k,kij->ij", weights, slopes)
        by_size = _UNKNOWN * float(weights @ np.sum((w @ s.T) ** 2, axis=1))
        by_s = 2.0 * s @ slope + by_size * (size_by_s - back.T @ size_by_back @ back.T)
        return value, by_s @ begin.T
