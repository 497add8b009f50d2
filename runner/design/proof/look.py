"""A look at one box: it contracts in a norm, a sensor in it breaks the claim, or its halves are
looked at instead.

The poles of a claim lie in a disc, or in one of several: the norm is that of the matrices moved
into it.

A box is halved along the coordinate that lies furthest beyond its corners, or, where these do not
contract, along the one that moves most. Halves begin with the norm of the whole. The answer follows
from the box and where it begins alone, whatever else was looked at and in whichever process.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from proofmass.runner.derivatives.ball import UndecidedError, enclosing
from proofmass.runner.design.proof.at_rest import keeps_side, none_settles
from proofmass.runner.design.proof.box_maps import MOST_CORNERS, BoxMaps, middle_of
from proofmass.runner.design.proof.claim import PEAK, Claim
from proofmass.runner.design.proof.closed_loop import Family
from proofmass.runner.design.proof.contraction import Norm, first_norm, in_frame, outer_corner, radius_of
from proofmass.runner.design.proof.coordinates import ProvedRegion, Sides, widened
from proofmass.runner.design.proof.half_plane import PoleRegion
from proofmass.runner.design.proof.rest_norm import Start
from proofmass.runner.host.arrays import Array

_FINEST = 1e-6  # part of a side of the first box below which none is halved
_PLACES_FIRST = 64.0  # how much finer places are halved than parameters
_FACTORS_FIRST = 16.0  # how much finer factors are halved than parameters
_AT_THE_BOUNDARY = "a pole lies too near the boundary of stability"
_AT_THE_LIMIT = "the value of a sensor lies too near the limit"
NOT_IN_ONE = "no norm is found that serves all of the tolerances at once"
_TOGETHER = "a wire has several values in a period: all frequencies that one of them shows at count together"
STAYS = "something on the way does not decay, though it may not show"
_ROUNDS = 3  # of norms, each in the coordinates of the one before
_HOPELESS = 8.0  # times the room that there is: what lies beyond the corners does not shrink so much with a better norm
_NEARLY = 1e-5  # by which a norm at the corners may be below one before another is looked for


@dataclass(frozen=True)
class Looked:
    """Outcome of a look at a box: the first of these that there is."""

    region: ProvedRegion | None = None  # it is proved
    broken: Sides | None = None  # at the middle of this box the claim fails
    halves: Sequence[Sides] = ()  # these are to be looked at
    start: Start | None = None  # from which they begin
    why: str = ""  # there is nothing more to look at


@dataclass(frozen=True)
class BoxLook:
    """The view of any part of a whole box for a claim."""

    maps: BoxMaps
    claim: Claim
    whole: Sides
    breaks: Callable[[Sides], bool]  # whether the middle of a box breaks the claim: asked where no disc has its poles

    def at(self, box: Sides, start: Start | None) -> Looked:
        """Return what comes of a box whose norm may be that of a start; raises `ModelError` of a sensor within."""
        with enclosing():
            return self._at(box, start)

    def _at(self, core: Sides, start: Start | None) -> Looked:
        norm, disc, why = None, None, self._stuck
        box = widened(core, self.whole, self.claim.changes) if self.claim.in_parts else core
        try:
            norm, disc = self._norm(box, start)
        except UndecidedError as error:
            why = str(error)
        weights = self._widths(core) if norm is None else _weights(norm, box)
        if norm is not None and disc is not None and norm.contracts():
            left = norm.family.left
            if left is None or keeps_side(left, self.claim.most):
                return Looked(self._region(core, box, norm, disc))
        broken = None if disc is None else self._refuted_at(box, norm)
        if broken is not None:
            return Looked(broken=broken)
        if disc is not None and (norm is None or radius_of(norm.family) >= 1.0):
            weights[-1] *= _FACTORS_FIRST
        if disc is not None and self._stays(box):
            return Looked(why=STAYS)
        halves = _halves(core, weights, self.whole, self._sides(norm, core))
        if self.claim.in_parts:  # whose norms are to follow from where they are
            return Looked(halves=halves, why=why)
        alone = self.claim.in_one_norm and any(half[:-1] != self.whole[:-1] for half in halves)
        begin = start if norm is None else Start(norm.of_states, norm.family.left, alone)
        return Looked(halves=halves, start=begin, why=why)

    def _widths(self, core: Sides) -> list[float]:
        """Return the parts of the sides that are left, of places first: what is known of a sensor follows them most."""
        parts = widths(core, self.whole)
        first = len(parts) - 1 - self.maps.places
        return [*parts[:first], *(_PLACES_FIRST * part for part in parts[first:-1]), parts[-1]]

    def _region(self, core: Sides, box: Sides, norm: Norm, disc: PoleRegion) -> ProvedRegion:
        if self.claim.in_parts:
            norm, disc = norm.tightened(disc, self.claim.row.wire.parts)
        family = norm.family
        loops = (family.opened or self.maps.open(box[:-1])).proving
        beyond, left, noise = disc.beyond(family), family.left, family.beyond_noise
        bends = norm.bend * disc.radius * (1.0 + 2.0**-39) if norm.bent else 0.0
        return ProvedRegion(core, box, norm.transform, beyond, bends, family.shift, left, noise, loops, disc)

    def _refuted_at(self, box: Sides, norm: Norm | None) -> Sides | None:
        """Return a point of a box that breaks the claim: its middle if that may be, or a corner."""
        beside = self.claim.row.beside
        if (norm is None or radius_of(norm.family) >= 1.0 or (beside and norm.worst() >= 1.0)) and self.breaks(box):
            return box
        corner = self.maps.worst_corner(box, self.claim)
        if norm is not None and corner is None and (outer := outer_corner(norm.family)) is not None:
            corner = self.maps.corner(box, outer)
        return corner if corner is not None and self.breaks(corner) else None

    @property
    def _stuck(self) -> str:
        if self.claim.in_one_norm:
            return NOT_IN_ONE
        if self.claim.kind == PEAK and self.maps.values > 1:
            return _TOGETHER
        return _AT_THE_LIMIT if self.claim.row.of_output else _AT_THE_BOUNDARY

    def _stays(self, box: Sides) -> bool:
        """Return whether no corner of a box settles, though the quantity does: halving is idle."""
        return self.claim.row.of_output and none_settles(self.maps.open(box[:-1]))

    def _sides(self, norm: Norm | None, box: Sides) -> range:
        """Return the sides that may be halved.

        Under any change these are those of parameters while the norm of all of them serves the
        corners, which then has to serve what lies between; else that of the factor.
        """
        last = len(box) - 1
        if not self.claim.in_one_norm:
            return range(last + 1)
        serves = norm is not None and norm.family.noise is None and norm.worst() < 1.0
        return range(0 if serves else last, last + (box[:-1] == self.whole[:-1]))

    def _norm(self, box: Sides, start: Start | None) -> tuple[Norm | None, PoleRegion]:
        """Return a norm for the disc with most room for the middle of a box; none if no disc has all its poles.

        Raises `UndecidedError`.
        """
        row, discs, opened = self.claim.row, self.claim.discs(box[-1]), self.maps.open(box[:-1])
        if row.norm is not None:
            return row.norm(opened, box[-1][0], start), discs[0]
        family = row.family(opened, box[-1])
        moved = [(disc.moved(family, row.wire.parts), disc) for disc in discs if not disc.empty]
        if not moved:
            return None, discs[0]
        best, disc = min(moved, key=lambda one: radius_of(one[0])) if len(moved) > 1 else moved[0]
        if best.opened is None or self.claim.moves:  # what moves needs one set of coordinates for all parts of the box
            return _norm(best, start), disc

        def framed(frame: Array) -> Family:
            return disc.moved(row.family(opened.framed(frame), box[-1]), row.wire.parts)

        return _norm_in_frame(best, start, lambda transform: in_frame(transform, framed, row.wire.parts)), disc


def _norm(family: Family, start: Start | None) -> Norm | None:
    """Return a norm for a box, that of its whole if it serves; None if the middle grows."""
    given = None if start is None else Norm(start.transform, family)
    if start is not None and start.alone:
        return given
    if given is not None and (given.contracts() or given.worst() < 1.0 - _NEARLY):
        return given
    own = first_norm(family)
    norms = [norm for norm in (given, own) if norm is not None]
    return min(norms, key=Norm.worst).improved() if own is not None else None


def _norm_in_frame(family: Family, start: Start | None, framed: Callable[[Array], Norm]) -> Norm | None:
    """Return a norm in whose own coordinates what lies beyond the corners is bounded; None as `_norm` does."""
    own = first_norm(replace(family, shares={}))
    if own is None:
        return None
    norms = [] if start is None else [_followed(framed(start.transform), framed)]
    if not (norms and norms[0].contracts()):
        norms.append(_followed(framed(own.improved().transform), framed))
    return min(norms, key=lambda norm: norm.worst() + norm.beyond)


def _followed(norm: Norm, framed: Callable[[Array], Norm]) -> Norm:
    """Return a norm that contracts, or one with more room, of some that each begin in the coordinates of the last."""
    for _ in range(_ROUNDS):
        if norm.contracts() or norm.beyond > _HOPELESS * (1.0 - norm.worst()) > 0.0:
            break
        norm = framed(norm.improved().of_states)
    return norm


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


def widths(box: Sides, whole: Sides) -> list[float]:
    return [(b - a) / (high - low) if high > low else 0.0 for (a, b), (low, high) in zip(box, whole, strict=True)]


def _halves(box: Sides, weights: Sequence[float], whole: Sides, sides: range) -> list[Sides]:
    """Return both halves along the one of some sides with the largest weight, none where all of them are too fine."""
    wide = [w if w > _FINEST and place in sides else 0.0 for place, w in enumerate(widths(box, whole))]
    weighted = [w if width else 0.0 for w, width in zip(weights, wide, strict=True)]
    place = int(np.argmax(weighted if any(weighted) else wide))
    if not wide[place]:
        return []
    return halved(box, place)


def halved(box: Sides, place: int) -> list[Sides]:
    low, high = box[place]
    middle = middle_of(low, high)
    return [(*box[:place], side, *box[place + 1 :]) for side in ((low, middle), (middle, high))]
