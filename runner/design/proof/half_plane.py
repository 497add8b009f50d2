"""Half planes of poles: those of a loop in continuous time lie in one as those of a sampled loop lie in a disc.

    x' = A x:   Re (1 + j r) (s - c) < 0 for all poles s

holds if F = (1 + j r) (A - c) shortens every vector in some norm as time goes on: F + F' is
negative in its coordinates. F is linear in A, so that corners suffice. A norm is searched for (I +
h F) (I - h F)^-1, which has the same norms, as that of a sampled loop is. So is [A, B; C, D] with
an input and an output that the norm leaves as they are: the trapezoidal rule keeps all that goes
through. What is proved is about F alone.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.runner.design.proof.closed_loop import Disc, Family
from proofmass.runner.design.proof.enclosed import Enclosed, quarters
from proofmass.runner.host.arrays import Array

_STEPS = (0.7, 0.6)  # by the mean of the slowest and fastest pole, of which one may lie at 1 / h
_SLOWEST = 1e-12  # part of the fastest pole, below which one is at rest


@dataclass(frozen=True)
class HalfPlane:
    """The half plane Re (1 + j tilt) (s - real - j imaginary) < 0 in the plane of poles."""

    real: float = 0.0
    imaginary: float = 0.0
    tilt: float = 0.0

    radius, empty = math.inf, False  # as a disc

    def moved(self, family: Family, parts: int) -> Family:
        """Return matrices whose poles lie in the disc of radius 1 if those of a family's rates lie
        in this half plane.

        Raises `LinAlgError`.
        """
        n = family.corners.middle.shape[-1] - family.still
        unit, corners, shares = np.eye(n // parts), family.corners, family.shares
        if (self.real, self.imaginary, self.tilt) != (0.0, 0.0, 0.0):
            rotation: Any = [[0.0, -1.0], [1.0, 0.0]] if parts == 2 else [[0.0]]
            centre = self.real * np.eye(n) + self.imaginary * np.kron(rotation, unit)
            turn = np.eye(n) + self.tilt * np.kron(rotation, unit)
            corners = Enclosed.exact(turn) @ corners.moved(-centre)
            shares = {i: np.abs(turn) @ share * (1.0 + 2.0**-50) for i, share in shares.items()}
        return _sampled(replace(family, corners=corners, shares=shares))

    def as_data(self) -> dict[str, list[float]]:
        """Return it as plain data, for certificates."""
        return {"half_plane": [self.real, self.imaginary, self.tilt]}

    def beyond(self, family: Family) -> Array:
        """Return what the matrices of a certificate may lie beyond its corners: F."""
        assert family.rates is not None
        return np.asarray(sum(family.rates.shares.values(), 0.0 * family.centre) * (1.0 + 2.0**-39))


PoleRegion = Disc | HalfPlane  # a part of the plane of poles


def _sampled(rates: Family) -> Family:
    """Return the family of a sampled loop with norms of some rates, without added rounding."""
    for part in _STEPS:
        try:
            return _by_trapezoids(rates, part / _speed(rates))
        except np.linalg.LinAlgError:
            continue
    raise np.linalg.LinAlgError


def _by_trapezoids(rates: Family, step: float) -> Family:
    """Return x[n+1] = x[n] + 2 h (A z + B w), with the output C z + D w of their mean z, both scaled by sqrt(2 h)."""
    n, still, root = len(rates.centre) - rates.still, np.eye(rates.still), np.sqrt(2.0 * step)
    a, b, c, d = (part.middle for part in quarters(rates.corners, n))
    between = np.linalg.inv(np.eye(n) - step * a)
    inner, outer = root * between @ b, root * c @ between
    through = d + step * c @ between @ b
    corners = np.block([[2.0 * between - np.eye(n), inner], [outer, through]])
    near, zeros = between.mean(axis=0), np.zeros((n, rates.still))
    left = np.abs(np.block([[root * near, zeros], [step * c.mean(axis=0) @ near, still]]))
    right = np.abs(np.block([[root * near, step * near @ b.mean(axis=0)], [zeros.T, still]]))
    shares = {i: left @ share @ right for i, share in rates.shares.items()}
    return replace(rates, corners=Enclosed.exact(corners), shares=shares, rates=rates)


def _speed(rates: Family) -> float:
    """Return the mean of the slowest and the fastest pole, in 1/s."""
    n = len(rates.centre) - rates.still
    sizes = np.abs(np.linalg.eigvals(rates.centre[:n, :n]))
    moving = sizes[sizes > _SLOWEST * sizes.max(initial=0.0)]
    return float(np.sqrt(moving.min() * moving.max())) if len(moving) else 1.0
