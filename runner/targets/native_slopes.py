"""Ticks of a loop that is cut at one wire, each a linear map of its own, in machine code: what `SteppedTicks` gives.

Each number that lasts and has a slope, and the input at the wire, has a lane of its own.
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from types import MappingProxyType

import numpy as np

from proofmass.blocks.arithmetic.mantissa import left_over
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_functions import reaches
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices, TickSlopes, UndefinedSlopesError
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.keys import LargestOf, StateField, WireOf
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.slope_tick import (
    AS_BEFORE,
    AT_REST,
    AT_THE_WIRE,
    INPUT,
    MOVED,
    RENEWED,
    VALUE,
    VALUED,
    write_slopes,
)
from proofmass.runner.program.slots import FLOATS, INTEGERS
from proofmass.runner.program.varying import ALL
from proofmass.runner.targets.lane_text import LanesOf
from proofmass.runner.targets.machine_code import Settings, load_lanes
from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
from proofmass.runner.targets.native_lanes import aligned

_ENTRIES = 1 << 20  # numbers of the rows of one call, which fit in a cache
_LANES = 16  # directions side by side
_NONE = -2  # instead of a direction: of a lane that is idle


class SlopeCode:
    """Machine code of the ticks of a plan with their slopes, whichever wire is cut."""

    def __init__(self, plan: Plan) -> None:
        made = write_slopes(plan)
        self.plan, self.wires = plan, made.wires
        of_entry = LanesOf(frozenset(), made.shared, dict.fromkeys(made.apart, ALL))
        loop = load_lanes(made.program, _LANES, of_entry, Settings(wide=True))
        self.compiled = CompiledPlan(plan, made.written, loop)

    def ticks(
        self,
        memory: Memory,
        node: Endpoint,
        seeded: AbstractSet[LastingPlace],
        moving: AbstractSet[str],
        plan: Plan | None = None,
    ) -> "CompiledSlopes":
        """Return ticks from a memory on with slopes by some numbers that last, and by an input at a wire.

        They are those of the plan, or of another that differs in numbers alone.
        """
        return CompiledSlopes(self, plan or self.plan, memory, node, seeded, moving)


def has_slopes(plan: Plan) -> bool:
    """Return whether the slopes of a plan's ticks are those of its program: its groups are linear, no loop is solved,
    and no search by signs leaves a slope that its integers lack."""
    if plan.schedule.loops or any(not solver.exact or solver.group.loops for solver in plan.solvers):
        return False
    kinds = {type(plan.blocks[name]) for name in plan.digital}
    return not any(reaches(each.function, (left_over,)) for kind in kinds for each in kind.functions.values())


def _in_lanes(length: int) -> AnyArray:
    """Return a row of zeros, one for each lane, for each of some entries."""
    rows = aligned((length, _LANES), np.dtype(float))
    rows.fill(0.0)
    return rows


class CompiledSlopes(CompiledLoop):
    """Ticks of some blocks, `moving`, that are cut at a wire."""

    sources: Sequence[tuple[str, str, int]] = ()  # of noise: there is none, as in `NoisyTicks` without
    quantised: Mapping[tuple[str, str, int], float] = MappingProxyType({})

    def __init__(
        self,
        code: SlopeCode,
        plan: Plan,
        memory: Memory,
        node: Endpoint,
        seeded: AbstractSet[LastingPlace],
        moving: AbstractSet[str],
    ) -> None:
        super().__init__(plan, plan.graph.seed, 0, memory, code.compiled)
        self._first = self.tick
        self.recorded: dict[Endpoint, list[float]] = {node: []}
        self.injected: list[tuple[str, str, int]] = []
        self._node = node
        self._moved = [*self._state.values(), *(v for n, v in self._vectors.items() if n not in code.plan.recorded)]
        self._places = self._numbered(moving)
        lengths = np.array([len(array) for array in self._moved])
        begins = np.cumsum(lengths) - lengths
        numbers = np.array([*self._places], dtype=np.int64)
        own = np.searchsorted(begins, numbers, side="right") - 1  # the array of each
        kept, ends = numbers - begins[own], np.searchsorted(own, np.arange(len(lengths)), side="right")
        at_the_wire = np.array([code.wires[node], AS_BEFORE]), _in_lanes(AT_THE_WIRE)
        slopes = [_in_lanes(len(array)) for array in (self._scratch, *self._moved)]
        before = [array.copy() for array in self._moved]
        self._arrays = [*self.arrays(()), *at_the_wire, *slopes, *before, lengths, kept, ends]  # addresses are passed
        self._addresses = [array.ctypes.data for array in self._arrays]
        self._live = np.array([place in seeded for place in self._places.values()], dtype=bool)
        self._wanted = self._live.copy()  # numbers whose directions are run
        self._renewing = np.zeros(len(self._places) + 1, dtype=bool)  # directions, and the input: may it move matrices?
        self._kept: list[
            tuple[AnyArray, AnyArray, AnyArray, AnyArray, AnyArray]
        ] = []  # tick, row, column, value; valued

    @property
    def live(self) -> set[LastingPlace]:
        """Numbers that last and have slopes."""
        return {place for place, has in zip(self._places.values(), self._live.tolist(), strict=True) if has}

    def _numbered(self, moving: AbstractSet[str]) -> dict[int, LastingPlace]:
        """Return the numbers that last to the next tick by their place among all that moves, in order."""
        places, kinds = dict[int, LastingPlace](), self._written.memory.kinds
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
        return dict(sorted(places.items()))

    def _lasts(self, node: Endpoint) -> bool:
        """Return whether a wire is read in ticks in which it is not computed."""
        return self.plan.stride(node) > 1

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; raises `UndefinedSlopesError`."""
        sound, chunk = True, 1
        renewing = self._renewing.copy()  # directions that move matrices of groups, and the input
        before = renewing.copy()  # those that did in the tick before: others seldom do
        while sound and self.tick < last:
            self._wanted |= self._live
            most = max(1, _ENTRIES // (len(self._places) * (_LANES + int(self._wanted.sum())) + 1))
            until = min(last, self.tick + min(chunk, most))
            begin = [array.copy() for array in self._moved]
            made, lanes = self._in_directions(until)
            slopes, at_the_wire = made[:, :, : len(self._places) + 1], made[:, :, len(self._places) :]
            apart = slopes != 0.0
            live = self._followed(apart, lanes)
            moved = np.zeros((len(made), len(renewing) + 1), dtype=bool)
            moved[:, lanes] = at_the_wire[:, :, MOVED] != 0.0
            moved = moved[:, :-1]
            unforeseen = np.flatnonzero((moved & ~self._renewing).any(axis=1))[:1]
            missing = (live[:-1].any(axis=0) & ~self._wanted).any()
            if missing or len(unforeseen):
                for array, earlier in zip(self._moved, begin, strict=True):
                    array[:] = earlier
                if missing:  # once more, with the directions that were missing
                    self._wanted |= live.any(axis=0)
                elif unforeseen[0]:  # up to the tick in which they move
                    chunk = int(unforeseen[0])
                else:
                    renewing |= before & moved[0]
                    before, chunk = moved[0], 1
                    self._renewing = np.ones_like(renewing)
                continue
            self._keep(slopes, apart, lanes, live[:-1], at_the_wire[:, 0, :, 0])
            self._live, self.tick, chunk = live[-1], until, most
            self._renewing = renewing
            sound = self.sound(self._state[FLOATS], self._state[INTEGERS])
        return sound

    def slopes(self) -> TickSlopes:
        """Return the slopes of all ticks."""
        tick, row, column, value, valued = (np.concatenate(several) for several in zip(*self._kept, strict=True))
        return TickSlopes(tuple(self._places.values()), tick, row, column, value, valued)

    def _in_directions(self, until: int) -> tuple[AnyArray, Indices]:
        """Return slopes of some ticks, [tick, row, place or what stands at the wire, lane], and the number of the place
        whose direction each lane of a row has, with the input behind all places, and -1 of a lane that is idle.

        In a tick in which a direction moves matrices of groups, slopes hold if it is one that is expected to.
        """
        wanted = np.append(np.flatnonzero(self._wanted), len(self._places))
        parts = [wanted[~self._renewing[wanted]], wanted[self._renewing[wanted]]]
        rows = [-(-len(part) // _LANES) for part in parts]
        lanes = np.full((sum(rows), _LANES), -1)
        lanes[: rows[0]].reshape(-1)[: len(parts[0])] = parts[0]
        lanes[rows[0] :].reshape(-1)[: len(parts[1])] = parts[1]
        directions = aligned(lanes.shape, np.dtype(np.int64))
        directions[:] = np.array([*self._places, INPUT, _NONE])[lanes]
        matrices = np.array([AS_BEFORE] * rows[0] + [RENEWED] * rows[1])
        matrices[: min(rows[0], 1)] = AT_REST  # after the last row of the tick before
        made = aligned((until - self.tick, sum(rows), len(self._places) + AT_THE_WIRE, _LANES), np.dtype(float))
        given = *self._addresses, directions.ctypes.data, matrices.ctypes.data, sum(rows), made.ctypes.data
        self._loop(self.tick, until, self.seed, self.run, *given)
        return made, lanes

    def _followed(self, apart: AnyArray, lanes: Indices) -> AnyArray:
        """Return which numbers have slopes as each tick begins, and after the last."""
        live = np.vstack(
            [self._live, np.any(np.any(apart[:, :, :-1], axis=1), axis=2)]
        )  # where all that are run have slopes
        for tick, (now, entries) in enumerate(zip(live, apart[:, :, :-1], strict=False)):
            own = np.append(now, True)[lanes]
            if not own[lanes >= 0].all():
                live[tick + 1] = (entries & own[:, None]).any(axis=(0, 2))
        return np.asarray(live)

    def _keep(self, slopes: AnyArray, apart: AnyArray, lanes: Indices, live: AnyArray, at_the_wire: AnyArray) -> None:
        """Keep the slopes of some ticks, where they are `apart` from nothing and of numbers that had slopes."""
        own = np.column_stack([live, np.ones(len(live), dtype=bool)])[:, lanes]
        if not own[:, lanes >= 0].all():
            apart &= own[:, :, None]
        tick, group, row, lane = np.unravel_index(np.flatnonzero(apart), apart.shape)
        values, column = slopes[tick, group, row, lane], lanes[group, lane]
        undefined = np.unique(column[~np.isfinite(values)]).tolist()
        if undefined:
            places = [*self._places.values()]
            raise UndefinedSlopesError([places[i] for i in undefined if i < len(places)])
        valued = at_the_wire[:, VALUED] != 0.0
        for value in at_the_wire[valued, VALUE].tolist():
            self.injected.append((*self._node, len(self.injected)))
            self.recorded[self._node].append(value)
        self._kept.append((tick + (self.tick - self._first), row, column, values, valued))
