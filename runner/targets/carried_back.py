"""Products of the sparse maps of ticks, from the last one back: how some numbers follow from all
that has entered.

    x[k+1] = S[k] x[k] + R[k] w[k]:   a[k] = S[k]' a[k+1],   b[k] = R[k]' a[k+1]

a has a column for each number that is asked for: those that last, after the last tick, and those at
events, from their tick on. So a tick costs its entries times these numbers, however much has
entered before.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Array
from proofmass.runner.program.form import FLOAT, INTEGER, Storage, Value
from proofmass.runner.program.lower import lower, program
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

    `heard` has the column of a at which each event of each tick is asked for, `enters` the row of b
    of what enters there; -1 if there is none. `last` is a after the last tick, [what lasts, what is
    asked for].
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
    number, places = Value(INTEGER), Storage(INTEGER, None, writable=False)
    values, rows = Storage(FLOAT, None, writable=False), Storage(FLOAT, None, writable=True)
    carried_by = lower(_carry, (number, number, number, (places, places, places, values), places, rows, rows))
    return load(program(carried_by.function), Settings(wide=True))


def _carry(ticks: int, size: int, width: int, entries: Any, slots: Any, carried: Any, made: Any) -> None:
    """Go through the ticks from the last one back, as machine code."""
    bounds, to, source, value = entries
    for done in range(ticks):
        tick = ticks - 1 - done
        for place in range(size):
            slot = slots[tick * size + place]
            if slot >= 0:
                for i in range(width):
                    made[slot * width + i] = 0.0
        for entry in range(bounds[tick], bounds[tick + 1]):
            row, of, factor = to[entry], source[entry], value[entry]
            if of < size:
                for i in range(width):
                    made[row * width + i] += carried[of * width + i] * factor
            else:
                made[row * width + of - size] += factor
        for place in range(size):
            slot = slots[tick * size + place]
            if slot >= 0:
                for i in range(width):
                    carried[place * width + i] = made[slot * width + i]
            if slot == _NOTHING:
                for i in range(width):
                    carried[place * width + i] = 0.0
