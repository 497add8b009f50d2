"""Ticks of a loop that is cut at one wire, each a linear map of its own.

Every number that lasts gets a direction of its own before each tick, so that its slopes afterwards
are the map of that tick alone: a matrix of few entries, whatever the length of the period.
"""

from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from proofmass.runner.derivatives.dual import SIGNALS, dual, slopes_of, value_of
from proofmass.runner.derivatives.dual_ticks import DualTicks, LastingPlace
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Rows

Indices = npt.NDArray[np.int64]
_LASTING = object()  # marks directions of numbers that last


class TickSlopes(NamedTuple):
    """Slopes of some ticks: `value` is that of `row` after the tick by `column` before it.

    Rows are `places`, the numbers that last, and then wires before an input is added. Columns are
    places, and then the inputs at the wires. Of several `wires` one is `opened`.
    """

    places: tuple[LastingPlace, ...]
    tick: Indices
    row: Indices
    column: Indices
    value: Array
    valued: npt.NDArray[np.bool_]  # of each tick, whether the wire has a value
    wires: int = 1
    opened: int = 0

    def halves(self) -> "tuple[TickSlopes, TickSlopes]":
        """Return the slopes of the first half of the ticks, and of the second."""
        half = len(self.valued) // 2
        first = self.tick < half
        one, other = ((self.row[k], self.column[k], self.value[..., k]) for k in (first, ~first))
        return (
            TickSlopes(self.places, self.tick[first], *one, self.valued[:half], self.wires, self.opened),
            TickSlopes(self.places, self.tick[~first] - half, *other, self.valued[half:], self.wires, self.opened),
        )

    def structure(self) -> tuple[bytes, ...]:
        """Return all but the values."""
        return tuple(part.tobytes() for part in (self.tick, self.row, self.column, self.valued))


class UndefinedSlopesError(ArithmeticError):
    """Slopes of numbers that last lead to none: their bits are read, or they choose places."""

    def __init__(self, places: Collection[LastingPlace]) -> None:
        super().__init__("what lasts has no derivative")
        self.blocks = frozenset(of if isinstance(of, str) else of[0] for _, of, _ in places)


class SteppedTicks(DualTicks):
    """Ticks with the input and the output at the same wire, which is cut there."""

    def __init__(self, *arguments: Any) -> None:
        self._valued: list[bool] = []
        self._slopes: list[
            tuple[int, LastingPlace | None, LastingPlace | None, float]
        ] = []  # tick, row, column and value
        super().__init__(*arguments)
        self.live = set(self._renewed())  # numbers that last and have slopes

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        (node,) = self.recorded
        while self._memory.tick < last:
            before, tick = len(self.recorded[node]), len(self._valued)
            super().advance(self._memory.tick + 1, rows)
            read = self.recorded[node][before:]
            had = self._renewed()
            for row, slopes in (*((None, slopes_of(value, SIGNALS)) for value in read[:1]), *had.items()):
                for key, slope in slopes.items():
                    self._slopes.append((tick, row, key[1] if key[0] is _LASTING else None, slope))
            self._valued.append(bool(read))
            self.live = set(had)
        return True

    def slopes(self) -> TickSlopes:
        """Return the slopes of all ticks."""
        ticks, rows, columns, values = zip(*self._slopes, strict=True) if self._slopes else ((), (), (), ())
        places = sorted({place for place in (*rows, *columns) if place is not None})
        number = {place: i for i, place in enumerate(places)} | {None: len(places)}
        at = ([*ticks], [number[place] for place in rows], [number[place] for place in columns])
        tick, row, column = (np.array(each, dtype=np.int64) for each in at)
        return TickSlopes(tuple(places), tick, row, column, np.array(values, dtype=float), np.array(self._valued))

    def _renewed(self) -> dict[LastingPlace, Any]:
        """Give each number that lasts a direction of its own, and return the slopes that it had."""
        had: dict[LastingPlace, Any] = {}

        def renewed(place: LastingPlace, value: Any) -> Any:
            slopes = slopes_of(value, SIGNALS)
            if not slopes:
                return value
            had[place] = slopes
            return dual(value_of(value, SIGNALS), {(_LASTING, place): 1.0}, SIGNALS)

        self.replace_lasting(renewed)
        return had
