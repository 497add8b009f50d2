"""Changes between the maps of a search, each found once: they are asked for again and again."""

from collections.abc import Hashable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.map_changes import change_between, effect
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array, Complex

_Pair = tuple[PeriodMap, PeriodMap]


class ComparedMaps:
    """Maps between some ends. They are told apart by their ids, and so kept alive."""

    def __init__(self, ends: Ends) -> None:
        self._ends = ends
        self._shown = dict[int, _Pair]()
        self._pairs = dict[Hashable, tuple[_Pair, _Pair]]()
        self._found = dict[Hashable, tuple[_Pair, float]]()

    def change(self, first: PeriodMap, after: PeriodMap) -> float:
        """Return what `change_between` does."""
        key = id(first), id(after)
        if key not in self._found:
            self._found[key] = (first, after), change_between(*self._both(first, after))
        return self._found[key][1]

    def effect(self, first: PeriodMap, after: PeriodMap, z: Complex) -> float:
        """Return what `effect` does."""
        key = id(first), id(after), z.tobytes()
        if key not in self._found:
            self._found[key] = (first, after), effect(*self._both(first, after), z)
        return self._found[key][1]

    def _both(self, first: PeriodMap, after: PeriodMap) -> _Pair:
        """Return both maps as `shown`, with one value of a wire for those that it holds in both."""
        key = id(first), id(after)
        if key not in self._pairs:
            self._pairs[key] = (first, after), _held_once(self.shown(first), self.shown(after))
        return self._pairs[key][1]

    def shown(self, of: PeriodMap) -> PeriodMap:
        """Return the map to the outputs that are asked for, without those of quantisers, which may be thousands."""
        if not self._ends.noise:
            return of
        if id(of) not in self._shown:
            wanted = [i for i, entry in enumerate(of.outputs) if entry[:2] in self._ends.outputs]
            self._shown[id(of)] = of, replace(of, slopes={}, later=()).to_outputs(wanted)
        return self._shown[id(of)][1]


def _held_once(first: PeriodMap, after: PeriodMap) -> _Pair:
    """Return two maps with one row for those of a wire that are alike one after the other, with the norm of all."""
    if (first.states, first.inputs, first.outputs) != (after.states, after.inputs, after.outputs) or first.slopes:
        return first, after
    wires = [entry[:2] for entry in first.outputs]
    new = np.array([one != other for one, other in pairwise(wires)], dtype=bool)
    for of in (first, after):
        rows = of.matrix[of.order :, :-1]
        new |= (rows[1:] != rows[:-1]).any(axis=1)
    if new.all():
        return first, after
    begins = np.flatnonzero(np.append(True, new))
    sizes = np.sqrt(np.diff(np.append(begins, len(wires))))
    return _of_rows(first, begins, sizes), _of_rows(after, begins, sizes)


def _of_rows(of: PeriodMap, outputs: Indices, sizes: Array) -> PeriodMap:
    part = of.to_outputs(outputs.tolist())
    matrix = part.matrix.copy()
    matrix[of.order :] *= sizes[:, None]
    return replace(part, matrix=matrix)
