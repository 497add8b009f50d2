"""Noisy ticks of a long period: the directions of dual numbers are gathered into a matrix every few ticks.

Each random number adds a direction, and what lasts depends on all before it, so that a period of n
ticks costs n^2 in dual numbers. Here every number that lasts gets one direction of its own every
few ticks, and a matrix G says what these are in the first ones: with slopes S by those of before,
and R by new ones, G becomes S G + R.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse

from proofmass.runner.derivatives.dual import SIGNALS, Dual, dual, slopes_of, value_of
from proofmass.runner.derivatives.dual_noise import NoisyTicks
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.plan.memory import Rows

EVERY = 8  # ticks
LIVE = "lasts"  # stands where a port's name would: no port may be called so

Direction = tuple[str, str, int]


class InFirst(Dual):
    """A number with its slopes by the first directions as a row, for those that there were when it was made."""

    __slots__ = ("columns", "row")

    def __init__(self, value: Any, columns: Mapping[Direction, int], row: npt.NDArray[np.float64]) -> None:
        self.value, self.level, self.columns, self.row = value, SIGNALS, columns, row

    @property
    def slopes(self) -> Mapping[Direction, float]:  # type: ignore[override]
        """The slopes by direction."""
        return {key: slope for key, slope in zip(self.columns, self.row.tolist(), strict=False) if slope}


class CompactTicks(NoisyTicks):
    """Ticks with noise and no derivatives by parameters, in time that grows with the length of the period alone."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._columns: dict[Direction, int] = {}  # of first directions, in their order
        self._rows: npt.NDArray[np.float64] = np.zeros((0, 0))  # G
        self._seen: dict[Any, int] = {}  # recorded values that are in first directions
        self._fed: set[Direction] = set()
        super().__init__(*arguments, **options)

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        while self._memory.tick < last:
            super().advance(min(self._memory.tick + EVERY, last), rows)
            self._gather()

        def spread(_: LastingPlace, value: Any) -> Any:
            slopes = slopes_of(value, SIGNALS)
            if not slopes:
                return value
            (key,) = slopes
            return InFirst(value_of(value, SIGNALS), self._columns, self._rows[key[2]])

        self.replace_lasting(spread)
        return True

    def _gather(self) -> None:
        """Give each number that lasts one direction, and what was recorded its slopes by these."""
        self._last.clear()
        for node, values in self.recorded.items():
            first = self._seen.get(node, 0)
            values[first:] = self._in_first(values[first:])
            self._seen[node] = len(values)
        new = [key for key in self.quantised if key not in self._fed]
        self.quantised.update(zip(new, self._in_first([self.quantised[key] for key in new]), strict=True))
        self._fed.update(new)
        self._rows = self._product(self._one_direction_each())

    def _one_direction_each(self) -> list[Mapping[Direction, float]]:
        """Give each number that lasts a direction of its own, and return the slopes that it had."""
        gathered: list[Mapping[Direction, float]] = []

        def gather(_: LastingPlace, value: Any) -> Any:
            slopes = slopes_of(value, SIGNALS)
            if not slopes:
                return value
            gathered.append(slopes)
            return dual(value_of(value, SIGNALS), {("", LIVE, len(gathered) - 1): 1.0}, SIGNALS)

        self.replace_lasting(gather)
        return gathered

    def _in_first(self, values: list[Any]) -> list[Any]:
        moved = self._product([slopes_of(value, SIGNALS) for value in values])
        numbers = [value_of(value, SIGNALS) for value in values]
        return [InFirst(number, self._columns, row) for number, row in zip(numbers, moved, strict=True)]

    def _product(self, slopes: list[Mapping[Direction, float]]) -> npt.NDArray[np.float64]:
        """Slopes by the present directions as a matrix by the first ones: S G + R."""
        live, fresh = list[tuple[int, int, float]](), list[tuple[int, int, float]]()
        for row, each in enumerate(slopes):
            for key, value in each.items():
                if key[1] == LIVE:
                    live.append((row, key[2], value))
                else:
                    fresh.append((row, self._columns.setdefault(key, len(self._columns)), value))
        known, width = self._rows.shape
        product = np.zeros((len(slopes), len(self._columns)))
        if live:
            rows, columns, values = zip(*live, strict=True)
            shape = len(slopes), known
            product[:, :width] = scipy.sparse.csr_array((values, (rows, columns)), shape, dtype=float) @ self._rows
        if fresh:
            rows, columns, values = zip(*fresh, strict=True)
            product[rows, columns] += values
        return product
