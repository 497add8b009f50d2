"""Memories, maps and numbers of a run from period to period, each found once, for a search for an
operating point.

So are the changes between maps, which are asked for again and again.
"""

import math
from collections.abc import Hashable
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import replace
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Onward
from proofmass.runner.analysis.linearisation.map_changes import change_between, effect
from proofmass.runner.analysis.linearisation.numbers import Orbit, wires_of
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry, Rings, find_rings
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.targets.native_slopes import CompiledSlopes, SlopeCode

FEW = 256  # periods of a stretch that may as well be twice as long
_FORGOTTEN, _ENOUGH = 8.0, 2.5  # time constants of the lowest crossover in a stretch, and times as many as it may have
_SLOW = 50_000  # periods times blocks of a stretch, in plain Python
_Pair = tuple[PeriodMap, PeriodMap]


class OrbitRun:
    """A run on from an operating point, the start of a period of the map between some ends."""

    def __init__(self, plan: Plan, ends: Ends, onward: Onward) -> None:
        self._plan, self._onward, self._ends = plan, onward, ends
        self.course = onward.course
        self.ticks = ends.common_period(plan)  # base ticks of a period
        self.first = onward.begin.tick
        self.upstream, self.moving = ends.blocks(plan)
        self.names = sorted(self.upstream)
        self.memories = {0: onward.begin}
        self._maps = dict[tuple[int, int], PeriodMap]()
        self._orbits = dict[tuple[bool, int], Orbit]()  # paired or not, and of how many periods
        self.rings = find_rings(self.course.plan, self.moving, self.after)

    def after(self, periods: int) -> Memory:
        """Return the memory some periods after the operating point."""
        if periods not in self.memories:
            self.memories[periods] = self._onward.at(self.first + periods * self.ticks)
        return self.memories[periods]

    def later(self, memory: Memory, ticks: int) -> Memory:
        """Return the memory some ticks after another."""
        return self.course.from_memory(memory).to(memory.tick + ticks)

    def map(self, after: int, periods: int = 1) -> PeriodMap:
        """Return the map of some periods that follow some others."""
        if (after, periods) not in self._maps:
            own = self._part_of_all(after, periods) if self._ends.beside else None
            self._maps[after, periods] = own or self._map_of(self._ends, self.rings, after, periods)
        return self._maps[after, periods]

    def knows(self, after: int) -> bool:
        """Return whether the map of a period after some others is there."""
        return (after, 1) in self._maps

    def _map_of(self, ends: Ends, rings: Rings, after: int, periods: int) -> PeriodMap:
        memory, slopes, opened = self.after(after).copy(), self.course.slopes, self._opened if ends.cut else None
        options = {"rings": rings, "slopes": slopes, "later": self.later, "opened": opened}
        return ends.map(self._plan, memory=memory, periods=periods, **options)

    @cached_property
    def _alike(self) -> set[Endpoint]:
        """Wires of loops among the same blocks."""
        return {
            node for node in self.course.loops if self._is_alike(replace(self._ends, inputs=(node,), outputs=(node,)))
        }

    def _is_alike(self, ends: Ends) -> bool:
        return ends.blocks(self._plan) == (self.upstream, self.moving) and ends.common_period(self._plan) == self.ticks

    def _opened(
        self, code: "SlopeCode", memory: Memory, ticks: int, seeded: AbstractSet[LastingPlace]
    ) -> "CompiledSlopes | None":
        """Return the slopes of ticks of a loop, taken together with those of others; None if it is alone."""
        (node,), kept = self._ends.inputs, self._onward.slopes
        nodes = sorted(self._alike & code.wires.keys(), key=code.wires.__getitem__)  # as they follow in a tick
        if node not in nodes or len(nodes) < 2:
            return None
        key = memory.tick, ticks, *nodes
        if key not in kept:
            engine = code.ticks(memory, nodes, seeded, self.moving, code.of(self.course.plan))
            with suppress(ArithmeticError):  # what another of them has no slope of may not matter to this one
                kept[key] = engine if engine.advance(memory.tick + ticks, ()) else None, {*nodes}
        whole, left = kept.setdefault(key, (None, {*nodes}))
        left.discard(node)
        if not left:
            del kept[key]
        return whole and whole.opened_at(node)

    def _part_of_all(self, after: int, periods: int) -> PeriodMap | None:
        """Return the part of the map to all outputs that are asked for, which is taken once; None if there is none."""
        together, kept = self._ends.together, self._onward.maps
        key = together.key, after, periods
        if key not in kept:
            rings = find_rings(self.course.plan, together.blocks(self._plan)[1], self.after)
            try:
                kept[key] = self._map_of(together, rings, after, periods)
            except ModelError:  # what another output has no map for may not matter to this one
                kept[key] = None
        whole = kept[key]
        return whole and self._ends.part_of(whole, self._plan)

    def moves(self) -> bool:
        """Return whether anything that the map depends on changes: states, or wires in the last tick of a period."""
        before, once, twice = map(self.after, range(3))
        held = sorted(self.upstream & self._plan.schedule.phases.keys())  # read before they are computed anew
        if self.states(once) | dict(wires_of(once, held)) != self.states(before) | dict(wires_of(before, held)):
            return True
        return dict(wires_of(once, self.names)) != dict(wires_of(twice, self.names))

    def states(self, memory: Memory) -> dict[Entry, float]:
        """Return the numbers of a memory, with rings turned back."""
        return dict(self.rings.states_of(memory, self.names))

    def crossovers(self, of_period: PeriodMap) -> list[float]:
        """Return where |L| of a loop is about 1, in Hz, from the lowest on; of several, where that of one is."""
        crossovers = list[float]()
        for node in self._ends.inputs if self._ends.cut else ():
            ends = replace(self._ends, inputs=(node,), outputs=(node,))
            system = OpenLoop(ends.wires_of(of_period).between())
            w = np.geomspace(1e-9, 0.999, 900) * math.pi / system.sample
            above = np.abs(system.response(w)) > 1.0
            crossovers += [float(w[i]) / (2.0 * math.pi) for i in np.flatnonzero(above[:-1] != above[1:])]
        return sorted(crossovers)

    def forgotten(self, first: PeriodMap, longest: int) -> int:
        """Return the number of periods in which a loop forgets itself; 0 if they are too many.

        The crossover in one period is that of the carrier's place there: that in about as many tells.
        """
        periods, of = 1, first
        while self._ends.cut:
            crossovers = self.crossovers(of)
            times = _FORGOTTEN / (2.0 * math.pi * crossovers[0] * first.period) if crossovers else math.inf
            if times <= _ENOUGH * periods:
                return periods
            wanted = min(math.ceil(times) if times <= longest else FEW, longest)
            slow = self.course.slopes() is None and wanted * len(self.moving) > _SLOW
            if wanted <= periods or slow:
                return 0
            periods, of = wanted, self.map(0, wanted)
        return 0

    def orbit(self, paired: bool, most: int) -> Orbit:
        """Return what some periods that follow leave in states and wires."""
        if (paired, most) not in self._orbits:
            memories = map(self.after, range(1, 2 + most))
            rows = [self.states(memory) | dict(wires_of(memory, self.names)) for memory in memories]
            self._orbits[paired, most] = Orbit(rows, paired=paired)
        return self._orbits[paired, most]

    def slowest_ring(self) -> tuple[str, str, float]:
        """Return the block and buffer whose place is back last, and the part of its turn that it moves in a period."""
        if not self.rings.of:
            return self.names[0], self.names[0], 0.0
        (name, buffer), ring = max(self.rings.of.items(), key=lambda item: item[1].turn)
        return name, f"{name}.{buffer}", 1.0 / ring.turn


class ComparedMaps:
    """Maps between some ends. Ids tell them apart, so they are kept alive; those of the same numbers are one."""

    def __init__(self, ends: Ends) -> None:
        self._ends = ends
        self._shown = dict[int, _Pair]()
        self._alike = dict[Hashable, PeriodMap]()
        self._pairs = dict[Hashable, _Pair]()
        self._found = dict[Hashable, float]()

    def change(self, first: PeriodMap, after: PeriodMap) -> float:
        """Return what `change_between` does."""
        key, both = self._both(first, after)
        if key not in self._found:
            self._found[key] = change_between(*both)
        return self._found[key]

    def effect(self, first: PeriodMap, after: PeriodMap, z: Complex) -> float:
        """Return what `effect` does."""
        pair, both = self._both(first, after)
        key = *pair, z.tobytes()
        if key not in self._found:
            self._found[key] = effect(*both, z)
        return self._found[key]

    def _both(self, first: PeriodMap, after: PeriodMap) -> tuple[tuple[int, int], _Pair]:
        """Return both maps as `shown`, with one value of a wire for those that it holds in both, and their ids."""
        first, after = self.shown(first), self.shown(after)
        key = id(first), id(after)
        if key not in self._pairs:
            self._pairs[key] = _held_once(first, after)
        return key, self._pairs[key]

    def shown(self, of: PeriodMap) -> PeriodMap:
        """Return the map to the outputs that are asked for, without those of quantisers, which may be thousands."""
        if id(of) not in self._shown:
            shown = of
            if self._ends.noise:
                wanted = [i for i, entry in enumerate(of.outputs) if entry[:2] in self._ends.outputs]
                shown = replace(of, slopes={}, later=()).to_outputs(wanted)
                numbers = shown.states, shown.inputs, shown.outputs, shown.matrix[:, :-1].tobytes()
                shown = self._alike.setdefault(numbers, shown)
            self._shown[id(of)] = of, shown
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
