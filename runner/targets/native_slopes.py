"""Ticks of a loop that is cut at one wire, each a linear map of its own, in machine code: what `SteppedTicks` gives.

A tick runs once for each number that lasts and has a slope, and once for the input at the wire.
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from types import MappingProxyType

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_ticks import Place
from proofmass.runner.derivatives.stepped_ticks import TickMap, UndefinedSlopesError
from proofmass.runner.plan.keys import LargestOf, StateField, WireOf
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.slope_tick import AT_THE_WIRE, INPUT, READ, VALUE, VALUED, write_slopes
from proofmass.runner.program.slots import FLOATS, INTEGERS
from proofmass.runner.targets.machine_code import load
from proofmass.runner.targets.native import Array, CompiledLoop, CompiledPlan, settings


class SlopeCode:
    """Machine code of the ticks of a plan with their slopes, whichever wire is cut."""

    def __init__(self, plan: Plan) -> None:
        made = write_slopes(plan)
        self.plan, self.wires = plan, made.wires
        self.compiled = CompiledPlan(plan, made.written, load(made.program, settings(made.written)))

    def ticks(
        self, memory: Memory, node: Endpoint, seeded: AbstractSet[Place], moving: AbstractSet[str]
    ) -> "CompiledSlopes":
        """Return ticks from a memory on with slopes by some numbers that last, and by an input at a wire."""
        return CompiledSlopes(self, memory, node, seeded, moving)


def has_slopes(plan: Plan) -> bool:
    """Return whether the slopes of a plan's ticks are those of its program: its groups are linear, and no loop is
    solved."""
    return not plan.schedule.loops and all(solver.exact and not solver.group.loops for solver in plan.solvers)


class CompiledSlopes(CompiledLoop):
    """Ticks of some blocks, `moving`, that are cut at a wire."""

    sources: Sequence[tuple[str, str, int]] = ()  # of noise: there is none, as in `NoisyTicks` without
    quantised: Mapping[tuple[str, str, int], float] = MappingProxyType({})

    def __init__(
        self, code: SlopeCode, memory: Memory, node: Endpoint, seeded: AbstractSet[Place], moving: AbstractSet[str]
    ) -> None:
        super().__init__(code.plan, code.plan.graph.seed, 0, memory, code.compiled)
        self.ticks: list[TickMap] = []
        self.recorded: dict[Endpoint, list[float]] = {node: []}
        self.injected: list[tuple[str, str, int]] = []
        self._node = node
        self._moved = [*self._state.values(), *(v for n, v in self._vectors.items() if n not in code.plan.recorded)]
        self._before = [array.copy() for array in self._moved]
        slopes = [np.zeros(len(array)) for array in self._moved]
        self._places = self._numbered(moving)
        at_the_wire = np.array([code.wires[node]]), np.zeros(AT_THE_WIRE)
        lengths = np.array([len(array) for array in self._moved])
        given = [*self.arrays(()), *at_the_wire, np.zeros(len(self._scratch))]
        self._arrays = [*given, *slopes, *self._before, lengths]  # whose addresses are passed
        self._addresses = [array.ctypes.data for array in self._arrays]
        self._width = int(lengths.sum()) + AT_THE_WIRE
        self._live = np.array([n for n, place in self._places.items() if place in seeded], dtype=np.int64)

    @property
    def live(self) -> set[Place]:
        """Numbers that last and have slopes."""
        return {self._places[n] for n in self._live.tolist()}

    def _numbered(self, moving: AbstractSet[str]) -> dict[int, Place]:
        """Return the numbers that last to the next tick by their number among all that moves."""
        places, kinds = dict[int, Place](), self._written.memory.kinds
        first = {FLOATS: 0, INTEGERS: len(self._state[FLOATS])}
        for key, (kind, index) in kinds.items():
            number = first[FLOATS if kind is float else INTEGERS] + index
            match key:
                case StateField(block, field) if block in moving and kind is not bool:
                    fields = type(self.plan.blocks[block]).state_class()._fields  # type: ignore[union-attr]
                    places[number] = "state", block, fields.index(field)
                case WireOf(block, port) if block in moving and kind is not bool and self._lasts((block, port)):
                    places[number] = "wire", (block, port), 0
        begin = sum(map(len, self._state.values()))
        for node, array in self._vectors.items():
            if node in self.plan.recorded:
                continue
            if not isinstance(node, LargestOf) and node[0] in moving:
                kept = node in self.plan.buffers
                entries = range(len(array)) if kept or self._lasts(node) else ()
                places |= {begin + i: ("buffer" if kept else "wire", node, i) for i in entries}
            begin += len(array)
        return places

    def _lasts(self, node: Endpoint) -> bool:
        """Return whether a wire is read in ticks in which it is not computed."""
        return self.plan.stride(node) > 1

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `UndefinedSlopesError`."""
        sound = True
        while sound and self.tick < last:
            for before, array in zip(self._before, self._moved, strict=True):
                before[:] = array
            made = self._in_directions([*self._live.tolist(), INPUT])
            self.tick += 1
            sound = self.sound(self._state[FLOATS], self._state[INTEGERS])
            self._keep(made)
        return sound

    def _in_directions(self, directions: Sequence[int]) -> Array:
        """Return the slopes of one tick: a row for each direction."""
        numbers, rows = np.array(directions), np.zeros((len(directions), self._width))
        addresses = *self._addresses, numbers.ctypes.data, len(numbers), rows.ctypes.data
        self._loop(self.tick, self.tick + 1, self.seed, self.run, *addresses)
        return rows

    def _keep(self, made: Array) -> None:
        sources = [self._places[n] for n in self._live.tolist()]
        wire = self._width - AT_THE_WIRE
        numbers = [n for n in np.flatnonzero(made[:, :wire].any(axis=0)).tolist() if n in self._places]
        valued = bool(made[0, wire + VALUED])
        kept = made[:, [*numbers, wire + READ]]
        undefined = np.flatnonzero(~np.isfinite(kept).all(axis=1))
        if len(undefined):
            raise UndefinedSlopesError([sources[row] for row in undefined if row < len(sources)])
        slopes: list[dict[Place, float]] = [{} for _ in kept.T]
        for column, row in zip(*map(np.ndarray.tolist, np.nonzero(kept[:-1].T)), strict=True):
            slopes[column][sources[row]] = float(kept[row, column])
        places = [self._places[n] for n in numbers]
        entered = {place: slope for place, slope in zip(places, kept[-1].tolist(), strict=False) if slope}
        if valued:
            self.injected.append((*self._node, len(self.injected)))
            self.recorded[self._node].append(float(made[0, wire + VALUE]))
        self.ticks.append(TickMap(dict(zip(places, slopes, strict=False)), entered, slopes[-1] if valued else None))
        self._live = np.array(numbers, dtype=np.int64)
