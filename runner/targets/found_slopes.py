"""Slopes that are not zero, among those of some ticks in all directions: which directions have begun is followed."""

import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import AnyArray, Truths
from proofmass.runner.program.form import FLOAT, INTEGER, Storage, Value
from proofmass.runner.targets.machine_code import load_python
from proofmass.runner.targets.native_lanes import aligned

LANES = 16  # directions side by side
_ENTERS, _IF_MOVED = 1, 2  # what becomes of an event


class Found(NamedTuple):
    """Slopes of some ticks that are not zero: `value` is that of `row` by `column`.

    Rows and columns are the numbers that last, and then the events of the tick.
    """

    tick: Indices
    row: Indices
    column: Indices
    value: AnyArray


class FollowedSlopes(NamedTuple):
    """The slopes of some ticks with which numbers have slopes: as any tick begins, and after the last.

    What has `entered` at events, [tick, event], is told too, and how many ticks have left what is
    still as it was: what is found holds if all have.
    """

    found: Found
    lived: Truths
    live: Truths
    entered: Truths
    still: int


class ReusedArrays:
    """Memory that calls write in one after the other: pages taken anew cost as much as what is written there."""

    def __init__(self) -> None:
        self._arrays = dict[str, AnyArray]()

    def array(self, name: str, shape: tuple[int, ...], kind: type = float) -> AnyArray:
        """Return an array with what the last one of this name has left in it."""
        size = math.prod(shape)
        if name not in self._arrays or len(self._arrays[name]) < size:
            self._arrays[name] = aligned((size,), np.dtype(kind))
        return self._arrays[name][:size].reshape(shape)


class StillRow(NamedTuple):
    """The row of lanes of all numbers that are still, and what its slopes begin as, [number, event or more, lane]."""

    row: int  # -1 if there is none
    begins: AnyArray


def followed(
    made: AnyArray,
    lanes: Indices,
    live: Truths,
    entering: AnyArray,
    if_moved: AnyArray,
    still: StillRow,
    reused: ReusedArrays,
) -> FollowedSlopes:
    """Return the slopes of ticks by numbers that have some as a tick begins, and what enters in it.

    `made` are slopes, [tick, row of lanes, number that lasts or event or more, lane]; `lanes` has
    the number or event of each lane, -1 of one that is idle; `live` are the numbers that have
    slopes as the first tick begins. At events something is `entering`, or only `if_moved`: if the
    number there has a slope. Numbers that are `still` have a slope and no lane.
    """
    (ticks, rows, every, _), (size, most) = made.shape, (len(live), entering.shape[1])
    rests = (still.begins[:size, -1] != 0.0).astype(np.int64)
    now, lived, events = live.astype(np.int64), np.zeros(size, dtype=np.int64), np.zeros(entering.shape, dtype=np.int64)
    events[entering], events[if_moved] = _ENTERS, _IF_MOVED
    several = ticks * (rows * (size + most) * LANES + int(rests.sum()))
    places, values = [*reused.array("places", (3, several), int)], reused.array("values", (several,))
    count, own = np.zeros(2, dtype=np.int64), np.zeros(rows * LANES, dtype=np.int64)
    given = [made, np.ascontiguousarray(lanes), events, own, now, lived, *places, values, count, still.begins, rests]
    _code()(ticks, rows, size, most, every, still.row, *(each.ctypes.data for each in given))
    tick, row, column = (each[: count[0]].copy() for each in places)
    found = Found(tick, row, column, values[: count[0]].copy())
    return FollowedSlopes(found, lived != 0, now != 0, events == _ENTERS, int(count[1]))


@cache
def _code() -> Callable[..., Any]:
    number, read = Value(INTEGER), Storage(FLOAT, None, writable=False)
    lanes, places, values = (
        Storage(INTEGER, None, writable=False),
        Storage(INTEGER, None, writable=True),
        Storage(FLOAT, None, writable=True),
    )
    arrays = read, lanes, places, (places, places, places), (places, places, places, values, places), (read, lanes)
    return load_python(_follow, (*(number,) * 6, *arrays))


def _follow(
    ticks: int,
    rows: int,
    size: int,
    most: int,
    every: int,
    still: int,
    made: Any,
    lanes: Any,
    events: Any,
    live: Any,
    found: Any,
    still_row: Any,
) -> None:
    """Go through the ticks, as machine code, up to one in which what should be still is not."""
    own, now, lived = live
    of_tick, of_row, of_column, values, count = found
    begins, rests = still_row
    number = 0
    for tick in range(ticks):
        wrong = 0
        if still >= 0:
            first = (tick * rows + still) * every * LANES
            for at in range(every * LANES):
                value, before = made[first + at], begins[at]
                wrong += 1 if value != before and (value == value or before == before) else 0
        if wrong > 0:
            break
        count[1] = tick + 1
        for place in range(size):
            if now[place] > 0:
                lived[place] = 1
        for lane in range(rows * LANES):
            of = lanes[lane]
            own[lane] = 0
            if of >= size:
                own[lane] = 1 if events[tick * most + of - size] == _ENTERS else 0
            elif of >= 0:
                own[lane] = now[of]
        for event in range(most):
            at = tick * most + event
            if events[at] == _IF_MOVED:
                events[at] = 0
                for row in range(rows):
                    first = ((tick * rows + row) * every + size + event) * LANES
                    for lane in range(LANES):
                        if own[row * LANES + lane] > 0 and made[first + lane] != 0.0:
                            events[at] = _ENTERS
                for lane in range(rows * LANES):
                    if lanes[lane] == size + event:
                        own[lane] = events[at]
        for place in range(size):
            now[place] = rests[place]
            if rests[place] > 0:
                of_tick[number], of_row[number], of_column[number], values[number] = tick, place, place, 1.0
                number += 1
        for row in range(rows):
            for place in range(size + most):
                first = ((tick * rows + row) * every + place) * LANES
                for lane in range(LANES):
                    value = made[first + lane]
                    if value != 0.0 and own[row * LANES + lane] > 0:
                        of_tick[number], of_row[number], values[number] = tick, place, value
                        of_column[number] = lanes[row * LANES + lane]
                        number += 1
                        if place < size:
                            now[place] = 1
    count[0] = number
