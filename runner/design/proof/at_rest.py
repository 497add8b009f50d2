"""A path at rest, over a box of coordinates: that its scale factor is nowhere a value g.

With the map [A B; C D] of a period, from a constant input to the mean of the output, the scale
factor is

    G = D + C (I - A)^-1 B,   det [I - A, -B; -C, g - D] = det(I - A) (g - G)

Where all poles lie in the circle det(I - A) is positive, so that g - G has the sign of the
determinant of this bordered matrix M. It is regular where the poles of I - R M lie in the circle
too, for any R: then it has the sign of det R. R is near the inverse in the middle of the box. So A
and I - R M, side by side, are one matrix whose poles all lie in a disc.
"""

from typing import Any

import flint
import numpy as np

from proofmass.runner.derivatives.taylor_model import TaylorModel, joined
from proofmass.runner.design.proof.closed_loop import Family, MapParts, OpenCorners
from proofmass.runner.design.proof.enclosed import Enclosed, quarters
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.precision import precision

_BITS = 1_000  # of a determinant
_NEUTRAL = 1e-12  # distance from the circle to which rounding may move a pole that lies on it


def at_rest(of: OpenCorners, limit: float, left: Array | None = None) -> Family:
    """Return A and I - R M, R = `left`, for all of a box."""
    n = of.order
    left = _near_inverse(of, limit) if left is None else left
    border = np.diag([1.0] * n + [limit])
    rest = (Enclosed.exact(left) @ of.corners.moved(-border)).moved(np.eye(n + 1))
    beside = np.zeros((len(rest.middle), n, n + 1))
    below = Enclosed.exact(np.swapaxes(beside, 1, 2))
    corners = Enclosed.joined([[of.corners[slice(n), slice(n)], Enclosed.exact(beside)], [below, rest]])
    return Family(corners, 1, of.shares(_moving(of.terms, n, left)), blocks=(n, n + 1), left=left)


def keeps_side(left: Array, most: bool) -> bool:
    """Return whether the scale factors of a family that contracts lie below the limit, or above a lower one.

    The sign of det R says so, in balls.
    """
    with precision(_BITS):
        determinant: Any = flint.arb_mat(left.tolist()).det()
        return bool(determinant > 0) if most else bool(determinant < 0)


def scale_factors(of: OpenCorners) -> Array:
    """Return the scale factor at each corner, as a double: infinite where it does not settle."""
    n = of.order
    a, b, c, d = quarters(of.corners.middle, n)
    with np.errstate(all="ignore"):
        try:
            gains = d + c @ np.linalg.solve(np.eye(n) - a, b)
        except np.linalg.LinAlgError:
            return np.full(len(d), np.inf)
    return np.asarray(gains[:, 0, 0])


def none_settles(of: OpenCorners) -> bool:
    """Return whether a pole of each corner lies on the circle or outside, as doubles have it."""
    a = of.corners.middle[:, : of.order, : of.order]
    return bool(of.order) and bool((np.abs(np.linalg.eigvals(a)).max(axis=1) >= 1.0 - _NEUTRAL).all())


def _near_inverse(of: OpenCorners, limit: float) -> Array:
    """Return R = [I h; 0 1] [H 0; 0 1 / s] [I 0; q 1]: with H = (I - A)^-1, h = H B, q = C H it is
    the inverse of M.

    In place of g - G in the middle of the box s is the mean of its ends, that each lies between
    zero and two s.
    """
    n = of.order
    a, b, c, _ = quarters(of.corners.middle.mean(axis=0), n)
    try:
        inverse = np.linalg.inv(np.eye(n) - a)
    except np.linalg.LinAlgError:
        return np.eye(n + 1)
    room = limit - scale_factors(of)
    middle = 0.5 * (room.min() + room.max())
    lower, scaled, upper = np.eye(n + 1), np.zeros((n + 1, n + 1)), np.eye(n + 1)
    lower[n:, :n], upper[:n, n:] = c @ inverse, inverse @ b
    scaled[:n, :n], scaled[n, n] = inverse, 1.0 / middle if middle else 1.0
    near = upper @ scaled @ lower
    return np.asarray(near) if np.isfinite(near).all() else np.eye(n + 1)


def _moving(parts: MapParts, n: int, left: Array) -> TaylorModel:
    """Return A and R M without what does not follow coordinates in M, as polynomials."""
    a, b, c, d = parts
    moved = TaylorModel.constant(left) @ joined([[a, b], [c, d]])
    beside = np.zeros((n, n + 1))
    return joined([[a, TaylorModel.constant(beside)], [TaylorModel.constant(beside.T), moved]])
