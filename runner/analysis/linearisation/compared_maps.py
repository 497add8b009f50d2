"""Changes between the maps of a search, each found once: they are asked for again and again."""

from collections.abc import Hashable
from dataclasses import replace

from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.map_changes import change_between, effect
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.host.arrays import Complex

_Pair = tuple[PeriodMap, PeriodMap]


class ComparedMaps:
    """Maps between some ends. They are told apart by their ids, and so kept alive."""

    def __init__(self, ends: Ends) -> None:
        self._ends = ends
        self._shown = dict[int, _Pair]()
        self._found = dict[Hashable, tuple[_Pair, float]]()

    def change(self, first: PeriodMap, after: PeriodMap) -> float:
        """Return what `change_between` does."""
        key = id(first), id(after)
        if key not in self._found:
            self._found[key] = (first, after), change_between(self.shown(first), self.shown(after))
        return self._found[key][1]

    def effect(self, first: PeriodMap, after: PeriodMap, z: Complex) -> float:
        """Return what `effect` does."""
        key = id(first), id(after), z.tobytes()
        if key not in self._found:
            self._found[key] = (first, after), effect(self.shown(first), self.shown(after), z)
        return self._found[key][1]

    def shown(self, of: PeriodMap) -> PeriodMap:
        """Return the map to the outputs that are asked for, without those of quantisers, which may be thousands."""
        if not self._ends.noise:
            return of
        if id(of) not in self._shown:
            wanted = [i for i, entry in enumerate(of.outputs) if entry[:2] in self._ends.outputs]
            self._shown[id(of)] = of, replace(of, slopes={}).with_ends(wanted, range(len(of.inputs)))
        return self._shown[id(of)][1]
