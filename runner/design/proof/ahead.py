"""Boxes that are looked at ahead of their turn, by processes: they are started once what is left is worth it."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.look import Looked
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
        """Return whether there are processes, which are started for several parts that take long."""
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
