"""Switches that wait before they change a loop: choppers, sequences and pulses.

A map over one common period is the same in the next ones until a counter is full or a source that
stood still moves. So what follows from the time alone is run on beyond the operating point, by
itself, and the map is compared where something that stood still has changed. A block that is given
the time beside signals, as a gate, goes on with them, its signals held. Where a block that signals
reach counts, or moves with the time between ticks, the map is compared after 2, 4, 8 and so on
periods too.
"""

from collections.abc import Callable, Mapping, Sequence
from collections.abc import Set as AbstractSet

import numpy as np
import numpy.typing as npt

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.numbers import time_text
from proofmass.runner.analysis.linearisation.rings import Rings
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS
from proofmass.runner.derivatives.dual_noise import changing, given, reached
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import BufferBinding, Deviate, StateBinding, Tick, Time
from proofmass.runner.plan.memory import Memory

_CHANGES, _LOOKS = 3, 8  # compared changes of one number, and comparisons in all
_SHORT, _SHORT_TURN = 1024, 32  # base ticks and periods of the first search
_NEXT = 64  # periods among which one is looked for that differs from the first two
_ROWS = 256  # that are compared at a time
_ROUNDING = 1e-9  # part of the size of a number below which a change counts as rounding


class Waiting:
    """The blocks that may stand still, and then change what a period does to small signals."""

    def __init__(
        self,
        onward: Onward,
        upstream: AbstractSet[str],
        moving: AbstractSet[str],
        ticks: int,
        entries: Sequence[Endpoint],
        rings: Rings = NO_RINGS,
    ) -> None:
        """Take the blocks that outputs depend on, those that small signals reach, where these enter, and a period."""
        plan = onward.course.plan
        self._entries = entries
        self._onward, self._ticks, self._rings = onward, ticks, rings
        apart = upstream - moving
        slow = {n for s in plan.solvers if not s.exact or {*s.group.blocks} - apart for n in s.group.blocks}
        self._alone = apart - reached(plan, slow | given(plan, (Deviate,)))
        self._others = sorted(upstream - self._alone)
        timed = given(plan, (Time, Tick)).intersection(self._others)
        between_ticks = {name for name in timed if type(plan.blocks[name]).continuous()}
        self._timed, self._between_ticks = timed - between_ticks, bool(between_ticks)
        following = (self._alone & changing(plan, (StateBinding, BufferBinding, Time, Tick))) | self._timed
        self._wires = [
            (name, port)
            for name in sorted(following)
            for port, declared in type(plan.blocks[name]).outputs.items()
            if not declared.shape
        ]

    def sources(self, periods: int) -> Array:
        """Return what sources say in each tick of some periods: a row each, and a column."""
        if not self._wires:
            return np.zeros((periods, 0))
        rows = self._onward.wires(self._wires, periods * self._ticks, self._alone, self._timed, self._entries)
        return rows.reshape(periods, -1)

    def stands(self) -> bool:
        """Return whether nothing that follows from the time has moved one period on."""
        return not self._between_ticks and not self._moved(1).any()

    def changes(self, after: Callable[[int], Memory], periods: int) -> list[int]:
        """Return the numbers of periods, up to some, after which the map is to be compared; none if nothing waits."""
        counted = self._between_ticks or self._integers(after(1)) != self._integers(after(0))
        doubled = [1 << k for k in range(1, periods.bit_length())] if counted else []
        if periods < 2 or not self._wires:
            return doubled
        moved = self._moved(min(periods, max(2, _SHORT // self._ticks)))
        if len(moved) < periods and not moved.all():  # some number stands still for now
            moved = self._moved(periods)
        events = moved[1:] & ~moved[:-1]  # movements after a standstill
        order = np.cumsum(events, axis=0) * events
        found = [np.flatnonzero((order == k).any(axis=1)) + 2 for k in range(1, _CHANGES + 1)]
        return sorted({*doubled, *dict.fromkeys(np.concatenate(found).tolist()[:_LOOKS])})

    def apart(self, periods: int) -> list[int]:
        """Return a period, of up to so many, in which sources are well apart from where they are in
        the first two.

        Maps of these may be alike by chance, as on both sides of a carrier's peak. A carrier counts
        by its size, since its sign may not matter: none is returned where that stays as it is.
        """
        sizes = np.abs(self.sources(min(periods, _NEXT)))
        if len(sizes) < 3 or not sizes.shape[1]:
            return []
        swing = np.maximum(np.ptp(sizes, axis=0), 1e-300)
        apart = np.minimum(*(np.max(np.abs(sizes - sizes[first]) / swing, axis=1) for first in (0, 1)))
        return [int(np.argmax(apart >= 0.5 * np.max(apart)))] if np.max(apart) > _ROUNDING else []

    def _moved(self, periods: int) -> npt.NDArray[np.bool_]:
        """Return whether each of the sources' values differs from the one a period before."""
        values = self.sources(periods + 1)
        return np.abs(np.diff(values, axis=0)) > _ROUNDING * np.maximum(np.abs(values[1:]), np.abs(values[:-1]))

    def repetition(self, periods: int, known: Mapping[int, Memory]) -> int:
        """Return the number of periods, up to some, after which all switches do as before; 0 if there is none.

        A short one is taken where it also says what is `known` of later periods.
        """
        told = self.sources(2 * periods)
        for longest in dict.fromkeys((min(_SHORT_TURN, periods), periods)):
            if not _may_return(np.array(self._counted(1 + longest), dtype=float), told):
                continue  # half of the run is enough to see that nothing comes again
            rows = self._counted(2 * longest)
            counts = np.array(rows, dtype=float).reshape(len(rows), -1)
            number = _repetition(np.hstack([told[: 2 * longest] if longest < periods else told, counts]), longest)
            if number and (longest == periods or self._says(rows, number, known, told)):
                return number
        return 0

    def _counted(self, periods: int) -> list[list[int]]:
        """Return the integers after so many periods; without any, nothing runs."""
        return self._onward.integers(self._others, self._rings, self._ticks, periods)

    def _says(self, rows: list[list[int]], number: int, known: Mapping[int, Memory], told: Array) -> bool:
        """Return whether a repetition goes on as it begins."""
        later = {period: self._integers(memory) for period, memory in known.items()}
        turning = np.flatnonzero(_turning(np.array(rows, dtype=float).reshape(len(rows), -1))).tolist()
        alike = all(row[i] == rows[period % number][i] for period, row in later.items() for i in turning)
        told = told[:, _turning(told)]
        return alike and _comes_again(told, number, _rounding(told))

    def _integers(self, memory: Memory) -> list[int]:
        return self._rings.integers_of(memory, self._others)


def switch_note(seconds: float) -> str:
    """Return the note on a switch that waits for some seconds."""
    return f"a switch changes it within {time_text(seconds)}: this is what holds until then"


def _turning(values: Array) -> npt.NDArray[np.bool_]:
    """Return which columns go up and down: not what only counts, or settles."""
    steps = np.diff(values, axis=0)
    return np.asarray((steps > 0.0).any(axis=0) & (steps < 0.0).any(axis=0))


def _may_return(counts: Array, told: Array) -> bool:
    """Return whether what turns has its first values again in a later row; of what only counts nothing does.

    What does not turn in the longest repetition turns in no later one. Sources are told for twice
    as long.
    """
    counts = counts[:, _turning(counts)]
    if not counts.shape[1]:
        return bool(_turning(told).any())
    return bool((counts[1:] == counts[0]).all(axis=1).any())


def _repetition(values: Array, longest: int) -> int:
    """Return after how many rows those that turn come again, to the last; 0 if it is more than the longest."""
    values = values[:, _turning(values)]
    if not values.shape[1]:
        return 0
    near = _rounding(values)
    alike = np.flatnonzero((np.abs(values[1 : longest + 1] - values[0]) <= near).all(axis=1)) + 1
    return next((n for n in alike.tolist() if _comes_again(values, n, near)), 0)


def _comes_again(values: Array, number: int, near: Array) -> bool:
    """Return whether all rows come again after some: most that do not, differ among the first."""
    later = values[number:]
    parts = (slice(first, first + _ROWS) for first in range(0, len(later), _ROWS))
    return all((np.abs(later[part] - values[: len(later)][part]) <= near).all() for part in parts)


def _rounding(values: Array) -> Array:
    return np.asarray(_ROUNDING * np.max(np.abs(values), axis=0, initial=0.0))
