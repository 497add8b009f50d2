"""Maps of a loop, path or output over boxes of parameters: at their corners, and how far others lie beyond.

Boxes that are halved have corners in common, of which each is computed once.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

import flint
import numpy as np

from proofmass.runner.derivatives.ball import ball
from proofmass.runner.derivatives.dual import plain
from proofmass.runner.derivatives.polynomial import PolynomialBall
from proofmass.runner.design.proof.ball_map import BallMap, Kept, Starting
from proofmass.runner.design.proof.ball_ticks import coordinate
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.closed_loop import ClosedTicks, Jets, OpenCorners, bends, jets_of
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.enclosed import Enclosed

_Parameters = Callable[[Sequence[Any]], Mapping[str, Any]]  # all that moves, at some coordinates
_Key = TypeVar("_Key")
_Value = TypeVar("_Value")
_Corner = tuple[Any, ...]  # its coordinates, and what is kept there
MOST_CORNERS = 9  # coordinates whose ends are looked at together
_SLICES = 8  # in which second derivatives are bounded one by one
_KEPT, _KEPT_CORNERS = 256, 16_384  # maps of boxes, and of corners


class BoxMaps:
    """Maps of a loop or path over boxes; halves along the factor share those of the parameters."""

    def __init__(self, loop: Starting, parameters: _Parameters) -> None:
        self._loop, self._parameters, self.values = loop, parameters, loop.values
        self._known: dict[Sides, OpenCorners] = {}
        self._corners: dict[_Corner, Enclosed] = {}

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
        """Return the open loops of a box of parameters."""
        if sides not in self._known:
            _remember(self._known, sides, self._over(sides), _KEPT)
        return self._known[sides]

    def _over(self, sides: Sides) -> OpenCorners:
        wide = [i for i, (low, high) in enumerate(sides) if low < high]
        chosen, in_ticks = wide[:MOST_CORNERS], self._loop.in_ticks
        whole = self._loop.map(self._parameters([ball(*side) for side in sides])) if in_ticks else self._dual(sides)
        ticks = self._ticks(sides, chosen, whole.kept) if in_ticks else None

        def around() -> tuple[Jets, ...]:
            with_slopes = self._dual(sides, whole.kept) if in_ticks else whole
            bent = int(np.argmax(bends(with_slopes, widths_of(sides)))) if sides else 0
            maps = [self._dual(part, whole.kept) for part in _slices(sides, bent)] if sides else [with_slopes]
            return tuple(map(jets_of, maps))

        corners = []
        for place in itertools.product((0, 1), repeat=len(chosen)):
            ends = dict(zip(chosen, place, strict=True))
            points = [side[ends[i]] if i in ends else middle_of(*side) for i, side in enumerate(sides)]
            corners.append(self._corner(whole.kept, tuple(points)))
        order, values, rest = whole.order, len(whole.rows) - whole.order, whole.kept.rest
        return OpenCorners(order, values, Enclosed.stacked(corners), around, rest, tuple(chosen), ticks)

    def _ticks(self, sides: Sides, interpolated: Sequence[int], kept: Kept) -> ClosedTicks:
        """Return the ticks over a box; coordinates that are not interpolated are at the corners' middle in double."""
        values = [
            PolynomialBall.coordinate(*side, i)
            if i in interpolated
            else PolynomialBall({(): flint.arb(middle_of(*side)), (i,): flint.arb(half)})
            for i, (side, half) in enumerate(zip(sides, widths_of(sides), strict=True))
        ]
        return ClosedTicks(self._loop.ticks(self._parameters(values), kept))

    def _corner(self, kept: Kept, points: tuple[float, ...]) -> Enclosed:
        key = points, kept.states, kept.inputs, kept.outputs
        if kept.rest is None and key in self._corners:
            return self._corners[key]
        found = self._loop.map(self._parameters([ball(point, point) for point in points]), kept)
        corner = Enclosed.of_balls([[[plain(value) for value in row] for row in found.rows]])
        if kept.rest is None:  # a point of rest lies within that of its own box
            _remember(self._corners, key, corner, _KEPT_CORNERS)
        return corner

    def bends(self, sides: Sides) -> list[float]:
        """Return how far the loop bends along each side of a box, by its middle; raises `UndecidedError`."""
        middle = tuple((middle_of(*side), middle_of(*side)) for side in sides)
        return bends(self._dual(middle), widths_of(sides))

    def _dual(self, sides: Sides, kept: Kept | None = None) -> BallMap:
        """Return the map over a box, with its derivatives, of what is `kept`."""
        return self._loop.map(self._parameters([coordinate(ball(*side), i) for i, side in enumerate(sides)]), kept)


def _remember(known: dict[_Key, _Value], key: _Key, value: _Value, most: int) -> None:
    """Put something into what is known, the oldest of which goes where that is too much."""
    while len(known) >= most:
        del known[next(iter(known))]
    known[key] = value


def _slices(box: Sides, place: int) -> list[Sides]:
    """Return the slices of a box along one side."""
    low, high = box[place]
    ends = [low + (high - low) * part / _SLICES for part in range(_SLICES)] + [high]
    return [(*box[:place], side, *box[place + 1 :]) for side in itertools.pairwise(ends)]


def middle_of(low: float, high: float) -> float:
    return 0.5 * low + 0.5 * high


def widths_of(box: Sides) -> list[float]:
    """Return at least the half of each side of a box."""
    return [_half(*side) for side in box]


def _half(low: float, high: float) -> float:
    """Return at least the distance from the middle to each end."""
    middle = middle_of(low, high)
    return max(high - middle, middle - low) * (1.0 + 2.0**-50)
