"""Covariances along a run: of what lasts, by the blocks that make it, and of outputs."""

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.noise.grid_errors import GridErrors
from proofmass.runner.analysis.noise.noise_map import variance
from proofmass.runner.derivatives.compact_ticks import EVERY, LIVE, CompactTicks, Direction
from proofmass.runner.derivatives.dual import SIGNALS, plain, slopes_of
from proofmass.runner.derivatives.dual_noise import Noisy, NoisyTicks
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Rows


@dataclass(frozen=True)
class Last:
    """The last value of an output: its number from 0 on, and the variance that each block makes."""

    number: int
    value: float
    variances: Mapping[str, float]


class Stretch:
    """The mean power of the lines of some successive values, a sum Z of w y exp(-2 pi i f t) for each, by block.

    Z moves on as what lasts does, x: with y = s x + r u within some ticks, E[Z x'] and E[|Z|^2]
    follow. `turns` are the lines, in turns from value to value; `squares` are the sums of w^2
    E[y^2] in each half of the window.
    """

    def __init__(self, window: Array, first: int, turns: Array) -> None:
        self.window, self._first, self._turns = window, first, turns
        self._shared: dict[str, Array] = {}  # E[Z x'], of the real part of Z, then the imaginary
        self.powers, self.squares = dict[str, Array](), dict[str, Array]()

    def moved(self, number: int, slopes: "GroupSlopes", rows: range, covariances: Mapping[str, Array]) -> None:
        """Count values from a number on, some rows of slopes; the last of these are what lasts from now on."""
        numbers = np.arange(number, number + len(rows)) - self._first
        inside = (numbers >= 0) & (numbers < len(self.window))
        if not self._shared and not inside.any():
            return
        weights = np.where(inside, self.window[np.clip(numbers, 0, len(self.window) - 1)], 0.0)
        angles = 2.0 * np.pi * np.outer(self._turns, numbers)
        turns = np.concatenate([np.cos(angles), -np.sin(angles)]) * weights
        own, after = slice(rows.start, rows.stop), slopes.memory
        early = 2 * numbers < len(self.window)
        halves = np.array([early, ~early]) * weights**2
        old = turns @ slopes.lasting[own]
        for name in {**covariances, **slopes.columns}:
            columns, covariance = slopes.columns.get(name, []), covariances.get(name)
            squares = _squares(slopes, own, covariance, columns)
            self.squares[name] = self.squares.get(name, 0.0) + halves @ squares
            new = turns @ slopes.fresh[own, columns] if len(columns) else np.zeros((len(turns), 0))
            by = old @ covariance if covariance is not None else np.zeros_like(old)
            shared = self._shared.get(name, np.zeros_like(old))
            power = np.einsum("ij,ij->i", old, 2.0 * shared + by) + np.einsum("ij,ij->i", new, new)
            self.powers[name] = self.powers.get(name, 0.0) + power.reshape(2, -1).sum(axis=0)
            self._shared[name] = (shared + by) @ slopes.lasting[after:].T + new @ slopes.fresh[after:, columns].T


@dataclass(frozen=True)
class GroupSlopes:
    """Slopes by what lasts, and by new random numbers times their deviations: of outputs, then of the memory."""

    lasting: Array
    fresh: Array
    columns: Mapping[str, list[int]]  # new random numbers of each block
    memory: int  # first row of the memory


class Covariances:
    """The covariance of what lasts, by the blocks that make it, and what outputs have of it."""

    def __init__(self, stretches: Mapping[Endpoint, Stretch], errors: GridErrors) -> None:
        self._errors = errors
        self._covariances: dict[str, Array] = {}
        self._stretches, self._numbers = stretches, Counter[Endpoint]()
        self.last: dict[Endpoint, Last] = {}

    def deviation(self, place: Endpoint, drop: Drop | None) -> float:
        """Return the deviation of what enters at a place."""
        return self._errors.size(place, drop) * math.sqrt(variance(place[1]))

    def notes(self, node: Endpoint) -> tuple[str, ...]:
        """Return the notes on what makes the last value of an output."""
        return tuple(self._errors.notes([name for name, square in self.last[node].variances.items() if square]))

    def moved(self, recorded: Mapping[Endpoint, Sequence[float]], slopes: "GroupSlopes") -> None:
        """Move the covariances on, and count values of outputs, whose slopes come first."""
        first = 0
        for node, values in recorded.items():
            rows, first = range(first, first + len(values)), first + len(values)
            if node in self._stretches:
                self._stretches[node].moved(self._numbers[node], slopes, rows, self._covariances)
            self._numbers[node] += len(values)
            if values:
                row = slice(rows[-1], rows[-1] + 1)
                variances = {
                    name: float(_squares(slopes, row, self._covariances.get(name), columns)[0])
                    for name, columns in self._by_block(slopes)
                }
                self.last[node] = Last(self._numbers[node] - 1, float(values[-1]), variances)
        self._covariances = {
            name: _moved(slopes, slice(slopes.memory, None), self._covariances.get(name), columns)
            for name, columns in self._by_block(slopes)
        }

    def _by_block(self, slopes: "GroupSlopes") -> Iterator[tuple[str, list[int]]]:
        for name in {**self._covariances, **slopes.columns}:
            yield name, slopes.columns.get(name, [])


class CovarianceTicks(CompactTicks):
    """Ticks in plain Python that move covariances on."""

    def __init__(self, *arguments: Any, noise: Noisy, found: Covariances) -> None:
        self._alive, self._covariances_of = 0, found
        super().__init__(*arguments, noise=noise)

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `TickError`."""
        while self._memory.tick < last:
            NoisyTicks.advance(self, min(self._memory.tick + EVERY, last), rows)
            self._gather()
        return True

    def _gather(self) -> None:
        """Give each number that lasts one direction, and move the covariances on."""
        recorded = {node: list(values) for node, values in self.recorded.items()}
        gathered = self._one_direction_each()
        outputs = [slopes_of(value, SIGNALS) for values in recorded.values() for value in values]
        slopes = self._slopes([*outputs, *gathered], len(outputs))
        self._covariances_of.moved({node: [*map(plain, values)] for node, values in recorded.items()}, slopes)
        self._alive = len(gathered)
        done: list[Any] = [self.quantised, self.drops, self.sources, self._known, self._counts, self._last]
        for each in [*done, *self.recorded.values()]:
            each.clear()

    def _slopes(self, rows: Sequence[Mapping[Direction, float]], memory: int) -> GroupSlopes:
        lasting = np.zeros((len(rows), self._alive))
        columns, owners = dict[Direction, int](), dict[str, list[int]]()
        new: list[tuple[int, int, float]] = []
        for row, each in enumerate(rows):
            for key, value in each.items():
                if key[1] == LIVE:
                    lasting[row, key[2]] = value
                    continue
                if key not in columns:
                    columns[key] = len(columns)
                    owners.setdefault(key[0], []).append(columns[key])
                deviation = self._covariances_of.deviation(key[:2], self.drops.get(key))
                new.append((row, columns[key], value * deviation))
        fresh = np.zeros((len(rows), len(columns)))
        for row, column, value in new:
            fresh[row, column] = value
        return GroupSlopes(lasting, fresh, owners, memory)


def _moved(slopes: GroupSlopes, rows: slice, covariance: Array | None, columns: list[int]) -> Array:
    """Return S P S' + R R' of some rows, for the random numbers in some columns."""
    lasting, fresh = slopes.lasting[rows], slopes.fresh[rows][:, columns]
    old = 0.0 if covariance is None else lasting @ covariance @ lasting.T
    return np.asarray(old + fresh @ fresh.T)


def _squares(slopes: GroupSlopes, rows: slice, covariance: Array | None, columns: list[int]) -> Array:
    """Return the diagonal of S P S' + R R' of some rows."""
    lasting, fresh = slopes.lasting[rows], slopes.fresh[rows][:, columns]
    old = 0.0 if covariance is None else np.sum((lasting @ covariance) * lasting, axis=1)
    return np.asarray(old + np.sum(fresh**2, axis=1))
