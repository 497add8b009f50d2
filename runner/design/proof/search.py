"""Search for a proof that a claim holds everywhere in a box: boxes are halved until each contracts in a norm.

Boxes have an order, in which halves follow their whole, the upper one first. The outcome is that of looking at them in
this order, however many are looked at ahead of their turn.

Under any change of the parameters one norm has to serve all of their box: their sides are halved for its sake alone.
"""

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from proofmass.runner.design.proof.ahead import BoxPart, LooksAhead
from proofmass.runner.design.proof.box_maps import middle_of
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.look import NOT_IN_ONE, STAYS, halved, widths
from proofmass.runner.design.proof.passages import halved_places, too_soon
from proofmass.runner.design.proof.region import ProvedRegion
from proofmass.runner.design.proof.rest_norm import Start

_TIME_IS_UP = "the time is up"


@dataclass(frozen=True)
class Searched:
    """Outcome of a search: `leaves` cover the box if it is proved; at the middle of the box `at` it is not stable."""

    status: str  # "proved", "refuted" or "open"
    leaves: tuple[ProvedRegion, ...]
    boxes: int  # that were looked at
    part: float  # of the box that is proved
    at: Sides | None = None
    why: str = ""


@dataclass(frozen=True)
class ProofSearch:
    """A search for a proof of a claim over all of a box."""

    claim: Claim
    whole: Sides
    ahead: LooksAhead
    is_late: Callable[[], bool]  # whether to end with what there is
    known: Mapping[Sides, Start] = field(default_factory=dict)  # boxes that an earlier search proved, with their norms

    def outcome(self) -> Searched:
        """Return a proof, or where it fails, or how far it came; raises `ModelError` of a sensor within."""
        left = [self._part(self.whole, None)]
        leaves, boxes, late = list[ProvedRegion](), 0, list[Sides]()

        def ended(status: str, at: Sides | None, why: str = "") -> Searched:
            covered = sum(float(np.prod([w for w in widths(leaf.core, self.whole) if w])) for leaf in leaves)
            return Searched(status, tuple(leaves), boxes, covered, at, why)

        while left or self._halve_too_soon(leaves, left):
            part = left.pop()
            if part.looks:
                self.ahead.look(part, left, self.is_late, must=not boxes or part.box in self.known)
                looked = part.looked
                if looked is None:
                    late.append(part.box)
                    continue
                boxes += 1
                if looked.region is not None:
                    leaves.append(looked.region)
                    continue
                broken = looked.broken if looked.halves or looked.broken else self._broken_among(left, looked.why)
                if broken is not None:
                    return ended("refuted", broken)
                if not looked.halves:
                    return ended("open", part.box, looked.why)
            left += part.halves
        if late:
            return ended("open", late[0], _TIME_IS_UP)
        if self.claim.in_one_norm and not _have_one_norm(leaves):
            return Searched("open", (), boxes, 0.0, None, NOT_IN_ONE)
        return Searched("proved", tuple(leaves), boxes, 1.0)

    def _halve_too_soon(self, leaves: list[ProvedRegion], left: list[BoxPart]) -> bool:
        """Put the halves of leaves that others may follow too soon in their place; return whether there are any."""
        if not self.claim.in_parts:
            return False
        radius = self.claim.discs(self.whole[-1])[0].radius
        places = halved_places(too_soon(leaves, self.claim.changes, radius), self.whole)
        left += [self._part(half, None) for core, place in places.items() for half in halved(core, place)]
        leaves[:] = [leaf for leaf in leaves if leaf.core not in places]
        return bool(places)

    def _part(self, box: Sides, start: Start | None) -> BoxPart:
        """Return a box as a part, with its halves where these need no look at it."""
        free = self._towards_known(box)  # what is known is kept, whatever the time
        if not free and box[-1][1] - box[-1][0] > self.claim.row.wire.widest:
            free = halved(box, len(box) - 1)
        if free:
            halves = [self._part(half, start) for half in free]
            return BoxPart(self.claim, self.whole, box, start, self._part, looks=False, halves=halves)
        begin = start if start is not None and start.alone else self.known.get(box, start)
        return BoxPart(self.claim, self.whole, box, begin, self._part)

    def _broken_among(self, left: Sequence[BoxPart], why: str) -> Sides | None:
        """Return a point that breaks the claim, of boxes that were not looked at, while there is time."""
        for place in range(len(left) - 1, -1, -1) if why != STAYS else ():
            part = left[place]
            self.ahead.look(part, left[:place], self.is_late, must=False)
            if part.looked is None:
                break
            if part.looked.broken is not None:
                return part.looked.broken
        return None

    def _towards_known(self, box: Sides) -> list[Sides]:
        """Return halves of a box of which some parts are known, none if it has no such parts or is one."""
        pairs = ((one, zip(one, box, strict=True)) for one in self.known)
        within = [one for one, ends in pairs if all(low <= a and b <= high for (a, b), (low, high) in ends)]
        if not within or box in self.known:
            return []
        for place, (low, high) in enumerate(box):
            middle = middle_of(low, high)
            ends = [one[place] for one in within]
            if low < middle < high and all(b <= middle or a >= middle for a, b in ends):
                return halved(box, place)
        return []


def _have_one_norm(leaves: Sequence[ProvedRegion]) -> bool:
    """Return whether boxes of all parameters have one norm for each part of the factors."""
    norms = {leaf.box[-1]: leaf.transform for leaf in leaves}
    apart = all(one[1] <= other[0] for one, other in itertools.pairwise(sorted(norms)))
    return apart and all(np.array_equal(leaf.transform, norms[leaf.box[-1]]) for leaf in leaves)
