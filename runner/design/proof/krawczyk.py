"""A point of rest within a reach, by Krawczyk's operator.

    |R (F(c, q) - c)| + |I - R (I - J)| r < r   for all J of dF/dx within r of c and all q of a box

says that each q has one point x = F(x, q) within r of c, entry by entry (Krawczyk, Computing 4, 1969, 187; Neumaier,
Interval Methods for Systems of Equations, section 5.1). R is near (I - J)^-1.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import flint
import numpy as np

from proofmass.runner.derivatives.ball import Ball, UndecidedError, arb_of
from proofmass.runner.derivatives.dual import plain
from proofmass.runner.design.proof.enclosed import Enclosed
from proofmass.runner.host.arrays import Array


@dataclass(frozen=True)
class RestPoint:
    """Points of rest of the sensors of a box: within `reach` of `centre`, as `left`, `step` and `matrix` show."""

    centre: Array  # c
    reach: Array  # r
    left: Array  # R
    step: Enclosed  # F(c, q) - c, a column
    matrix: Enclosed  # J
    follows: Mapping[str, tuple[float, Array]] = field(
        default_factory=dict
    )  # parameters at c, and how x moves with them

    @cached_property
    def values(self) -> list[Any]:
        """All numbers that may be there, as balls."""
        ends = zip(self.centre.tolist(), self.reach.tolist(), strict=True)
        return [Ball(flint.arb(c) + flint.arb(0, r)) for c, r in ends]

    def as_data(self) -> dict[str, Any]:
        """Return what shows it as plain data, for certificates."""
        enclosed = {"step": self.step, "matrix": self.matrix}
        own = {"centre": self.centre, "reach": self.reach, "left": self.left}
        parts = own | {name: one.middle[0] for name, one in enclosed.items()}
        parts |= {f"{name}_radius": one.radius[0] for name, one in enclosed.items()}
        return {name: part.reshape(-1).tolist() if "step" in name else part.tolist() for name, part in parts.items()}

    def near(self, parameters: Mapping[str, Any]) -> list[Any]:
        """Return a point near that of rest for parameters; raises `UndecidedError` if it may lie beyond the reach."""
        moved = balls_of(self.centre)
        for name, (origin, slopes) in self.follows.items():
            moved = [x + (parameters[name] - origin) * slope for x, slope in zip(moved, slopes.tolist(), strict=True)]
        if not all(a.arb.contains(arb_of(plain(x))) for a, x in zip(self.values, moved, strict=True)):
            raise UndecidedError("the point of rest bends too much")
        return moved

    def needed(self) -> Array:
        """Return |R step| + |I - R (I - J)| r, rounded up."""
        n = len(self.centre)
        left = Enclosed.exact(self.left)
        minus = Enclosed(-self.matrix.middle, self.matrix.radius).moved(np.eye(n))
        off = (Enclosed.exact(-self.left) @ minus).moved(np.eye(n))
        by = left @ self.step
        sizes = np.abs(by.middle) + by.radius
        return np.asarray((sizes[0, :, 0] + (np.abs(off.middle[0]) + off.radius[0]) @ self.reach) * (1.0 + 1e-12))

    def holds(self, part: "RestPoint") -> bool:
        """Return whether the points of a part of the box lie within, so that they are the same."""
        return all(a.arb.contains(b.arb) for a, b in zip(self.values, part.values, strict=True))


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


def differences_of(matrix: Sequence[Sequence[Any]]) -> Any:
    """Return I - J, of balls."""
    return flint.arb_mat([[(i == j) - arb_of(value) for j, value in enumerate(row)] for i, row in enumerate(matrix)])
