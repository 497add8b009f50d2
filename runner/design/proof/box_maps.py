"""Maps of a loop, path or output over boxes of parameters: polynomials of these, and their values at the corners."""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.runner.derivatives.ball import UndecidedError, ball
from proofmass.runner.derivatives.polynomial import PolynomialBall, model_of
from proofmass.runner.design.proof.ball_map import Starting
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.closed_loop import ClosedTicks, MapParts, OpenCorners, bend, parts_of
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.enclosed import Enclosed

_Parameters = Callable[[Sequence[Any]], Mapping[str, Any]]  # all that moves, at some coordinates
MOST_CORNERS = 9  # coordinates whose ends are looked at together
_NEAR = 2.0**-8  # part of a box about its middle, by which it is told where it bends
_KEPT = 256  # maps of boxes


class BoxMaps:
    """Maps of a loop or path over boxes; halves along the factor share those of the parameters."""

    def __init__(self, loop: Starting, parameters: _Parameters) -> None:
        self._loop, self._parameters, self.values, self.places = loop, parameters, loop.values, loop.places
        self._known: dict[Sides, OpenCorners | UndecidedError] = {}

    def worst_corner(self, box: Sides, claim: Claim) -> Sides | None:
        """Return the corner of a box where a quantity is worst, if it is beyond the limit."""
        opened = self.open(box[:-1])
        if claim.row.at_corners is None:
            return None
        values = claim.sign * claim.row.at_corners(opened)
        worst = int(np.argmin(values))
        return self.corner(box, worst) if claim.broken_by(claim.sign * float(values[worst])) else None

    def corner(self, box: Sides, number: int) -> Sides:
        """Return a corner of a box by its number."""
        opened = self.open(box[:-1])
        places = list(itertools.product((0, 1), repeat=len(opened.interpolated)))[number]
        ends = dict(zip(opened.interpolated, places, strict=True))
        points = [side[ends[i]] if i in ends else middle_of(*side) for i, side in enumerate(box[:-1])]
        return (*((point, point) for point in points), box[-1])

    def open(self, sides: Sides) -> OpenCorners:
        """Return the open loops of a box of parameters; raises `UndecidedError`."""
        if sides not in self._known:
            while len(self._known) >= _KEPT:
                del self._known[next(iter(self._known))]
            try:
                self._known[sides] = self._over(sides)
            except UndecidedError as error:
                self._known[sides] = UndecidedError(*error.args)
        found = self._known[sides]
        if isinstance(found, UndecidedError):
            raise found
        return found

    def _over(self, sides: Sides) -> OpenCorners:
        chosen = [i for i, (low, high) in enumerate(sides) if low < high][:MOST_CORNERS]
        loop, parameters = self._loop, self._parameters([_polynomial(s, i) for i, s in enumerate(sides)])
        whole = loop.map(self._parameters([ball(*side) for side in sides]) if loop.in_ticks else parameters)
        order, kept, size = whole.order, whole.kept, (len(whole.rows), len(whole.rows[0]))
        ticks = ClosedTicks(loop.ticks(parameters, kept)) if loop.in_ticks else None
        if ticks is None:
            stack = Enclosed.at_corners(model_of(whole.rows), chosen)
        else:
            stack = ticks.of.opened(chosen, kept.inputs)

        def around() -> MapParts:
            return parts_of(loop.map(parameters, kept) if loop.in_ticks else whole)

        return OpenCorners(
            order,
            size[0] - order,
            stack,
            around,
            kept.rest,
            tuple(chosen),
            len(sides),
            ticks,
            continuous=not loop.period,
        )

    def bend(self, sides: Sides, place: int) -> float:
        """Return how a loop bends along a box's side, by its middle; raises `UndecidedError`."""
        near = [(middle, middle) for middle in (middle_of(*side) for side in sides)]
        (low, high), (middle, _) = sides[place], near[place]
        near[place] = middle + _NEAR * (low - middle), middle + _NEAR * (high - middle)
        parameters = self._parameters([_polynomial(side, i) for i, side in enumerate(near)])
        return bend(self._loop.map(parameters), place)


def _polynomial(side: tuple[float, float], number: int) -> PolynomialBall:
    """Return a coordinate over a side, about its middle in double.

    It is one of a single value too: what varies is never rounded by a converter.
    """
    return PolynomialBall.about(middle_of(*side), _half(*side), number)


def middle_of(low: float, high: float) -> float:
    return 0.5 * low + 0.5 * high


def _half(low: float, high: float) -> float:
    """Return at least the distance from the middle to each end."""
    middle = middle_of(low, high)
    return max(high - middle, middle - low) * (1.0 + 2.0**-50)
