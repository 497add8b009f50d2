"""Search for a proof that a claim holds everywhere in a box: boxes are halved until each contracts in a norm.

Boxes have an order, in which halves follow their whole, the upper one first. The outcome is that of
looking at them in this order, however many are looked at ahead of their turn.

Under any change of the parameters one norm has to serve all of their box: their sides are halved
for its sake alone.

Processes look ahead: they are started once what is left is worth it.
"""

import itertools
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from proofmass.runner.design.proof.box_maps import middle_of
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import ProvedRegion, Sides
from proofmass.runner.design.proof.look import NOT_IN_ONE, STAYS, Looked, halved, widths
from proofmass.runner.design.proof.passages import halved_places, too_soon
from proofmass.runner.design.proof.rest_maps import TIME_IS_UP
from proofmass.runner.design.proof.rest_norm import Start
from proofmass.runner.host.forked import Forked

WORTH_SECONDS = 0.5  # of looks here, before processes are started: these take 30 ms, and as much again to warm up
_WAITS = 0.05  # seconds between looks at the time


@dataclass(eq=False)
class BoxPart:
    """A box in the order of a search: its halves follow it."""

    claim: Claim
    whole: Sides
    box: Sides
    start: Start | None
    make: Callable[[Sides, Start | None], "BoxPart"]  # a half
    looks: bool = True  # else it is halved without a look
    halves: "list[BoxPart]" = field(default_factory=list)
    looked: Looked | None = None
    begun: bool = False
    here: bool = False  # this process has to look at it: another met an exception

    def answered(self, looked: Looked) -> None:
        """Take what came of it."""
        self.looked, self.halves = looked, [self.make(half, looked.start) for half in looked.halves]

    def open(self) -> "Iterator[BoxPart]":
        """Yield the parts of it that nobody looks at, in their order."""
        if self.looks and not self.begun and self.looked is None:
            yield self
        for half in reversed(self.halves):
            yield from half.open()


class LooksAhead:
    """Looks at boxes for the claims about a loop or path, in this process or in some others."""

    def __init__(self, look: Callable[[Claim, Sides, Sides, Start | None], Looked], workers: int) -> None:
        self._look, self._workers, self._spent = look, workers, 0.0
        self._forked: Forked | None = None

    @property
    def died(self) -> int:
        """Number of processes that ended early."""
        return 0 if self._forked is None else self._forked.died

    def look(self, part: BoxPart, left: Sequence[BoxPart], is_late: Callable[[], bool], must: bool) -> None:
        """Look at a part, and ahead at what is left: not if it is late, unless the part `must` be looked at.

        Raises `ModelError` of a sensor within.
        """
        while part.looked is None:
            late = is_late()
            if late and not must:
                return
            if late or part.here or not self._started(part, left):
                begin = time.monotonic()
                part.answered(self._look(part.claim, part.whole, part.box, part.start))
                self._spent += time.monotonic() - begin
            else:
                self._wait(part, left)

    def _started(self, part: BoxPart, left: Sequence[BoxPart]) -> bool:
        """Return whether there are processes, started for several parts that take long."""
        if self._forked is None and self._workers > 1 and left and self._spent > WORTH_SECONDS:
            self._forked = Forked(self._look, self._workers)
        return self._forked is not None and self._forked.count > 0

    def _wait(self, part: BoxPart, left: Sequence[BoxPart]) -> None:
        assert self._forked is not None
        waiting = (one for first in (part, *reversed(left)) for one in first.open())
        while self._forked.idle and (one := next(waiting, None)) is not None:
            one.begun = True
            self._forked.begin(one, (one.claim, one.whole, one.box, one.start))
        for answer in self._forked.arrived(_WAITS):
            answer.place.begun = not answer.died
            if answer.value is not None:
                answer.place.answered(answer.value)
            elif not answer.died:
                answer.place.here = True

    def close(self) -> None:
        """End the processes."""
        if self._forked is not None:
            self._forked.close()


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
        """Return a proof, where it fails, or how far it came; raises `ModelError` of a sensor."""
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
            return ended("open", late[0], TIME_IS_UP)
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
        """Return a point that breaks the claim, of boxes not looked at, while there is time."""
        for place in range(len(left) - 1, -1, -1) if why != STAYS else ():
            part = left[place]
            self.ahead.look(part, left[:place], self.is_late, must=False)
            if part.looked is None:
                break
            if part.looked.broken is not None:
                return part.looked.broken
        return None

    def _towards_known(self, box: Sides) -> list[Sides]:
        """Return halves of a box with some known parts, none if it has none or is one."""
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
