"""Ticks with noise in machine code: what numbers that last, random numbers and errors of roundings
do, over some ticks.

Random numbers and roundings are events of a tick (`program.events`), each with a lane of its own.
What some ticks do is composed of their sparse maps, from the last tick back.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Literal, NamedTuple

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.compact_ticks import Direction
from proofmass.runner.derivatives.dual_noise import DEVIATE, ONE_BIT, ROUNDING, Followed
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Array, Truths
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.events import (
    CUT,
    DRAWN,
    DROP,
    DROPPED,
    ENTERED,
    ENTERING,
    HEARD,
    KIND,
    LEVELLED,
    OF_ONE_BIT,
    ROUNDED,
    SOURCE,
    TOLD,
    VALUED,
    VALUES,
    WIRE,
)
from proofmass.runner.targets.carried_back import TickEntries, carried_back
from proofmass.runner.targets.found_slopes import Found
from proofmass.runner.targets.native_slopes import SlopeCode, SlopesInCode

_FIRST_ROOM = 1  # events of a tick, until there are more
_ROWS = 16  # of a matrix at a time, which are columns of another: two cache lines of each of its rows
_ERRORS = ROUNDED, DROPPED, LEVELLED
_SIDES: tuple[Literal["left"], Literal["right"]] = "left", "right"


class EventTable(NamedTuple):
    """The events of some ticks, in their order."""

    row: Indices  # the number of the tick, times the most events of a tick, and the number there
    kind: Indices
    source: Indices  # block or wire
    value: Array
    drop: Array  # codes of what fixed point drops
    entered: Truths
    like: Indices  # row of the first event of the tick with the same error, else its own
    part: Indices  # number of this error among those of its block in a tick

    def of_rows(self, first: int, last: int) -> "EventTable":
        """Return the events from a row on, up to another."""
        own = slice(*np.searchsorted(self.row, [first, last]))
        return EventTable(*(each[own] for each in self))  # type: ignore[arg-type]


class TicksDone(NamedTuple):
    """The work of some ticks, with so many numbers that last and events of a tick at most."""

    size: int
    most: int
    entries: TickEntries
    events: EventTable

    @property
    def number(self) -> int:
        """The number of ticks."""
        return len(self.entries.bounds) - 1

    def back(
        self, ticks: range, asked: Sequence[int], columns: Mapping[int, int], last: Sequence[int]
    ) -> tuple[Array, Array]:
        """Return slopes in some ticks, by what lasts before them, and by what enters.

        A column each is for the numbers that last after them, some by their places, and for events
        that are `asked` for by their rows; a row for what enters, by the `columns` of rows.
        """
        bounds = self.entries.bounds[ticks.start : ticks.stop + 1]
        own = slice(bounds[0], bounds[-1])
        after = np.zeros((self.size, len(last) + len(asked)))
        after[last, np.arange(len(last))] = 1.0
        heard, enters = (np.full((len(ticks), self.most), -1) for _ in range(2))
        begin = ticks.start * self.most
        heard.reshape(-1)[np.array(asked, dtype=np.int64) - begin] = len(last) + np.arange(len(asked))
        enters.reshape(-1)[np.array([*columns], dtype=np.int64) - begin] = [*columns.values()]
        _, row, column, value = self.entries
        return carried_back(TickEntries(bounds - bounds[0], row[own], column[own], value[own]), heard, enters, after)


class NoiseInCode(SlopesInCode):
    """Ticks of blocks with noise, of which some numbers that last have slopes as they begin."""

    def __init__(
        self, code: SlopeCode, plan: Plan, memory: Memory, followed: Followed, seeded: AbstractSet[LastingPlace]
    ) -> None:
        self._of = followed
        self._noise = {name: models for name, models in followed.noise.items() if name in followed.blocks}
        self.block_names, self.wire_nodes = [*code.blocks], [*code.wires]
        self._noisy = np.array([name in self._noise for name in self.block_names], dtype=bool)
        entering = CUT if followed.cut else ENTERED
        modes = dict.fromkeys(followed.outputs, HEARD) | dict.fromkeys(followed.inputs, entering)
        super().__init__(code, plan, memory, modes, seeded, followed.moving, _FIRST_ROOM)
        self._of_ticks = list[tuple[Found, AnyArray, AnyArray]]()

    def _state_of_events(self) -> AnyArray:
        state = super()._state_of_events()
        state[VALUES] = self._of.drawn
        return state

    def _one_bit(self, code: SlopeCode) -> AnyArray:
        models = super()._one_bit(code).reshape(-1, OF_ONE_BIT)
        for name, gains in self._noise.items():
            if gains:
                models[code.blocks[name]] = gains[0].gain, np.sqrt(gains[0].variance)
        return models.reshape(-1)

    def _entering(self, counts: Indices, told: AnyArray) -> tuple[AnyArray, AnyArray]:
        kind, source = told[:, :, KIND], told[:, :, SOURCE].astype(np.int64)
        own = self._noisy[np.minimum(source, len(self._noisy) - 1)] | (kind == WIRE)
        entering = (np.arange(self._most) < counts[:, None]) & own & (told[:, :, ENTERING] != 0.0)
        return entering, entering & (kind == DROPPED)

    def _keep(self, found: Found, counts: Indices, told: AnyArray, entered: AnyArray) -> None:
        self._of_ticks.append((found, np.concatenate([told, entered[:, :, None]], axis=2), counts))

    def done(self) -> TicksDone:
        """Return what the ticks since the last call do."""
        found = Found(*(np.concatenate(each) for each in zip(*(of for of, _, _ in self._of_ticks), strict=True)))
        counts = np.concatenate([each for _, _, each in self._of_ticks])
        told = np.zeros((len(counts), self._most, TOLD + 1))
        first = 0
        for _, of_ticks, _ in self._of_ticks:
            told[first : first + len(of_ticks), : of_ticks.shape[1]] = of_ticks
            first += len(of_ticks)
        self._of_ticks = []
        begin = self.tick - len(counts) - self._first
        bounds = np.searchsorted(found.tick, begin + np.arange(len(counts) + 1))
        entries = TickEntries(bounds, *found[1:])
        return TicksDone(len(self._places), self._most, entries, self._events(entries, told, counts))

    def _events(self, entries: TickEntries, told: AnyArray, counts: Indices) -> EventTable:
        """Return the events of some ticks. What rounds the same number in a tick errs alike."""
        row = np.flatnonzero(np.arange(self._most) < counts[:, None])
        of_row = told.reshape(-1, TOLD + 1)[row]
        kind, source = (of_row[:, which].astype(np.int64) for which in (KIND, SOURCE))
        value, drop, entered = of_row[:, VALUED], of_row[:, DROP], of_row[:, TOLD] != 0.0
        events = EventTable(row, kind, source, value, drop, entered, row.copy(), np.zeros_like(row))
        errors = np.flatnonzero(events.entered & np.isin(kind, _ERRORS))
        _, number, several = np.unique(
            np.array([row // self._most, kind, source])[:, errors], axis=1, return_inverse=True, return_counts=True
        )
        again = several[number.reshape(-1)] > 1
        slopes = self._slopes(entries, row[errors[again]])
        seen: dict[int, list[tuple[int, tuple[float, bytes, bytes]]]] = {}  # of a block in a tick
        for error, of, known in zip(errors[again].tolist(), number.reshape(-1)[again].tolist(), slopes, strict=True):
            before, own = seen.setdefault(of, []), (float(events.value[error]), *known)
            first, events.part[error] = error, len(before)
            for place, (earlier, theirs) in enumerate(before):
                if theirs == own:
                    first, events.part[error] = earlier, place
                    break
            else:
                before.append((error, own))
            events.like[error] = row[first]
        return events

    def _slopes(self, entries: TickEntries, events: Indices) -> Iterator[tuple[bytes, bytes]]:
        """Yield the slopes of events by what lasts before their tick and what enters in it: columns and values."""
        at = np.flatnonzero(entries.row >= len(self._places))
        tick = np.searchsorted(entries.bounds, at, side="right") - 1
        event = tick * self._most + entries.row[at] - len(self._places)
        order = np.argsort(event, kind="stable")
        at, event = at[order], event[order]
        column, value = entries.column[at], entries.value[at]
        for first, last in zip(*(np.searchsorted(event, events, side=side) for side in _SIDES), strict=True):
            yield column[first:last].tobytes(), value[first:last].tobytes()

    def part(self, kind: int, number: int) -> str:
        """Return what enters at an event of a block, as keys of directions name it."""
        parts = {DRAWN: DEVIATE, ROUNDED: ROUNDING, LEVELLED: ONE_BIT, DROPPED: f"{ROUNDING} {number}"}
        return parts[kind]


class CompiledNoise(NoiseInCode):
    """Ticks with slopes by what lasted when they began, and by all that entered: what `CompactTicks` gives.

    The slopes are those of `put`; numbers have none.
    """

    def __init__(
        self, code: SlopeCode, plan: Plan, memory: Memory, followed: Followed, seeded: AbstractSet[LastingPlace]
    ) -> None:
        """Take the numbers that last and have slopes."""
        super().__init__(code, plan, memory, followed, seeded)
        self.recorded: dict[Endpoint, list[float]] = {node: [] for node in followed.outputs}
        self.injected: list[Direction] = []
        self.sources: list[Direction] = []
        self.quantised: dict[Direction, float] = {}
        self.drops: dict[Direction, Drop] = {}
        self._enters, self._heard = dict[Direction, list[int]](), dict[Endpoint, list[int]]()  # their events
        self._given = list[int]()  # events of quantisers

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`, once; raises `UndefinedSlopesError`."""
        sound = super().advance(last, rows)
        if sound:
            self._done = self.done()
            self._count(self._done.events)
        return sound

    def _count(self, events: EventTable) -> None:
        """Name what enters, and list what is asked for: outputs, and what quantisers are given if that is."""
        counts, entered = Counter[tuple[str, str]](), dict[int, Direction]()
        for row, kind, source, value, drop, enters, like, part in zip(*map(np.ndarray.tolist, events), strict=True):
            node = self.wire_nodes[source] if kind == WIRE else None
            if enters and like == row:
                name, what = node or (self.block_names[source], self.part(kind, part))
                key = entered[row] = name, what, counts[name, what]
                counts[name, what] += 1
                (self.injected if node else self.sources).append(key)
                if kind in (ROUNDED, DROPPED) and name in self._of.quantisers:
                    self.quantised[key] = value
                    self._given.append(row)
                if kind == DROPPED:
                    self.drops[key] = Drop.of_code(int(drop))
            if enters:
                self._enters.setdefault(entered[like], []).append(row)
            if node in self.recorded:
                self.recorded[node].append(value)
                self._heard.setdefault(node, []).append(row)

    def put(
        self, made: Array, ends: Sequence[LastingPlace], begins: Sequence[LastingPlace], enter: Sequence[Direction]
    ) -> None:
        """Put slopes by numbers that last before the ticks, and by what enters, of those after them
        and of outputs, into a matrix of zeros.

        Behind the outputs are what quantisers are given, where that is asked for.
        """
        numbers = {place: number for number, place in enumerate(self._places.values())}
        asked = [row for node in self.recorded for row in self._heard.get(node, [])] + self._given
        columns = {row: number for number, key in enumerate(enter) for row in self._enters[key]}
        known = [[i for i, place in enumerate(of) if place in numbers] for of in (ends, begins)]  # not what inputs hold
        last = [numbers[ends[i]] for i in known[0]]
        carried, entered = self._done.back(range(self._done.number), asked, columns, last)
        rows = np.array([*known[0], *range(len(ends), len(made))], dtype=np.int64)
        carried = carried[[numbers[begins[i]] for i in known[1]]]
        for part in (slice(first, first + _ROWS) for first in range(0, len(rows), _ROWS)):
            made[rows[part, None], known[1]] = carried[:, part].T
            made[rows[part], len(begins) :] = entered[:, part].T
