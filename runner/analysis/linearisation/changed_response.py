"""The response C (z - A)^-1 B + D of a map at some points, and by how much it changes with some rows or columns of it.

Norms are those of Frobenius. A period of noise has thousands of columns, which count through B B' and B D' alone. Where
rows of A change by E, (z - A - E)^-1 follows from (z - A)^-1 by as many rows (Sherman, Morrison, Woodbury).
"""

from collections.abc import Sequence
from functools import cached_property

import numpy as np

from proofmass.runner.host.arrays import Array, Complex

Parts = tuple[Array, Array, Array, Array]
Norms = tuple[Array, Array]  # the larger of those before and after a change, and that of the change, at each point


class ChangedResponse:
    """The response of A, B, C and D."""

    def __init__(self, parts: Parts, z: Complex) -> None:
        self._a, self._b, self._c, self._d = parts
        self._inverse = np.linalg.inv(z[:, None, None] * np.eye(len(self._a)) - self._a).astype(np.complex128)

    def of_columns(self, columns: Sequence[int], b: Array, d: Array) -> Norms:
        """Return the norms where some columns of B and D become these."""
        old_b, old_d = self._b[:, columns], self._d[:, columns]
        after = self._square - self._of(old_b, old_d) + self._of(b, d)
        return self._norms(after, self._of(b - old_b, d - old_d))

    def of_outputs(self, rows: Sequence[int], change: Array) -> Norms:
        """Return the norms where some rows of C change by so much."""
        moved = change @ self._entered
        across = np.sum(self._c[rows] @ self._entered * moved.conj(), axis=(1, 2))
        across += np.sum((change @ self._inverse) * (self._d[rows] @ self._b.T), axis=(1, 2))
        square = _square(moved)
        return self._norms(self._square + 2.0 * np.real(across) + square, square)

    def of_states(self, rows: Sequence[int], change: Array) -> Norms:
        """Return the norms where some rows of A change by so much."""
        right = change @ self._inverse
        left = self._inverse[:, :, rows] @ np.linalg.inv(np.eye(len(rows)) - right[:, :, rows])
        moved = (self._outputs @ left) @ (right @ self._inputs)
        through = np.sum((right @ self._shared) * left.transpose(0, 2, 1), axis=(1, 2))
        direct = self._square - _square(self._between)
        return self._norms(_square(self._between + moved) + direct + 2.0 * np.real(through), _square(moved))

    def _norms(self, after: Array, change: Array) -> Norms:
        size = np.maximum(np.maximum(self._square, after), 0.0)
        return np.sqrt(size), np.sqrt(np.maximum(change, 0.0))

    def _of(self, b: Array, d: Array) -> Array:
        """Return the squared norm with other columns of B and D, as many as they may be."""
        if b.shape[1] < len(b):
            return _square(self._heard @ b + d)
        both = np.real(np.sum((self._heard @ (b @ b.T)) * self._heard.conj(), axis=(1, 2)))
        return np.asarray(both + 2.0 * np.real(np.sum(self._heard * (d @ b.T), axis=(1, 2))) + np.sum(d**2))

    @cached_property
    def _heard(self) -> Complex:
        return np.asarray(self._c @ self._inverse)

    @cached_property
    def _square(self) -> Array:
        return self._of(self._b, self._d)

    @cached_property
    def _outputs(self) -> Array:
        """Rows with the norms of C, as many as there are states at most."""
        return np.linalg.qr(self._c)[1]

    @cached_property
    def _inputs(self) -> Array:
        """Columns with the norms of B, as many as there are states at most."""
        return np.linalg.qr(self._b.T)[1].T

    @cached_property
    def _entered(self) -> Complex:
        return np.asarray(self._inverse @ self._inputs)

    @cached_property
    def _between(self) -> Complex:
        return np.asarray(self._outputs @ self._entered)

    @cached_property
    def _shared(self) -> Array:
        return np.asarray(self._b @ self._d.T @ self._c)


def _square(matrices: Complex) -> Array:
    return np.asarray(np.sum(np.abs(matrices) ** 2, axis=(1, 2)))
