"""The numbers of a graph at the ends of successive periods: what moves, and when it comes back."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.runner.plan.memory import Memory

_BACK = 0.1  # part of its swing by which a number may miss its old value when an orbit closes
_TRIES = 6  # numbers of periods that are tried
_ROUNDING = 1e-12
_STILL = 1e-3  # part of its size below which the swing of a number counts as dither


class Orbit:
    """Numbers of a graph at the ends of successive periods."""

    def __init__(
        self, rows: Sequence[Mapping[Any, float]], paired: bool = False, sizes: Mapping[Any, float] | None = None
    ) -> None:
        """Take the numbers of each period; `paired` with those of the next, since a sine has a
        value twice a cycle.

        What moves by a rounding of the largest values that numbers have had, `sizes`, stands still.
        """
        keys = sorted(set.intersection(*map(set, rows)))
        values = np.array([[row[key] for key in keys] for row in rows], dtype=float).reshape(len(rows), len(keys))
        swing, size = np.ptp(values, axis=0), np.max(np.abs(values), axis=0)
        steps = np.diff(values, axis=0)
        straight = (steps >= 0.0).all(axis=0) | (steps <= 0.0).all(axis=0)  # as phases do
        largest = np.array([(sizes or {}).get(key, 0.0) for key in keys])
        moving = (swing > _STILL * size) & (swing > _ROUNDING * largest)
        self._paired = paired
        self._keys, self._values, self._swing = keys, values, swing
        self.turning = np.flatnonzero(moving & ~straight)
        self._moving, self._straight = np.flatnonzero(moving), np.flatnonzero(moving & straight)

    @property
    def turning_keys(self) -> list[tuple[str, str, int]]:
        """Names of the numbers that go to and fro."""
        return [self._keys[int(i)] for i in self.turning]

    @property
    def straight_keys(self) -> list[tuple[str, str, int]]:
        """Names of the numbers that move one way."""
        return [self._keys[int(i)] for i in self._straight]

    def returns(self, back: float = _BACK) -> Iterator[int]:
        """Numbers of periods after which all that goes to and fro is closer to where it was than ever before.

        It may miss that by a part `back` of its swing.
        """
        chosen = self.turning
        if not len(chosen):
            return
        apart = np.abs(self._values[1:, chosen] - self._values[0, chosen])
        if self._paired:
            apart = np.maximum(apart[:-1], np.abs(self._values[2:, chosen] - self._values[1, chosen]))
        miss = (apart / self._swing[chosen]).max(axis=1)
        best = np.minimum.accumulate(miss)
        closer = np.flatnonzero((miss < back) & (miss < np.concatenate([[np.inf], best[:-1]])))
        yield from (int(i) + 1 for i in closer[:_TRIES])

    def nearest(self, least: int, most: int) -> int:
        """Return after how many periods, from `least` to `most`, what goes to and fro is nearest to where it was."""
        chosen = self.turning
        apart = (self._values[least : most + 1, chosen] - self._values[0, chosen]) / self._swing[chosen]
        return least + int(np.argmin(np.sum(apart**2, axis=1)))

    def fastest(self) -> tuple[str, str, float] | None:
        """Block and number that moves most from a period to the next, and the part of its swing; None if none does."""
        chosen = self.turning if len(self.turning) else self._moving
        if not len(chosen):
            return None
        steps = np.abs(np.diff(self._values[:, chosen], axis=0)).max(axis=0) / self._swing[chosen]
        name, part, index = self._keys[chosen[int(np.argmax(steps))]]
        return name, f"{name}.{part}" + (f"[{index}]" if index >= 0 else ""), float(np.max(steps))


def wires_of(memory: Memory, names: Sequence[str]) -> Iterator[tuple[tuple[str, str, int], float]]:
    for (name, port), held in memory.wires.items():
        if name in names and not isinstance(held, list):
            yield (name, port, -1), held


def time_text(seconds: float) -> str:
    """Return a time with the largest unit of which there is one."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size * (1.0 - 1e-12):
            return f"{seconds / size:.6g} {unit}"
    return f"{seconds * 1e9:.6g} ns"
