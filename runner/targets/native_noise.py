"""Ticks with noise in machine code: what numbers that last, random numbers and errors of roundings do, over some ticks.

Random numbers and roundings are events of a tick (`program.events`), each with a lane of its own. What some ticks do is
composed of their sparse maps, many groups of ticks at a time.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from collections.abc import Set as AbstractSet
from functools import partial
from typing import NamedTuple

import numpy as np
import scipy.sparse

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.compact_ticks import Direction
from proofmass.runner.derivatives.dual_noise import DEVIATE, ONE_BIT, ROUNDING, Followed
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Array
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.events import (
    DRAWN,
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
    VALUES,
    WIRE,
)
from proofmass.runner.targets.carried_back import TickEntries, carried_back
from proofmass.runner.targets.native_slopes import Found, SlopeCode, SlopesInCode

_FIRST_ROOM = 1  # events of a tick, until there are more
_EVERY = 8, 64  # least and most ticks of a group
_WIDTH = 250  # numbers by which the slopes of a group are, if it has more than the fewest ticks
_ERRORS = ROUNDED, DROPPED, LEVELLED
_ENTRIES = 1 << 21  # numbers of the groups that are composed at a time


class TickGroup(NamedTuple):
    """Slopes of some ticks: by what lasts before them, and by what enters at each of their events."""

    lasting: Array  # [row, place]: rows are what lasts after them, and then the numbers at each event
    entering: Array  # [row, event]
    events: list["Event"]
    size: int  # rows of what lasts


class Event(NamedTuple):
    """An event of some ticks: its row among those of the events, what it is, and whether its error is a new one."""

    row: int
    kind: int
    source: int  # block or wire
    value: float
    entered: bool
    like: int  # the first event with the same error, itself if there is none
    part: int  # number of this error among those of its block in a tick


class NoiseInCode(SlopesInCode):
    """Ticks of blocks with noise, of which some numbers that last have slopes as they begin."""

    def __init__(
        self, code: SlopeCode, plan: Plan, memory: Memory, followed: Followed, seeded: AbstractSet[LastingPlace]
    ) -> None:
        self._of = followed
        self._noise = {name: models for name, models in followed.noise.items() if name in followed.blocks}
        self.block_names, self.wire_nodes = [*code.blocks], [*code.wires]
        self._noisy = np.array([name in self._noise for name in self.block_names], dtype=bool)
        modes = dict.fromkeys(followed.outputs, HEARD) | dict.fromkeys(followed.inputs, ENTERED)
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

    def groups(self) -> Iterator[TickGroup]:
        """Yield what the ticks since the last call do, a few at a time."""
        if not self._of_ticks:
            return
        size, most = len(self._places), self._most
        found, told, counts = self._joined()
        every = min(max(_EVERY[0], (_WIDTH - size) // most), _EVERY[1])
        width = size + most * every
        slab = max(1, _ENTRIES // width**2) * every
        for start in range(0, len(counts), slab):
            ticks = min(slab, len(counts) - start)
            for number, part in ((ticks // every, every), (1, ticks % every)):
                if number and part:
                    own = (found.tick >= start) & (found.tick < start + number * part)
                    inside = Found(found.tick[own] - start, *(each[own] for each in found[1:]))
                    here = slice(start, start + number * part)
                    yield from self._composed(inside, number, part, told[here], counts[here])
                    start += number * part

    def _joined(self) -> tuple[Found, AnyArray, Indices]:
        """Return what the ticks since the last call do, what their events tell, and how many these are."""
        found = Found(*(np.concatenate(each) for each in zip(*(of for of, _, _ in self._of_ticks), strict=True)))
        counts = np.concatenate([each for _, _, each in self._of_ticks])
        told = np.zeros((len(counts), self._most, TOLD + 1))
        first = 0
        for _, of_ticks, _ in self._of_ticks:
            told[first : first + len(of_ticks), : of_ticks.shape[1]] = of_ticks
            first += len(of_ticks)
        self._of_ticks = []
        return found._replace(tick=found.tick - (self.tick - len(counts) - self._first)), told, counts

    def _composed(self, found: Found, number: int, ticks: int, told: AnyArray, counts: Indices) -> Iterator[TickGroup]:
        """Yield what each of some groups does, of so many ticks each."""
        size, most = len(self._places), self._most
        width, rows = size + most * ticks, size + most
        moved = np.zeros((number, size, width))
        moved[:, range(size), range(size)] = 1.0
        heard = np.zeros((number, ticks, most, width))
        group, within = np.divmod(found.tick, ticks)
        places, at_events = np.split(np.arange(number * rows).reshape(number, rows), [size], axis=1)
        for tick in range(ticks):
            own = within == tick
            g, row, column, value = group[own], found.row[own], found.column[own], found.value[own]
            to, lasts, stays = g * rows + row, column < size, (row == column) & (value == 1.0)
            still = np.bincount(to, minlength=number * rows) == 1
            still &= np.bincount(to[stays], minlength=number * rows) == 1
            changed = ~still  # others stay as they are: most cells of a delay
            number_of = np.cumsum(changed) - 1
            kept = lasts & changed[to]
            at = number_of[to[kept]], g[kept] * size + column[kept]
            step = scipy.sparse.csr_array((value[kept], at), shape=(int(changed.sum()), number * size))
            made = step @ moved.reshape(-1, width)
            made[number_of[to[~lasts]], tick * most + column[~lasts]] += value[~lasts]
            lasting = changed[places]
            heard[:, tick] = made[number_of[at_events]]
            moved[lasting] = made[number_of[places[lasting]]]
        for k in range(number):
            here = slice(k * ticks, (k + 1) * ticks)
            slopes = np.concatenate([moved[k], heard[k].reshape(ticks * most, width)])
            events = self._events(told[here], counts[here], partial(_alike, heard[k]))
            yield TickGroup(slopes[:, :size], slopes[:, size:], events, size)

    def _events(self, told: AnyArray, counts: Indices, alike: Callable[[int, int, int], bool]) -> list[Event]:
        """Return the events of some ticks. What rounds the same number in a tick errs alike.

        `alike` says whether two events of a tick have the same slopes.
        """
        events, most = list[Event](), self._most
        for tick, (of_tick, count) in enumerate(zip(told.tolist(), counts.tolist(), strict=True)):
            seen: dict[tuple[int, int], list[Event]] = {}  # errors, by kind and block
            for number, (kind, source, value, _, entered) in enumerate(of_tick[:count]):
                row = tick * most + number
                event = Event(row, int(kind), int(source), value, bool(entered), row, 0)
                if event.entered and event.kind in _ERRORS:
                    before = seen.setdefault((event.kind, event.source), [])
                    same = (e for e in before if e.value == value and alike(tick, number, e.row % most))
                    first = next(same, None) or event._replace(part=len(before))
                    if first.row == row:
                        before.append(first)
                    event = event._replace(like=first.row, part=first.part)
                events.append(event)
        return events

    def part(self, event: Event) -> str:
        """Return what enters at an event of a block, as keys of directions name it."""
        parts = {DRAWN: DEVIATE, ROUNDED: ROUNDING, LEVELLED: ONE_BIT, DROPPED: f"{ROUNDING} {event.part}"}
        return parts[event.kind]


def _alike(heard: Array, tick: int, event: int, other: int) -> bool:
    return bool((heard[tick, event] == heard[tick, other]).all())


class CompiledNoise(NoiseInCode):
    """Ticks with slopes by what lasted when they began, and by all that entered: what `CompactTicks` gives.

    The slopes are those of `matrix`; numbers have none.
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
        self._enters, self._heard = dict[Direction, list[int]](), dict[Endpoint, list[int]]()  # their events
        self._given = list[int]()  # events of quantisers

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`, once; raises `UndefinedSlopesError`."""
        sound = super().advance(last, rows)
        if sound:
            self._found_in_all, told, counts = self._joined()
            self._bounds = np.searchsorted(self._found_in_all.tick, np.arange(len(counts) + 1))
            self._count(self._events(told, counts, self._alike))
        return sound

    def _alike(self, tick: int, event: int, other: int) -> bool:
        """Return whether two events of a tick have the same slopes by what lasts before it and what enters in it."""
        own = slice(*self._bounds[tick : tick + 2])
        _, row, column, value = (each[own] for each in self._found_in_all)
        rows = (row == len(self._places) + number for number in (event, other))
        one, two = (dict(zip(column[of].tolist(), value[of].tolist(), strict=True)) for of in rows)
        return one == two

    def _count(self, events: Sequence[Event]) -> None:
        """Name what enters, and list what is asked for: outputs, and what quantisers are given if that is."""
        counts, entered = Counter[tuple[str, str]](), dict[int, Direction]()
        for event in events:
            if event.entered and event.like == event.row:
                owner = self._owner_of(event)
                key = entered[event.row] = *owner, counts[owner]
                counts[owner] += 1
                (self.injected if event.kind == WIRE else self.sources).append(key)
                if event.kind in (ROUNDED, DROPPED) and key[0] in self._of.quantisers:
                    self.quantised[key] = event.value
                    self._given.append(event.row)
            if event.entered:
                self._enters.setdefault(entered[event.like], []).append(event.row)
            if event.kind == WIRE and (node := self.wire_nodes[event.source]) in self.recorded:
                self.recorded[node].append(event.value)
                self._heard.setdefault(node, []).append(event.row)

    def _owner_of(self, event: Event) -> tuple[str, str]:
        if event.kind == WIRE:
            return self.wire_nodes[event.source]
        return self.block_names[event.source], self.part(event)

    def matrix(self, ends: Sequence[LastingPlace], begins: Sequence[LastingPlace], enter: Sequence[Direction]) -> Array:
        """Return slopes by numbers that last before the ticks, and by what enters, of those after them and of outputs.

        Behind the outputs are what quantisers are given, where that is asked for.
        """
        numbers = {place: number for number, place in enumerate(self._places.values())}
        asked = [row for node in self.recorded for row in self._heard.get(node, [])] + self._given
        last = np.zeros((len(numbers), len(ends) + len(asked)))
        for column, place in enumerate(ends):
            if place in numbers:
                last[numbers[place], column] = 1.0
        heard, enters = (np.full((len(self._bounds) - 1, self._most), -1) for _ in range(2))
        heard.reshape(-1)[asked] = len(ends) + np.arange(len(asked))
        for number, key in enumerate(enter):
            enters.reshape(-1)[self._enters[key]] = number
        entries = TickEntries(self._bounds, *self._found_in_all[1:])
        carried, entered = carried_back(entries, heard, enters, last)
        lasting = np.zeros((len(begins), last.shape[1]))
        for row, place in enumerate(begins):
            if place in numbers:
                lasting[row] = carried[numbers[place]]
        return np.concatenate([lasting, entered]).T
