"""Products of the sparse maps of ticks, from the last one back: how some numbers follow from all that has entered.

    x[k+1] = S[k] x[k] + R[k] w[k]:   a[k] = S[k]' a[k+1],   b[k] = R[k]' a[k+1]

a has a column for each number that is asked for: those that last, after the last tick, and those at events, from their
tick on. So a tick costs its entries times these numbers, however much has entered before.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Array
from proofmass.runner.program.build import Builder, BuilderInput
from proofmass.runner.program.form import FLOAT, INTEGER, Operand, Storage
from proofmass.runner.program.lower import program
from proofmass.runner.targets.machine_code import Settings, load

_AS_IT_IS, _NOTHING = -1, -2  # instead of a place of a row that is made anew


class TickEntries(NamedTuple):
    """Entries of the maps of some ticks, in their order. Rows and columns are what lasts, then events of the tick."""

    bounds: Indices  # where those of each tick begin, and the last end
    row: Indices
    column: Indices
    value: AnyArray


def carried_back(entries: TickEntries, heard: Indices, enters: Indices, last: Array) -> tuple[Array, Array]:
    """Return a[0], and b of all that enters, a row each.

    `heard` has the column of a at which each event of each tick is asked for, `enters` the row of b of what enters
    there; -1 if there is none. `last` is a after the last tick, [what lasts, what is asked for].
    """
    (size, width), (ticks, most) = last.shape, heard.shape
    tick = np.repeat(np.arange(ticks), np.diff(entries.bounds))
    lasts, from_last = entries.column < size, entries.row < size
    place = tick[lasts] * size + entries.column[lasts]
    number = np.bincount(place, minlength=ticks * size)
    stays = (entries.row[lasts] == entries.column[lasts]) & (entries.value[lasts] == 1.0)
    still = (number == 1) & (np.bincount(place[stays], minlength=ticks * size) == 1)  # most cells of a delay
    anew = ((number > 0) & ~still).reshape(ticks, size)
    slots = np.where(anew, np.cumsum(anew, axis=1) - 1, _AS_IT_IS)
    nothing = (number == 0).reshape(ticks, size)
    nothing[:-1] &= ~nothing[1:].copy()  # what is nothing later is so already
    slots[nothing] = _NOTHING
    to, source = np.empty(len(tick), dtype=np.int64), entries.row.copy()
    to[lasts] = slots.reshape(-1)[place]
    event = tick[~lasts] * most + entries.column[~lasts] - size
    to[~lasts] = np.where(enters.reshape(-1)[event] < 0, -1, size + enters.reshape(-1)[event])
    asked = heard.reshape(-1)[tick[~from_last] * most + entries.row[~from_last] - size]
    source[~from_last] = np.where(asked < 0, -1, size + asked)
    used = (to >= 0) & (source >= 0)
    bounds = np.append(0, np.cumsum(used))[entries.bounds]
    carried, made = np.array(last, dtype=float), np.zeros((size + int(enters.max(initial=-1)) + 1, width))
    given: list[AnyArray] = [bounds, to[used], source[used], entries.value[used], slots, carried, made]
    given = [np.ascontiguousarray(each) for each in given]
    _code()(ticks, size, width, *(each.ctypes.data for each in given))
    return carried, made[size:]


@cache
def _code() -> Callable[..., Any]:
    return load(program(_Written().function()), Settings(wide=True))


class _Written(Builder):
    """Writes the ticks from the last one back."""

    def __init__(self) -> None:
        super().__init__("carried_back", __name__)
        ticks, self._size, self._width = (self.parameter(INTEGER, name) for name in ("ticks", "size", "width"))
        self._bounds, self._to, self._source = (self.array(INTEGER, None, name) for name in ("bounds", "to", "source"))
        self._value = self.array(FLOAT, None, "value")
        self._slots = self.array(INTEGER, None, "slots")
        self._carried, self._made = (self.array(FLOAT, None, name, True) for name in ("carried", "made"))
        with self.counted(0, ticks, 1, "done") as done:
            self._tick(self._less(self._less(ticks, 1), done))

    def _tick(self, tick: Operand) -> None:
        first = self._times(tick, self._size)
        with self.counted(0, self._size, 1, "place") as place:
            slot = self.load(self._slots, self._plus(first, place))
            with self.when(self.compute("less_equal_integers", 0, slot)):
                self._rows((self._made, slot), None)
        last = self.load(self._bounds, self._plus(tick, 1))
        with self.counted(self.load(self._bounds, tick), last, 1, "entry") as entry:
            self._entry(*(self.load(of, entry) for of in (self._to, self._source, self._value)))
        with self.counted(0, self._size, 1, "place") as place:
            slot = self.load(self._slots, self._plus(first, place))
            with self.when(self.compute("less_equal_integers", 0, slot)):
                self._rows((self._carried, place), lambda i: self.load(self._made, self._at(slot, i)))
            with self.when(self.compute("equal_integers", slot, _NOTHING)):
                self._rows((self._carried, place), None)

    def _entry(self, to: Operand, source: Operand, value: Operand) -> None:
        with self.when(self.compute("less_integers", source, self._size)):
            self._rows((self._made, to), lambda i: self._added(to, i, self._times_carried(value, source, i)))
        with self.otherwise():
            asked = self._less(source, self._size)
            self.store(self._made, self._at(to, asked), self._added(to, asked, value))

    def _times_carried(self, value: Operand, row: Operand, i: Operand) -> Operand:
        return self.compute("multiply", self.load(self._carried, self._at(row, i)), value)

    def _added(self, to: Operand, i: Operand, more: Operand) -> Operand:
        return self.compute("add", self.load(self._made, self._at(to, i)), more)

    def _rows(self, to: tuple[Storage, Operand], value: Callable[[Operand], Operand] | None) -> None:
        array, row = to
        with self.counted(0, self._width, 1, "i") as i:
            self.store(array, self._at(row, i), value(i) if value else 0.0)

    def _at(self, row: Operand, i: Operand) -> Operand:
        return self._plus(self._times(row, self._width), i)

    def _plus(self, one: Operand, other: BuilderInput) -> Operand:
        return self.compute("add_integers", one, other)

    def _less(self, one: Operand, other: BuilderInput) -> Operand:
        return self.compute("subtract_integers", one, other)

    def _times(self, one: Operand, other: Operand) -> Operand:
        return self.compute("multiply_integers", one, other)
