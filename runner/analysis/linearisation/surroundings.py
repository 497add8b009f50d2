"""Surroundings of a memory: what a period makes of memories that differ from it in some numbers."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from proofmass.runner.analysis.linearisation.rings import Entry, Rings
from proofmass.runner.analysis.linearisation.seeds import at_place, held_in, place_of, put
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory

_ROUNDED = 1e-9  # part of what makes up a number, by which a whole turn may move it


@dataclass(frozen=True)
class Surroundings:
    """Numbers of a memory that matter, and a run on from there over a period."""

    entries: Sequence[Entry]
    memory: Memory
    rings: Rings
    after: Callable[[Memory], Memory]

    def numbers(self, memory: Memory) -> Array:
        """Return what another memory has for the entries."""
        return np.array([float(held_in(memory, entry, self.rings)) for entry in self.entries])

    def change(self, by: Mapping[Entry, float]) -> Array:
        """Return by how much the numbers after the period differ if some of those before it do."""
        return self.numbers(self.after(moved(self.memory, by, self.rings))) - self._after

    def turns(self, entry: Entry, a: Array) -> bool:
        """Return whether a whole turn of a number changes nothing, by the map `a` of the period but for rounding."""
        scale = np.abs(a) @ np.abs(self.numbers(self.memory))
        scale[self.entries.index(entry)] += 1.0
        return bool((np.abs(self.change({entry: 1.0})) <= _ROUNDED * scale).all())

    @cached_property
    def _after(self) -> Array:
        return self.numbers(self.after(self.memory))


def moved(memory: Memory, by: Mapping[Entry, float], rings: Rings) -> Memory:
    """Return a copy of a memory with some numbers moved on."""
    copy = memory.copy()
    for entry, step in by.items():
        at = place_of(copy, entry, rings)
        put(copy, at, at_place(copy, at) + step)
    return copy
