"""Search for a proof that a loop is stable everywhere in a box: boxes are halved until each contracts in a norm.

The poles of a claim lie in a disc, or in one of several: the norm is that of the matrices moved into it.

Under any change of the parameters one norm has to serve all of their box: their sides are halved for its sake alone.

A box is halved along the coordinate that lies furthest beyond its corners, or, where these do not contract, along the
one that moves most. Halves begin with the norm of the whole.
"""

import itertools
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Any

import flint
import numpy as np

from proofmass.runner.derivatives.ball import BITS, UndecidedError, ball
from proofmass.runner.design.proof.at_rest import keeps_side, none_settles
from proofmass.runner.design.proof.ball_bias import RestingOutput
from proofmass.runner.design.proof.ball_map import BallMap, Kept, StartingLoop, coordinate
from proofmass.runner.design.proof.ball_noise import StartingNoise
from proofmass.runner.design.proof.ball_path import StartingPath
from proofmass.runner.design.proof.claim import PEAK, Claim
from proofmass.runner.design.proof.closed_loop import Family, OpenCorners, Region, bends, open_loops
from proofmass.runner.design.proof.contraction import Norm, first_norm, outer_corner, radius_of
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.rest_norm import Start

Starting = StartingLoop | StartingPath | StartingNoise | RestingOutput
_Parameters = Callable[[Sequence[Any]], Mapping[str, Any]]  # all that moves, at some coordinates
MOST_CORNERS = 9  # coordinates whose ends are looked at together
_SLICES = 8  # in which second derivatives are bounded one by one
_FINEST = 1e-6  # part of a side of the first box below which none is halved
_KEPT = 4_096  # maps of boxes
_FACTORS_FIRST = 16.0  # how much finer factors are halved than parameters
_AT_THE_BOUNDARY = "a pole lies too near the boundary of stability"
_AT_THE_LIMIT = "the value of a sensor lies too near the limit"
_NOT_IN_ONE = "no norm is found that serves all of the tolerances at once"
_TOGETHER = "a wire has several values in a period: all frequencies that one of them shows at count together"
_STAYS = "something on the way does not decay, though it may not show"
_NEARLY = 1e-5  # by which a norm at the corners may be below one before another is looked for


@dataclass(frozen=True)
class ProvedRegion:
    """A box that contracts, and its norm."""

    box: Sides
    norm: Norm
    loops: OpenCorners  # opened, of the parameters of the box
    disc: Region  # in which all poles lie


@dataclass(frozen=True)
class Searched:
    """Outcome of a search: `leaves` cover the box if it is proved; at the middle of the box `at` it is not stable."""

    status: str  # "proved", "refuted" or "open"
    leaves: tuple[ProvedRegion, ...]
    boxes: int  # that were looked at
    part: float  # of the box that is proved
    at: Sides | None = None
    why: str = ""


class BoxMaps:
    """Maps of a loop or path over boxes; halves along the factor share those of the parameters."""

    def __init__(self, loop: Starting, parameters: _Parameters) -> None:
        self._loop, self._parameters, self.values = loop, parameters, loop.values
        self._known: dict[Sides, OpenCorners] = {}

    def worst_corner(self, box: Sides, claim: Claim) -> Sides | None:
        """Return the corner of a box where a quantity is worst, if its value there lies beyond the limit."""
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
        points = [side[ends[i]] if i in ends else _middle(*side) for i, side in enumerate(box[:-1])]
        return (*((point, point) for point in points), box[-1])

    def open(self, sides: Sides) -> OpenCorners:
        """Return the open loops of a box of parameters."""
        if sides not in self._known:
            while len(self._known) >= _KEPT:
                del self._known[next(iter(self._known))]
            self._known[sides] = self._over(sides)
        return self._known[sides]

    def _over(self, sides: Sides) -> OpenCorners:
        whole = self._dual(sides)
        bent = int(np.argmax(bends(whole, widths_of(sides)))) if sides else 0
        around = [self._dual(part, whole.kept) for part in _slices(sides, bent)] if sides else [whole]
        wide = [i for i, (low, high) in enumerate(sides) if low < high]
        chosen = wide[:MOST_CORNERS]
        corners = []
        for place in itertools.product((0, 1), repeat=len(chosen)):
            ends = dict(zip(chosen, place, strict=True))
            points = [side[ends[i]] if i in ends else _middle(*side) for i, side in enumerate(sides)]
            corners.append(self._loop.map(self._parameters([ball(point, point) for point in points]), whole.kept))
        return open_loops(corners, around, chosen)

    def bends(self, sides: Sides) -> list[float]:
        """Return how far the loop bends along each side of a box, by its middle; raises `UndecidedError`."""
        middle = tuple((_middle(*side), _middle(*side)) for side in sides)
        return bends(self._dual(middle), widths_of(sides))

    def _dual(self, sides: Sides, kept: Kept | None = None) -> BallMap:
        """Return the map over a box, with its derivatives, of what is `kept`."""
        return self._loop.map(self._parameters([coordinate(ball(*side), i) for i, side in enumerate(sides)]), kept)


@dataclass(frozen=True)
class ProofSearch:
    """A search for a proof of a claim."""

    maps: BoxMaps
    claim: Claim
    breaks: Callable[[Sides], bool]  # whether the middle of a box breaks the claim: asked where no disc has its poles
    known: Mapping[Sides, Start] = field(default_factory=dict)  # boxes that an earlier search proved, with their norms

    def _refuted_at(self, box: Sides, norm: Norm | None) -> Sides | None:
        """Return a point of a box that breaks the claim: its middle if that may be, or a corner."""
        beside = self.claim.row.beside
        if (norm is None or radius_of(norm.family) >= 1.0 or (beside and norm.worst() >= 1.0)) and self.breaks(box):
            return box
        corner = self.maps.worst_corner(box, self.claim)
        if norm is not None and corner is None and (outer := outer_corner(norm.family)) is not None:
            corner = self.maps.corner(box, outer)
        return corner if corner is not None and self.breaks(corner) else None

    def _broken_among(self, left: Sequence[tuple[Sides, Start | None]], is_late: Callable[[], bool]) -> Sides | None:
        """Return a point that breaks the claim, of boxes that were not looked at, while there is time."""
        for box, start in reversed(left):
            if is_late():
                break
            with suppress(UndecidedError):
                broken = self._refuted_at(box, self._norm(box, start)[0])
                if broken is not None:
                    return broken
        return None

    @property
    def _stuck(self) -> str:
        if self.claim.any_change:
            return _NOT_IN_ONE
        if self.claim.kind == PEAK and self.maps.values > 1:
            return _TOGETHER
        return _AT_THE_LIMIT if self.claim.row.of_output else _AT_THE_BOUNDARY

    def _stays(self, box: Sides) -> bool:
        """Return whether no corner of a box settles, though the quantity does: halving does not help."""
        return self.claim.row.of_output and none_settles(self.maps.open(box[:-1]))

    def _keeps_side(self, norm: Norm) -> bool:
        left = norm.family.left
        return left is None or keeps_side(left, self.claim.most)

    def over(self, whole: Sides, until: float, stop: threading.Event | None) -> Searched:
        """Return a proof for all of a box, or where it fails, or how far it came by a time or a wish."""
        with flint.ctx.workprec(BITS):
            return self._over(whole, until, stop)

    def _over(self, whole: Sides, until: float, stop: threading.Event | None) -> Searched:
        left: list[tuple[Sides, Start | None]] = [(whole, None)]
        leaves, boxes, late = list[ProvedRegion](), 0, list[Sides]()

        def is_late() -> bool:
            return time.monotonic() > until or (stop is not None and stop.is_set())

        while left:
            box, start = left.pop()
            halves, why = self._towards_known(box), self._stuck
            if boxes and is_late() and not halves and box not in self.known:  # what is known is kept all the same
                late.append(box)
                continue
            if not halves and box[-1][1] - box[-1][0] > self.claim.row.wire.widest:
                halves = _halved(box, len(box) - 1)
            if not halves:
                boxes += 1
                try:
                    norm, disc = self._norm(box, start)
                except UndecidedError as error:
                    norm, disc, why = None, None, str(error)
                weights = _widths(box, whole) if norm is None else _weights(norm, box)
                if norm is not None and disc is not None and norm.contracts() and self._keeps_side(norm):
                    leaves.append(ProvedRegion(box, norm, self.maps.open(box[:-1]), disc))
                    continue
                broken = None if disc is None else self._refuted_at(box, norm)
                if broken is not None:
                    return Searched("refuted", tuple(leaves), boxes, _part(leaves, whole), broken)
                if disc is not None and (norm is None or radius_of(norm.family) >= 1.0):
                    weights[-1] *= _FACTORS_FIRST
                if disc is not None and self._stays(box):
                    return Searched("open", tuple(leaves), boxes, _part(leaves, whole), box, _STAYS)
                halves = _halves(box, weights, whole, self._sides(norm, box, whole))
                alone = self.claim.any_change and any(half[:-1] != whole[:-1] for half in halves)
                start = start if norm is None else Start(norm.transform, norm.family.left, alone)
            if not halves:
                broken = self._broken_among(left, is_late)
                if broken is not None:
                    return Searched("refuted", tuple(leaves), boxes, _part(leaves, whole), broken)
                return Searched("open", tuple(leaves), boxes, _part(leaves, whole), box, why)
            left += [(half, start) for half in halves]
        if late:
            return Searched("open", tuple(leaves), boxes, _part(leaves, whole), late[0], "the time is up")
        if self.claim.any_change and not _have_one_norm(leaves):
            return Searched("open", (), boxes, 0.0, None, _NOT_IN_ONE)
        return Searched("proved", tuple(leaves), boxes, 1.0)

    def _sides(self, norm: Norm | None, box: Sides, whole: Sides) -> range:
        """Return the sides that may be halved.

        Under any change these are those of parameters while the norm of all of them serves the corners, which then has
        to serve what lies between; else that of the factor.
        """
        last = len(box) - 1
        if not self.claim.any_change:
            return range(last + 1)
        serves = norm is not None and norm.family.noise is None and norm.worst() < 1.0
        return range(0 if serves else last, last + (box[:-1] == whole[:-1]))

    def _norm(self, box: Sides, start: Start | None) -> tuple[Norm | None, Region]:
        """Return a norm for the disc with most room for the middle of a box; none if no disc has all its poles.

        Raises `UndecidedError`.
        """
        row, discs, opened = self.claim.row, self.claim.discs(box[-1]), self.maps.open(box[:-1])
        if row.norm is not None:
            return row.norm(opened, box[-1][0], widths_of(box), self.known.get(box, start)), discs[0]
        family = row.family(opened, box[-1], widths_of(box))
        moved = [(disc.moved(family, row.wire.parts), disc) for disc in discs if not disc.empty]
        if not moved:
            return None, discs[0]
        best, disc = min(moved, key=lambda one: radius_of(one[0])) if len(moved) > 1 else moved[0]
        return _norm(best, start if start is not None and start.alone else self.known.get(box, start)), disc

    def _towards_known(self, box: Sides) -> list[Sides]:
        """Return halves of a box of which some parts are known, none if it has no such parts or is one."""
        within = [one for one in self.known if _is_within(one, box)]
        if not within or box in self.known:
            return []
        for place, (low, high) in enumerate(box):
            middle = _middle(low, high)
            ends = [one[place] for one in within]
            if low < middle < high and all(b <= middle or a >= middle for a, b in ends):
                return _halved(box, place)
        return []


def _have_one_norm(leaves: Sequence[ProvedRegion]) -> bool:
    """Return whether boxes of all parameters have one norm for each part of the factors."""
    norms = {leaf.box[-1]: leaf.norm.transform for leaf in leaves}
    apart = all(one[1] <= other[0] for one, other in itertools.pairwise(sorted(norms)))
    return apart and all(np.array_equal(leaf.norm.transform, norms[leaf.box[-1]]) for leaf in leaves)


def _norm(family: Family, start: Start | None) -> Norm | None:
    """Return a norm for a box, that of its whole if it serves; None where the middle does not decay."""
    given = None if start is None else Norm(start.transform, family)
    if start is not None and start.alone:
        return given
    if given is not None and (given.contracts() or given.worst() < 1.0 - _NEARLY):
        return given
    own = first_norm(family)
    norms = [norm for norm in (given, own) if norm is not None]
    return min(norms, key=Norm.worst).improved() if own is not None else None


def _weights(norm: Norm, box: Sides) -> list[float]:
    """Return what halving each side promises."""
    shares = [norm.shares.get(i, 0.0) for i in range(len(box))]
    if norm.family.noise is not None:
        moves = dict(
            zip([i for i, (low, high) in enumerate(box) if low < high][:MOST_CORNERS], norm.moves(), strict=True)
        )
        decays = max(1.0 - radius_of(norm.family) ** 2, 1e-12)  # both act against what the slowest pole loses
        return [2.0 * share + moves.get(i, 0.0) ** 2 / decays for i, share in enumerate(shares)]
    if norm.worst() < 1.0 and any(shares):
        return shares
    *sides, factor = (high > low for low, high in box)
    at_ends = [i for i, wide in enumerate(sides) if wide][:MOST_CORNERS] + [len(sides)] * factor
    moves = dict(zip(at_ends, norm.moves(), strict=True))
    return [moves.get(i, share) for i, share in enumerate(shares)]


def _slices(box: Sides, place: int) -> list[Sides]:
    """Return the slices of a box along one side."""
    low, high = box[place]
    ends = [low + (high - low) * part / _SLICES for part in range(_SLICES)] + [high]
    return [(*box[:place], side, *box[place + 1 :]) for side in itertools.pairwise(ends)]


def _middle(low: float, high: float) -> float:
    return 0.5 * low + 0.5 * high


def widths_of(box: Sides) -> list[float]:
    """Return at least the half of each side of a box."""
    return [_half(*side) for side in box]


def _half(low: float, high: float) -> float:
    """Return at least the distance from the middle to each end."""
    middle = _middle(low, high)
    return max(high - middle, middle - low) * (1.0 + 2.0**-50)


def _widths(box: Sides, whole: Sides) -> list[float]:
    return [(b - a) / (high - low) if high > low else 0.0 for (a, b), (low, high) in zip(box, whole, strict=True)]


def _halves(box: Sides, weights: Sequence[float], whole: Sides, sides: range) -> list[Sides]:
    """Return both halves along the one of some sides with the largest weight, none where all of them are too fine."""
    wide = [w if w > _FINEST and place in sides else 0.0 for place, w in enumerate(_widths(box, whole))]
    weighted = [w if width else 0.0 for w, width in zip(weights, wide, strict=True)]
    place = int(np.argmax(weighted if any(weighted) else wide))
    if not wide[place]:
        return []
    return _halved(box, place)


def _halved(box: Sides, place: int) -> list[Sides]:
    low, high = box[place]
    middle = _middle(low, high)
    return [(*box[:place], side, *box[place + 1 :]) for side in ((low, middle), (middle, high))]


def _is_within(box: Sides, whole: Sides) -> bool:
    return all(low <= a and b <= high for (a, b), (low, high) in zip(box, whole, strict=True))


def _part(leaves: Sequence[ProvedRegion], whole: Sides) -> float:
    """Return the part of a box that leaves cover."""
    return sum(float(np.prod([w for w in _widths(leaf.box, whole) if w])) for leaf in leaves)
