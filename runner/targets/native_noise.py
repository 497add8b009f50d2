"""Ticks with noise in machine code: what numbers that last, random numbers and errors of roundings do, over some ticks.

Random numbers and roundings are events of a tick (`program.events`), each with a lane of its own. What some ticks do is
composed of their sparse maps, many groups of ticks at a time.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.compact_ticks import Direction, InFirst
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
        found = [np.concatenate(each) for each in zip(*(of for of, _, _ in self._of_ticks), strict=True)]
        counts = np.concatenate([each for _, _, each in self._of_ticks])
        told = np.zeros((len(counts), most, TOLD + 1))
        first = 0
        for _, of_ticks, _ in self._of_ticks:
            told[first : first + len(of_ticks), : of_ticks.shape[1]] = of_ticks
            first += len(of_ticks)
        self._of_ticks = []
        begin = self.tick - len(counts) - self._first
        every = min(max(_EVERY[0], (_WIDTH - size) // most), _EVERY[1])
        width = size + most * every
        slab = max(1, _ENTRIES // width**2) * every
        found[0] = found[0] - begin
        for start in range(0, len(counts), slab):
            ticks = min(slab, len(counts) - start)
            for number, part in ((ticks // every, every), (1, ticks % every)):
                if number and part:
                    own = (found[0] >= start) & (found[0] < start + number * part)
                    inside = Found(found[0][own] - start, *(each[own] for each in found[1:]))
                    here = slice(start, start + number * part)
                    yield from self._composed(inside, number, part, told[here], counts[here])
                    start += number * part

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
            events = self._events(told[here], counts[here], heard[k])
            yield TickGroup(slopes[:, :size], slopes[:, size:], events, size)

    def _events(self, told: AnyArray, counts: Indices, heard: Array) -> list[Event]:
        """Return the events of some ticks. What rounds the same number in a tick errs alike."""
        events, most = list[Event](), self._most
        for tick, (of_tick, count) in enumerate(zip(told.tolist(), counts.tolist(), strict=True)):
            seen: dict[tuple[int, int], list[Event]] = {}  # errors, by kind and block
            for number, (kind, source, value, _, entered) in enumerate(of_tick[:count]):
                row = tick * most + number
                event = Event(row, int(kind), int(source), value, bool(entered), row, 0)
                if event.entered and event.kind in _ERRORS:
                    before, slopes = seen.setdefault((event.kind, event.source), []), heard[tick, number]
                    alike = (e for e in before if e.value == value and (slopes == heard[tick, e.row % most]).all())
                    first = next(alike, None) or event._replace(part=len(before))
                    if first.row == row:
                        before.append(first)
                    event = event._replace(like=first.row, part=first.part)
                events.append(event)
        return events

    def part(self, event: Event) -> str:
        """Return what enters at an event of a block, as keys of directions name it."""
        parts = {DRAWN: DEVIATE, ROUNDED: ROUNDING, LEVELLED: ONE_BIT, DROPPED: f"{ROUNDING} {event.part}"}
        return parts[event.kind]


class CompiledNoise(NoiseInCode):
    """Ticks with slopes by what lasted when they began, and by all that entered: what `CompactTicks` gives."""

    def __init__(
        self,
        code: SlopeCode,
        plan: Plan,
        memory: Memory,
        followed: Followed,
        starts: Mapping[LastingPlace, Direction],
    ) -> None:
        """Take the directions of the numbers that last and have slopes."""
        super().__init__(code, plan, memory, followed, starts.keys())
        self.recorded: dict[Endpoint, list[Any]] = {node: [] for node in followed.outputs}
        self.injected: list[Direction] = []
        self.sources: list[Direction] = []
        self.quantised: dict[Direction, Any] = {}
        places = [*self._places.values()]
        self._columns = {starts[place]: number for number, place in enumerate(p for p in places if p in starts)}
        self._rows = np.zeros((len(places), len(self._columns)))
        begin = [number for number, place in enumerate(places) if place in starts]
        self._rows[begin, range(len(begin))] = 1.0
        self._counts = Counter[tuple[str, str]]()

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `UndefinedSlopesError`."""
        sound = super().advance(last, rows)
        for group in self.groups() if sound else ():
            self._follow(group)
        return sound

    def _follow(self, group: TickGroup) -> None:
        """Count what some ticks do."""
        entered = dict[int, int]()  # columns, by rows of events
        for event in group.events:
            if event.entered and event.like == event.row:
                key = self._key(event)
                (self.injected if event.kind == WIRE else self.sources).append(key)
                entered[event.row] = self._columns[key] = len(self._columns)
        own = [(event.row, entered[event.like]) for event in group.events if event.entered]
        slots, columns = (np.array(each, dtype=np.int64) for each in (zip(*own, strict=True) if own else ((), ())))
        wanted = [event for event in group.events if self._is_wanted(event)]
        lasting, entering, size = group.lasting, group.entering, group.size
        changed = (lasting[:size] != np.eye(size)).any(axis=1) | (entering[:size] != 0.0).any(axis=1)
        rows = np.concatenate([np.flatnonzero(changed), [size + event.row for event in wanted]]).astype(np.int64)
        if len(self._columns) > self._rows.shape[1]:
            more = max(len(self._columns), 2 * self._rows.shape[1]) - self._rows.shape[1]
            self._rows = np.hstack([self._rows, np.zeros((size, more))])
        made = scipy.sparse.csr_array(lasting[rows]) @ self._rows[:, : len(self._columns)]
        for slot, column in zip(slots, columns, strict=True):  # several may err alike
            made[:, column] += entering[rows, slot]
        keys = {column: key for key, column in self._columns.items()} if wanted else {}
        for event, row in zip(wanted, made[int(changed.sum()) :], strict=True):
            number = InFirst(event.value, self._columns, row)
            if event.kind == WIRE:
                self.recorded[self.wire_nodes[event.source]].append(number)
            else:
                self.quantised[keys[entered[event.row]]] = number
        self._rows[changed, : len(self._columns)] = made[: int(changed.sum())]

    def _key(self, event: Event) -> Direction:
        """Return the direction of what enters anew at an event, and count it."""
        owner = (
            self.wire_nodes[event.source] if event.kind == WIRE else (self.block_names[event.source], self.part(event))
        )
        self._counts[owner] += 1
        return *owner, self._counts[owner] - 1

    def _is_wanted(self, event: Event) -> bool:
        if event.kind == WIRE:
            return self.wire_nodes[event.source] in self.recorded
        return event.entered and event.kind in (ROUNDED, DROPPED) and event.like == event.row

    def memory(self) -> Memory:
        """Return the memory of this moment, with the slopes of what lasts."""
        memory = super().memory()
        rows = self._rows[:, : len(self._columns)]
        for (what, of, number), row in zip(self._places.values(), rows, strict=True):
            if not row.any():
                continue
            if what == "state":
                state: Any = memory.states[of]
                field = state._fields[number]
                memory.states[of] = state._replace(**{field: InFirst(state[number], self._columns, row)})
            elif what == "buffer":
                held: Any = memory.buffers[of]
                held[number] = InFirst(held[number], self._columns, row)
            elif isinstance(memory.wires[of], list):
                memory.wires[of][number] = InFirst(memory.wires[of][number], self._columns, row)
            else:
                memory.wires[of] = InFirst(memory.wires[of], self._columns, row)
        return memory
