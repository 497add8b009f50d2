"""Rings: buffers in which a place moves on by as many cells in each period, as those of delay lines.

Cell i is entry (i - place) modulo the cells in coordinates that move with the place. There a delay
is a shift register, whose map is the same in every period, and the period of a loop is that of its
schedule, not the turn of a ring.
"""

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

Entry = tuple[str, str, int]  # block, state field or buffer, and number in the buffer or -1
_LONGEST = 1 << 20  # periods within which a place comes back


@dataclass(frozen=True)
class Ring:
    """The field of the state that is the place, and the cells of the ring."""

    place: str
    cells: int
    wraps: int  # period in which the place first comes back to the first cells
    turn: int  # periods after which it is where it was


@dataclass(frozen=True)
class Rings:
    """The rings of a plan, by block and buffer."""

    of: Mapping[tuple[str, str], Ring] = field(default_factory=dict)

    def cell(self, memory: Memory, name: str, buffer: str, number: int) -> int:
        """Return the cell of an entry of a buffer."""
        ring = self.of.get((name, buffer))
        if ring is None or number >= ring.cells:
            return number
        return (number + _place(memory, name, ring.place)) % ring.cells

    def places(self) -> set[tuple[str, str]]:
        """Return the blocks and fields that are places in rings."""
        return {(name, ring.place) for (name, _), ring in self.of.items()}

    def wraps(self) -> set[int]:
        """Return the periods in which a place comes back to the first cells."""
        return {ring.wraps for ring in self.of.values()}

    def turns(self) -> int:
        """Return the periods after which all places are where they were; 1 without rings."""
        return math.lcm(*(ring.turn for ring in self.of.values()))

    def states_of(
        self, memory: Memory, names: Collection[str], kind: type[Any] = object
    ) -> Iterator[tuple[Entry, float]]:
        """Yield the numbers of a kind that blocks hold, buffers by their entries, without the places.

        All entries of a buffer are of one kind.
        """
        places = self.places()
        for name in names:
            state = memory.states[name]
            for key, value in zip(state._fields, state, strict=True) if state is not None else ():
                if isinstance(value, kind) and (name, key) not in places:
                    yield (name, key, -1), value
        for (name, buffer), cells in memory.of_blocks().items():
            if name in names and isinstance(cells, list) and cells and isinstance(cells[0], kind):
                for number in range(len(cells)):
                    yield (name, buffer, number), cells[self.cell(memory, name, buffer, number)]

    def integers_of(self, memory: Memory, names: Collection[str]) -> list[int]:
        """Return the integers and truth values among these numbers."""
        return [int(value) for _, value in self.states_of(memory, names, int)]


def find_rings(plan: Plan, names: Collection[str], after: Callable[[int], Memory]) -> Rings:
    """Return the rings of some blocks, by the memory `after` some periods."""
    found = dict[tuple[str, str], Ring]()
    for (name, buffer), cells in after(0).of_blocks().items():
        state = after(0).states[name]
        if name not in names or not isinstance(cells, list) or len(cells) < 2 or state is None:
            continue
        for place, kind in type(state).__annotations__.items():
            ring = _ring(name, place, len(cells), after) if kind is int else None
            if ring:
                found[name, buffer] = ring
                break
    return Rings(found)


def _place(memory: Memory, name: str, place: str) -> int:
    return int(getattr(memory.states[name], place))


def _ring(name: str, place: str, length: int, after: Callable[[int], Memory]) -> Ring | None:
    """Return the ring of a place by the memory `after` some periods; None if it is not a place in so many cells."""

    def at(periods: int) -> int:
        return _place(after(periods), name, place)

    first, step = at(0), at(1) - at(0)
    if not step or not (0 <= first < length and 0 <= at(1) < length):
        return None
    low, high = 1, 2
    while at(high) == first + high * step:
        low, high = high, 2 * high
        if high > _LONGEST:
            return None
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if at(middle) == first + middle * step else (low, middle)
    cells = abs(first + high * step - at(high))
    regular = all((at(n) - first - n * step) % cells == 0 for n in range(high + 1, high + 4)) if cells else False
    if not regular or not abs(step) < cells <= length:
        return None
    return Ring(place, cells, high, cells // math.gcd(cells, step))
