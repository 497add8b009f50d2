"""Ticks as linear maps, each of its own, in machine code: `CompiledSlopes` gives what `SteppedTicks` does.

Each number that lasts and has a slope, and each event at which something enters, has a lane of its own.
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from copy import copy
from types import MappingProxyType

import numpy as np

from proofmass.blocks.arithmetic.mantissa import Drop
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import Indices, TickSlopes, UndefinedSlopesError
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.plan.keys import LargestOf, StateField, WireOf
from proofmass.runner.plan.memory import Memory, Rows
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.events import CUT, MOST, OF_LANE, OF_ONE_BIT, OF_STATE, SOURCE, TOLD, VALUED
from proofmass.runner.program.slope_tick import AS_BEFORE, AT_REST, FIRST_EVENT, NONE, RENEWED, SEEDED, write_slopes
from proofmass.runner.program.slots import FLOATS, INTEGERS, array_of
from proofmass.runner.program.varying import ALL
from proofmass.runner.targets.found_slopes import LANES, Found, ReusedArrays, StillRow, followed
from proofmass.runner.targets.lane_text import LanesOf
from proofmass.runner.targets.machine_code import QUICK, Settings, load_lanes
from proofmass.runner.targets.native import BegunNumbers, CompiledLoop, CompiledPlan
from proofmass.runner.targets.native_lanes import aligned
from proofmass.runner.targets.still_numbers import StillNumbers

_ENTRIES = 1 << 20  # numbers of the rows of one call, which fit in a cache
_OF_LOOPS, _OF_NOISE = Settings(wide=True), QUICK  # many sensors, or one


class SlopeCode:
    """Machine code of the ticks of a plan with their slopes, whichever wires are events; with all of `noise`.

    That of noise is made in little time, unless it is for a `long` period.
    """

    def __init__(self, plan: Plan, noise: bool = False, long: bool = False) -> None:
        made = write_slopes(plan, noise)
        self.plan, self.wires, self.blocks = plan, made.wires, made.blocks
        of_entry = LanesOf(frozenset(), made.shared, dict.fromkeys(made.apart, ALL))
        loop = load_lanes(made.program, LANES, of_entry, _OF_NOISE if noise and not long else _OF_LOOPS)
        self.compiled = CompiledPlan(plan, made.written, loop)

    def of(self, plan: Plan) -> Plan:
        """Return a plan that differs from that of the code in numbers alone, or the part of it that the code has."""
        return plan if len(plan.blocks) == len(self.blocks) else plan.part(self.blocks.keys())

    def ticks(
        self,
        memory: Memory,
        nodes: Sequence[Endpoint],
        seeded: AbstractSet[LastingPlace],
        moving: AbstractSet[str],
        plan: Plan | None = None,
    ) -> "CompiledSlopes":
        """Return ticks from a memory on with slopes by some numbers that last, and by an input at each of some wires.

        They are those of the plan, or of another that differs in numbers alone.
        """
        return CompiledSlopes(self, plan or self.plan, memory, nodes, seeded, moving)


def has_slopes(plan: Plan) -> bool:
    """Return whether the slopes of a plan's ticks are those of its program: groups are linear, no loop is solved."""
    return not (plan.schedule.loops or any(not solver.exact or solver.group.loops for solver in plan.solvers))


def _in_lanes(length: int) -> AnyArray:
    """Return a row of zeros, one for each lane, for each of some entries."""
    rows = aligned((length, LANES), np.dtype(float))
    rows.fill(0.0)
    return rows


class SlopesInCode(CompiledLoop):
    """Ticks with the slopes of some blocks, `moving`, by numbers that last and by events."""

    def __init__(
        self,
        code: SlopeCode,
        plan: Plan,
        memory: Memory,
        modes: Mapping[Endpoint, int],
        seeded: AbstractSet[LastingPlace],
        moving: AbstractSet[str],
        most: int,
    ) -> None:
        """Take numbers with slopes as ticks begin, and room for so many events of a tick."""
        super().__init__(plan, 0, 0, memory, code.compiled)
        self._first, self._most = self.tick, most
        self._moved = [*self._state.values(), *(v for n, v in self._vectors.items() if n not in code.plan.recorded)]
        self._places = self._numbered(moving)
        lengths = np.array([len(array) for array in self._moved])
        begins = np.cumsum(lengths) - lengths
        numbers = np.array([*self._places], dtype=np.int64)
        own = np.searchsorted(begins, numbers, side="right") - 1  # the array of each
        kept, ends = numbers - begins[own], np.searchsorted(own, np.arange(len(lengths)), side="right")
        of_wires = np.array([modes.get(node, 0) for node in code.wires] or [0], dtype=np.int64)
        events = [of_wires, self._one_bit(code), self._state_of_events(), np.zeros(MOST * TOLD)]
        slopes = [_in_lanes(len(array)) for array in (self._scratch, *self._moved)]
        before = [array.copy() for array in self._moved]
        self._seeds = _in_lanes(int(lengths.sum()))
        self._in_lanes = [_in_lanes(MOST), _in_lanes(OF_LANE), *slopes]
        self._arrays = [
            *self.arrays(()),
            *events,
            *self._in_lanes,
            *before,
            lengths,
            kept,
            ends,
            self._seeds,
        ]  # addresses are passed
        self._addresses = [array.ctypes.data for array in self._arrays]
        self._seeded = self._live = np.array([place in seeded for place in self._places.values()], dtype=bool)
        self._wanted = np.append(self._live, np.zeros(most, dtype=bool))  # numbers and events whose directions are run
        self._renewing = np.zeros(len(self._wanted), dtype=bool)  # which of these may move matrices
        self._chunk = 1  # ticks at once, until it is known which directions are wanted
        self._reused, self._still = ReusedArrays(), StillNumbers(len(self._places))

    def _state_of_events(self) -> AnyArray:
        """Return the state of events: no deviate has a value."""
        return np.zeros(OF_STATE, dtype=np.int64)

    def _one_bit(self, code: SlopeCode) -> AnyArray:
        """Return gains and deviations of quantisers of one bit, by block: there are none."""
        return np.full(OF_ONE_BIT * len(code.blocks), np.nan)

    def _entering(self, counts: Indices, told: AnyArray) -> tuple[AnyArray, AnyArray]:
        """Return at which events of some ticks something enters, and at which only if the number there has a slope."""
        entering = np.arange(self._most) < counts[:, None]
        return entering, np.zeros_like(entering)

    def _keep(self, found: Found, counts: Indices, told: AnyArray, entered: AnyArray) -> None:
        """Keep the slopes of some ticks, and what their events have told."""
        raise NotImplementedError

    @property
    def live(self) -> set[LastingPlace]:
        """Numbers that last and have slopes."""
        return {place for place, has in zip(self._places.values(), self._live.tolist(), strict=True) if has}

    def _numbered(self, moving: AbstractSet[str]) -> dict[int, LastingPlace]:
        """Return the numbers that last to the next tick by place among all that moves, in order."""
        places, kinds = dict[int, LastingPlace](), self._written.memory.kinds
        first = {FLOATS: 0, INTEGERS: len(self._state[FLOATS])}
        for key, (kind, index) in kinds.items():
            number = first[array_of(kind)] + index
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
        sound, chunk, size = True, self._chunk, len(self._places)
        renewing = self._renewing.copy()  # directions that move matrices of groups
        before = renewing.copy()  # those that did in the tick before: others seldom do
        while sound and self.tick < last:
            self._wanted[:size] |= self._live & ~self._still.now
            most = max(1, _ENTRIES // ((size + self._most) * (LANES + int(self._wanted.sum())) + 1))
            until = min(last, self.tick + min(chunk, most))
            begin = [array.copy() for array in self._moved]
            lanes, matrices, still = self._in_rows()
            made, counts, told = self._in_directions(until, lanes, matrices)
            moving, more = made[:, :, -1] != 0.0, int(counts.max()) - self._most
            entering, if_moved = self._entering(counts, told)
            given = made, lanes, self._live, entering, if_moved, still, self._reused
            found, lived, live, entered, left = followed(*given)
            needed = np.append(lived & ~self._still.now, (entering | if_moved).any(axis=0)) & ~self._wanted
            moved = np.zeros((len(made), len(self._wanted) + 1), dtype=bool)
            moved[:, lanes] = moving
            moved = moved[:, :-1]
            unforeseen = np.flatnonzero((moved & ~self._renewing).any(axis=1))[:1]
            if left < len(made) or more > 0 or needed.any() or len(unforeseen):
                for array, earlier in zip(self._moved, begin, strict=True):
                    array[:] = earlier
                if left and left < len(made):  # up to the tick in which they are not still
                    chunk = left
                elif left < len(made):
                    self._still.moved()
                elif more > 0:
                    self._make_room(more)
                    renewing, before = (np.append(each, np.zeros(more, dtype=bool)) for each in (renewing, before))
                elif needed.any():  # once more, with the directions that were missing
                    self._wanted |= needed
                elif unforeseen[0]:  # up to the tick in which they move
                    chunk = int(unforeseen[0])
                else:
                    renewing |= before & moved[0]
                    before, chunk = moved[0], 1
                    self._renewing = np.ones_like(renewing)
                continue
            self._check(found)
            self._keep(found._replace(tick=found.tick + (self.tick - self._first)), counts, told, entered)
            self._live, self.tick, chunk = live, until, most
            self._still.choose(found, live, len(made), self._most)
            self._wanted[:size] = lived & ~self._still.now  # others seldom live again
            chunk = min(most, 2 * len(made)) if self._still.now.any() else most
            self._renewing, self._chunk = renewing, 1 if renewing.any() else most
            sound = self.is_sound()
        return sound

    def _check(self, found: Found) -> None:
        """Raise `UndefinedSlopesError` if numbers that last have none."""
        undefined = np.unique(found.column[~np.isfinite(found.value)]).tolist()
        if undefined:
            places = [*self._places.values()]
            raise UndefinedSlopesError([places[i] for i in undefined if i < len(places)])

    def _make_room(self, more: int) -> None:
        """Take more events in a tick; raises `UndefinedSlopesError` if they are too many."""
        if self._most + more > MOST:
            raise UndefinedSlopesError([])
        self._most += more
        self._wanted, self._renewing = (
            np.append(each, np.zeros(more, dtype=bool)) for each in (self._wanted, self._renewing)
        )

    def _in_rows(self) -> tuple[Indices, Indices, StillRow]:
        """Return the directions that are wanted, in rows of lanes: what has no direction of its own is still.

        A lane has the number of the place or event of its direction, and -1 if it is idle. A row has
        what becomes of matrices. That of what is still comes before those that move matrices.
        """
        wanted, still = np.flatnonzero(self._wanted), int(self._still.now.any())
        parts = [wanted[~self._renewing[wanted]], wanted[self._renewing[wanted]]]
        rows = [-(-max(len(parts[0]), 1) // LANES), -(-len(parts[1]) // LANES)]
        matrices = np.array([AS_BEFORE] * rows[0] + [SEEDED] * still + [RENEWED] * rows[1])
        matrices[0] = AT_REST  # after the last row of the tick before
        lanes = np.full((len(matrices), LANES), -1)
        lanes[: rows[0]].reshape(-1)[: len(parts[0])] = parts[0]
        lanes[rows[0] + still :].reshape(-1)[: len(parts[1])] = parts[1]
        begins = self._still.begins(len(self._wanted) + 1)
        if still:
            self._seeds[[*self._places]] = begins[: len(self._places)]
        return lanes, matrices, StillRow(rows[0] if still else -1, begins)

    def _in_directions(self, until: int, lanes: Indices, matrices: Indices) -> tuple[AnyArray, Indices, AnyArray]:
        """Return what some ticks do in all directions that are wanted, and what their events tell.

        These are slopes, [tick, row, place or event, lane], with whether matrices move behind the
        events; the number of events of each tick; and what they tell. In a tick in which a
        direction moves matrices of groups, slopes hold if it is one that is expected to.
        """
        directions = aligned(lanes.shape, np.dtype(np.int64))
        directions[:] = np.array([*self._places, *(FIRST_EVENT - k for k in range(self._most)), NONE])[lanes]
        ticks, rows, width = until - self.tick, len(lanes), len(self._wanted) + 1
        made = self._reused.array("made", (ticks, rows, width, LANES))
        told = np.zeros((ticks, 1 + self._most * TOLD))
        given = directions.ctypes.data, matrices.ctypes.data, rows, self._most, made.ctypes.data, told.ctypes.data
        self._loop(self.tick, until, self.seed, self.run, *self._addresses, *given)
        return made, told[:, 0].astype(np.int64), told[:, 1:].reshape(ticks, self._most, TOLD)


class CompiledSlopes(SlopesInCode):
    """Ticks of loops that are cut at some wires, the events of a tick in which they have values.

    They tell of the loop through one of them at a time, in which the others are closed.
    """

    sources: Sequence[tuple[str, str, int]] = ()  # of noise, none as in `NoisyTicks` without
    quantised: Mapping[tuple[str, str, int], float] = MappingProxyType({})
    drops: Mapping[tuple[str, str, int], Drop] = MappingProxyType({})

    def __init__(
        self,
        code: SlopeCode,
        plan: Plan,
        memory: Memory,
        nodes: Sequence[Endpoint],
        seeded: AbstractSet[LastingPlace],
        moving: AbstractSet[str],
    ) -> None:
        super().__init__(code, plan, memory, dict.fromkeys(nodes, CUT), seeded, moving, most=len(nodes))
        self._nodes, self._node = tuple(nodes), 0
        self._among = np.full(len(code.wires), -1)  # places of wires among these
        self._among[[code.wires[node] for node in nodes]] = range(len(nodes))
        self._values: list[list[float]] = [[] for _ in nodes]
        self._kept: list[tuple[Found, AnyArray]] = []  # with which wires have a value in each tick

    @property
    def recorded(self) -> dict[Endpoint, list[float]]:
        """Values of the wire."""
        return {self._nodes[self._node]: self._values[self._node]}

    @property
    def injected(self) -> list[tuple[str, str, int]]:
        """Inputs at the wire, one for each of its values."""
        return [(*self._nodes[self._node], number) for number in range(len(self._values[self._node]))]

    def opened_at(self, node: Endpoint) -> "CompiledSlopes":
        """Return the same ticks with the loop open at one of the wires alone."""
        one = copy(self)
        one._node = self._nodes.index(node)
        return one

    def _keep(self, found: Found, counts: Indices, told: AnyArray, entered: AnyArray) -> None:
        size, valued = len(self._places), np.zeros((len(counts), len(self._nodes)), dtype=bool)
        wires = self._among[told[:, :, SOURCE].astype(np.int64)]  # of each event
        tick, event = np.nonzero(np.arange(self._most) < counts[:, None])
        valued[tick, wires[tick, event]] = True
        for number, values in enumerate(self._values):
            own = wires[tick, event] == number
            values += told[tick[own], event[own], VALUED].tolist()
        for of in (found.row, found.column) if len(self._nodes) > 1 else ():
            at = np.flatnonzero(of >= size)
            of[at] = size + wires[found.tick[at] - (self.tick - self._first), of[at] - size]
        self._kept.append((found, valued))

    def again(self, plan: Plan, memory: Memory, numbers: BegunNumbers | None = None) -> None:
        """Begin again as `CompiledLoop` does, in the directions that were wanted before."""
        super().again(plan, memory, numbers)
        self._first, self._live, self._kept = self.tick, self._seeded, []
        self._renewing[:] = False
        self._still = StillNumbers(len(self._places))
        for rows in self._in_lanes:
            rows.fill(0.0)
        self._values = [[] for _ in self._nodes]

    def slopes(self) -> TickSlopes:
        """Return the slopes of all ticks."""
        parts = zip(*((*found, valued) for found, valued in self._kept), strict=True)
        tick, row, column, value, valued = (np.concatenate(several) for several in parts)
        self._kept[:] = [(Found(tick, row, column, value), valued)]  # for the other wires too
        places, own = tuple(self._places.values()), valued[:, self._node]
        return TickSlopes(places, tick, row, column, value, own, len(self._nodes), self._node)
