"""Stacks of matrices in doubles with bounds of their errors: middles, and radii entry by entry.

A product of matrices with n terms an entry is off by at most n u / (1 - n u) |A| |B|, u = 2^-53, in any order of
summation (Higham, Accuracy and Stability of Numerical Algorithms, section 3.5).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.runner.derivatives.ball import UndecidedError, arb_of
from proofmass.runner.host.arrays import Array

UNIT = 2.0**-53  # largest relative rounding error of a double
UP = 1.0 + 2.0**-40  # more than the rounding of a sum of some thousand positive numbers
_LEAST = 1e-290  # more than what underflow takes


@dataclass(frozen=True)
class Enclosed:
    """Matrices of which each entry lies within its radius about its middle."""

    middle: Array  # (stack, rows, columns)
    radius: Array

    @classmethod
    def of_balls(cls, stack: Sequence[Sequence[Sequence[Any]]]) -> "Enclosed":
        """Return matrices of numbers and balls; raises `UndecidedError` for what is beyond all doubles."""
        arbs = [[[arb_of(value) for value in row] for row in rows] for rows in stack]
        middle = np.array([[[float(value.mid()) for value in row] for row in rows] for rows in arbs])
        apart = [
            [[float((value - m).abs_upper()) for value, m in zip(row, middles, strict=True)] for row, middles in pairs]
            for pairs in (zip(rows, of, strict=True) for rows, of in zip(arbs, middle.tolist(), strict=True))
        ]
        if not np.isfinite(apart).all():
            raise UndecidedError("a number without bounds")
        return cls(middle, np.array(apart) * UP)

    @classmethod
    def exact(cls, middle: Array) -> "Enclosed":
        """Return matrices of doubles, a stack of them or one."""
        stack = middle if middle.ndim == 3 else middle[None]
        return cls(stack, np.zeros_like(stack))

    @classmethod
    def stacked(cls, stacks: Sequence["Enclosed"]) -> "Enclosed":
        """Return the matrices of stacks one after the other."""
        return cls(*(np.concatenate([getattr(one, name) for one in stacks]) for name in ("middle", "radius")))

    @classmethod
    def interleaved(cls, stacks: Sequence["Enclosed"]) -> "Enclosed":
        """Return the matrices of stacks of equal length in turn."""
        parts = (np.stack([getattr(one, name) for one in stacks], axis=1) for name in ("middle", "radius"))
        return cls(*(part.reshape(-1, *part.shape[2:]) for part in parts))

    @classmethod
    def joined(cls, parts: Sequence[Sequence["Enclosed"]]) -> "Enclosed":
        """Return blocks of matrices as one."""
        whole = (
            np.concatenate([np.concatenate([getattr(one, name) for one in row], axis=2) for row in parts], axis=1)
            for name in ("middle", "radius")
        )
        return cls(*whole)

    def __getitem__(self, place: tuple[slice, slice]) -> "Enclosed":
        return Enclosed(self.middle[:, place[0], place[1]], self.radius[:, place[0], place[1]])

    def __add__(self, other: "Enclosed") -> "Enclosed":
        middle = self.middle + other.middle
        return Enclosed(middle, (self.radius + other.radius + UNIT * np.abs(middle)) * UP)

    def __matmul__(self, other: "Enclosed") -> "Enclosed":
        left, right = np.abs(self.middle), np.abs(other.middle)
        terms = (self.middle.shape[-1] + 2) * UNIT
        radius = (left * terms + self.radius) @ right + (left + self.radius) @ other.radius
        return Enclosed(self.middle @ other.middle, radius * UP + _LEAST)

    def moved(self, by: Array) -> "Enclosed":
        """Return the matrices with a matrix of doubles added to each."""
        return self + Enclosed.exact(np.broadcast_to(by, self.middle.shape))

    def scaled(self, factor: float) -> "Enclosed":
        """Return the matrices times a double, or times what it is the nearest double to."""
        middle = self.middle * factor
        return Enclosed(middle, (self.radius * abs(factor) + 4.0 * UNIT * np.abs(middle)) * UP + _LEAST)

    def repeated(self, times: int) -> "Enclosed":
        """Return each matrix along the diagonal as many times."""
        unit = np.eye(times)
        return Enclosed(_numbers(np.kron(unit, self.middle)), _numbers(np.kron(unit, self.radius)))

    def spread(self, size: int) -> "Enclosed":
        """Return each entry as that of a unit matrix of some size."""
        unit = np.eye(size)
        return Enclosed(_numbers(np.kron(self.middle, unit)), _numbers(np.kron(self.radius, unit)))


def quarters(whole: Enclosed, n: int) -> list[Enclosed]:
    """Return A, B, C and D of [A B; C D], A of n rows and columns."""
    sides = slice(None, n), slice(n, None)
    return [whole[rows, columns] for rows in sides for columns in sides]


def _numbers(array: Any) -> Array:
    return np.asarray(array, dtype=np.float64)
