"""Stacks of matrices in doubles with bounds of their errors: middles, and radii entry by entry.

A product of matrices with n terms an entry is off by at most n u / (1 - n u) |A| |B|, u = 2^-53, in
any order of summation (Higham, Accuracy and Stability of Numerical Algorithms, section 3.5).

With them a point of rest is shown within a reach, by Krawczyk's operator:

    |R (F(c, q) - c)| + |I - R (I - J)| r < r   for all J of dF/dx within r of c = c(q) and all q of a box

says that each q has one point x = F(x, q) within r of c, entry by entry (Krawczyk, Computing 4,
1969, 187; Neumaier, Interval Methods for Systems of Equations, section 5.1). R is near (I - J)^-1,
and c a polynomial of q near the point.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import flint
import numpy as np

from proofmass.runner.derivatives.ball import LEAST, UNIT, UP, Ball, UndecidedError, arb_of, double_of
from proofmass.runner.derivatives.taylor_model import TaylorModel
from proofmass.runner.host.arrays import Array


@dataclass(frozen=True)
class Enclosed:
    """Matrices of which each entry lies within its radius about its middle."""

    middle: Array  # (stack, rows, columns)
    radius: Array

    @classmethod
    def of_balls(cls, stack: Sequence[Sequence[Sequence[Any]]]) -> "Enclosed":
        """Return matrices of numbers and balls; raises `UndecidedError` beyond all doubles."""
        whole = np.array([[[double_of(value) for value in row] for row in rows] for rows in stack])
        whole = whole.reshape(len(stack), len(stack[0]), -1, 2)
        return cls(whole[..., 0], whole[..., 1])._known()

    @classmethod
    def at_corners(cls, model: TaylorModel, places: Sequence[int]) -> "Enclosed":
        """Return a polynomial of matrices at the corners of some coordinates, without its radius."""
        return cls(*model.at_corners(places))._known()

    def _known(self) -> "Enclosed":
        """Return the matrices; raises `UndecidedError` where one has no bounds."""
        if not (np.isfinite(self.middle).all() and np.isfinite(self.radius).all()):
            raise UndecidedError("a number without bounds")
        return self

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

    def __getitem__(self, place: tuple[Any, ...]) -> "Enclosed":
        rows, columns = place[-2:]
        return Enclosed(self.middle[:, rows, columns], self.radius[:, rows, columns])

    def __add__(self, other: "Enclosed") -> "Enclosed":
        middle = self.middle + other.middle
        return Enclosed(middle, (self.radius + other.radius + UNIT * np.abs(middle)) * UP)

    def __matmul__(self, other: "Enclosed") -> "Enclosed":
        left, right = np.abs(self.middle), np.abs(other.middle)
        terms = (self.middle.shape[-1] + 2) * UNIT
        radius = (left * terms + self.radius) @ right + (left + self.radius) @ other.radius
        return Enclosed(self.middle @ other.middle, radius * UP + LEAST)

    def moved(self, by: Array) -> "Enclosed":
        """Return the matrices with a matrix of doubles added to each."""
        return self + Enclosed.exact(np.broadcast_to(by, self.middle.shape))

    def scaled(self, factor: float) -> "Enclosed":
        """Return the matrices times a double, or times what it is the nearest double to."""
        middle = self.middle * factor
        return Enclosed(middle, (self.radius * abs(factor) + 4.0 * UNIT * np.abs(middle)) * UP + LEAST)

    def repeated(self, times: int) -> "Enclosed":
        """Return each matrix along the diagonal as many times."""
        unit = np.eye(times)
        return Enclosed(_numbers(np.kron(unit, self.middle)), _numbers(np.kron(unit, self.radius)))

    def spread(self, size: int) -> "Enclosed":
        """Return each entry as that of a unit matrix of some size."""
        unit = np.eye(size)
        return Enclosed(_numbers(np.kron(self.middle, unit)), _numbers(np.kron(self.radius, unit)))


_Whole = TypeVar("_Whole", Enclosed, TaylorModel, Array)


def quarters(whole: _Whole, n: int) -> list[_Whole]:
    """Return A, B, C and D of [A B; C D], A of n rows and columns."""
    sides = slice(None, n), slice(n, None)
    return [whole[..., rows, columns] for rows in sides for columns in sides]


def _numbers(array: Any) -> Array:
    return np.asarray(array, dtype=np.float64)


@dataclass(frozen=True)
class RestPoint:
    """Points of rest of the sensors of a box: within `reach` of a curve, as `left`, `step` and `matrix` show."""

    curve: Sequence[Any]  # c, of polynomials, balls or numbers
    reach: Array  # r
    left: Array  # R
    step: Enclosed  # F(c, q) - c, a column
    matrix: Enclosed  # J
    places: Sequence[Any] = ()  # where those numbers are that come to no rest of their own
    along: Sequence[Sequence[Any]] = ()  # how the others move with each of these

    @cached_property
    def values(self) -> list[Any]:
        """All numbers that may be there."""
        return [c + Ball(flint.arb(0, r)) for c, r in zip(self.curve, self.reach.tolist(), strict=True)]

    @property
    def centre(self) -> Array:
        """The middle of all that the curve passes."""
        return np.array([float(arb_of(c).mid()) for c in self.curve])

    def as_data(self) -> dict[str, Any]:
        """Return what shows it as plain data, for certificates."""
        enclosed = {"step": self.step, "matrix": self.matrix}
        own = {"centre": self.centre, "reach": self.reach, "left": self.left}
        parts = own | {name: one.middle[0] for name, one in enclosed.items()}
        parts |= {f"{name}_radius": one.radius[0] for name, one in enclosed.items()}
        return {name: part.reshape(-1).tolist() if "step" in name else part.tolist() for name, part in parts.items()}

    def needed(self) -> Array:
        """Return |R step| + |I - R (I - J)| r, rounded up."""
        n = len(self.curve)
        left = Enclosed.exact(self.left)
        minus = Enclosed(-self.matrix.middle, self.matrix.radius).moved(np.eye(n))
        off = (Enclosed.exact(-self.left) @ minus).moved(np.eye(n))
        by = left @ self.step
        sizes = np.abs(by.middle) + by.radius
        return np.asarray((sizes[0, :, 0] + (np.abs(off.middle[0]) + off.radius[0]) @ self.reach) * (1.0 + 1e-12))


def balls_of(values: Array) -> list[Any]:
    """Return numbers as exact balls."""
    return [Ball(flint.arb(value)) for value in values.tolist()]


def near_inverse(matrix: Sequence[Sequence[Any]]) -> Array:
    """Return a matrix near (I - J)^-1; raises `UndecidedError` if there is none."""
    near = np.array([[float(arb_of(value).mid()) for value in row] for row in matrix])
    try:
        return np.asarray(np.linalg.inv(np.eye(len(near)) - near), dtype=np.float64)
    except np.linalg.LinAlgError:
        raise UndecidedError("something on the way does not come to rest") from None
