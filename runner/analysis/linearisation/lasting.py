"""The modes of a linear map that do not decay, and the map without them.

They are separated by the projector on their invariant subspaces, V (W V)^-1 W (Golub and Van Loan,
Matrix Computations, 7.6).
"""

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
import scipy.linalg

from proofmass.runner.analysis.linearisation.balance import balanced
from proofmass.runner.analysis.linearisation.covariance import alike
from proofmass.runner.analysis.linearisation.poles import Pole, judged, parts_of
from proofmass.runner.host.arrays import Array, Complex

_UNSEEN = 1e-9  # part of the largest possible coupling below which a mode counts as unseen
_TOGETHER = 1e-11  # difference in size below which two modes are one
_schur: Any = scipy.linalg.schur


class Lasting:
    """The modes of a matrix that do not decay.

    Units of states follow from what enters in numbers of unit variance, where that is said.
    """

    def __init__(self, a: Array, entering: Array | None = None) -> None:
        poles = _poles(a.tobytes())
        count = sum(pole.verdict != "stable" for pole in poles)
        while 0 < count < len(poles) and abs(poles[count - 1].value) - abs(poles[count].value) < _TOGETHER:
            count += 1  # rounding cannot part them
        self.largest = abs(poles[0].value) if poles else 0.0
        self._right = self._left = np.zeros((len(a), 0), dtype=complex)
        self.others = np.eye(len(a))
        if not count:
            return
        self._alike, self._scale = balanced(a) if entering is None else alike(a, entering)
        least = 0.5 * (abs(poles[count - 1].value) + (abs(poles[count].value) if count < len(poles) else 0.0))
        self._right, self._left = _invariant(self._alike, least)
        within = np.real(self._right @ self._left.T)
        self.others = np.eye(len(a)) - within * self._scale[:, None] / self._scale

    def passes(self, into: Array, out: Array) -> bool:
        """Return whether they couple any of these inputs to any of these outputs."""
        out = np.atleast_2d(out)
        if not self._right.shape[1]:
            return False
        reached, observed = self._left.T @ (into / self._scale[:, None]), (out * self._scale) @ self._right
        within = self._left.T @ self._alike @ self._right
        most = np.outer(np.linalg.norm(out * self._scale, axis=1), np.linalg.norm(into / self._scale[:, None], axis=0))
        for _ in range(len(within)):
            if np.any(np.abs(observed @ reached) > _UNSEEN * most):
                return True
            reached = within @ reached
        return False

    def without(self, a: Array, b: Array, c: Array) -> tuple[Array, Array, Array]:
        """Return the system of the other modes, in coordinates of their invariant subspace."""
        if not self._right.shape[1]:
            return a, b, c
        left, right = self.reduction
        return left @ a @ right, left @ b, c @ right

    @cached_property
    def reduction(self) -> tuple[Array, Array]:
        """L and R: L A R, L B and C R are the system of the other modes."""
        count = self._right.shape[1]
        if not count:
            return self.others, self.others
        even = self.others / self._scale[:, None] * self._scale
        basis = np.linalg.svd(even)[0][:, : len(even) - count]
        return basis.T @ even / self._scale, self._scale[:, None] * basis

    def holders(self, names: Sequence[str]) -> tuple[str, ...]:
        """Return the blocks that take part in them."""
        return holders(np.linalg.norm(self._right, axis=1), names)


@lru_cache(maxsize=4)
def _poles(numbers: bytes) -> tuple[Pole, ...]:
    """Return the poles of a matrix, the slowest first: maps to several outputs, or of other noise, have the same."""
    a = np.frombuffer(numbers)
    return judged(a.reshape(math.isqrt(len(a)), -1) if len(a) else a.reshape(0, 0), True)[1]


def holders(parts: Array, names: Sequence[str]) -> tuple[str, ...]:
    """Return the blocks of states that take part in a mode, those that move most first."""
    order = np.argsort(-parts, kind="stable")
    return tuple(dict.fromkeys(names[int(i)] for i in order if parts[i] >= 0.1 * parts[order[0]]))


def _invariant(a: Array, least: float) -> tuple[Complex, Complex]:
    """Return bases of the right and the left invariant subspace of eigenvalues above a size, with W V = 1.

    Both follow from one Schur form, with W = [1 Y] of T11 Y - Y T22 = T12. The subspaces of A and
    of A', looked for apart, need not have as many dimensions where eigenvalues lie close together.
    States come in an order in which integrators in a chain, which have no bound, are on the
    diagonal: otherwise rounding would scatter them.
    """
    order = [state for part in parts_of(a)[::-1] for state in part]
    form, ordered, count = _schur(a[np.ix_(order, order)], output="complex", sort=lambda value: abs(value) > least)
    turned = np.empty_like(ordered)
    turned[order] = ordered
    more = scipy.linalg.solve_sylvester(form[:count, :count], -form[count:, count:], form[:count, count:])
    left = np.hstack([np.eye(count), more]) @ turned.conj().T
    return turned[:, :count], left.T
