"""Numbers that ticks leave as they are, as cells of a delay, sums and results of a period: one row of lanes shows it.

A direction of its own for each of thousands would say 1 there and nothing elsewhere. Instead all
begin in the same row: with the slope 1 in its last lane, and with NaN in some of the other lanes,
which are other ones for each number. NaN goes wherever the number has any effect, and nothing
cancels it. So a number without an effect on others, and with itself as its only effect, is known by
a row that is as it began.
"""

from collections.abc import Iterator
from functools import cache
from itertools import combinations, islice
from math import comb

import numpy as np

from proofmass.runner.host.arrays import AnyArray, Truths
from proofmass.runner.targets.found_slopes import LANES, Found

_APART = LANES - 1  # lanes of NaN, of which each number has its own half
_MOST = comb(_APART, _APART // 2)  # numbers that these tell apart
_LONGEST = 64  # parts of a run for which all are followed, after rows that were not as they began


@cache
def _own_lanes() -> AnyArray:
    """Return the beginnings of as many numbers as can be told apart, a row each."""
    rows = np.zeros((_MOST, LANES))
    rows[:, -1] = 1.0
    for row, lanes in zip(rows, _halves(), strict=True):
        row[list(lanes)] = np.nan
    return rows


def _halves() -> Iterator[tuple[int, ...]]:
    return islice(combinations(range(_APART), _APART // 2), _MOST)


class StillNumbers:
    """Numbers that are taken to be still in the ticks that follow: those that were so in the last ones.

    Where that was wrong, all are followed for some time, and for twice as long if it is wrong again.
    """

    def __init__(self, size: int) -> None:
        self.now: Truths = np.zeros(size, dtype=bool)
        self._pause = self._patience = 1  # parts of a run

    def begins(self, wide: int) -> AnyArray:
        """Return what slopes of all numbers and some more begin as in the row of those that are still."""
        rows = np.zeros((wide, LANES))
        places = np.flatnonzero(self.now)
        rows[places] = _own_lanes()[: len(places)]
        return rows

    def moved(self) -> None:
        """Take none to be still for some time, since one was not."""
        self.now[:] = False
        self._pause, self._patience = self._patience, min(2 * self._patience + 1, _LONGEST)

    def choose(self, found: Found, live: Truths, ticks: int, events: int) -> None:
        """Take those that some ticks have left as they were, if that saves rows, with the directions of some events."""
        if self.now.any() and ticks > 1:
            self._patience = 0
        if self._pause:
            self._pause -= 1
            return
        self.now[:] = False
        size, followed = len(self.now), int(live.sum()) + events
        if followed <= 2 * LANES:  # nothing to save
            return
        own = found.column < size
        as_it_was = own & (found.row == found.column) & (found.value == 1.0)
        alone, all_of = (np.bincount(found.column[of], minlength=size) for of in (as_it_was, own))
        still = np.flatnonzero(live & (alone == ticks) & (all_of == ticks))[:_MOST]
        if -(-(followed - len(still)) // LANES) + 1 < -(-followed // LANES):
            self.now[still] = True
