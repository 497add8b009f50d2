"""The compiled loop of several runs side by side, on arrays of all that moves in each."""

import math
import threading
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.host.arrays import AnyArray
from proofmass.runner.host.interrupts import StoppedError
from proofmass.runner.plan.keys import ConstantOf, LargestOf, Moving, ParameterOf, StateField, VectorOf
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.form import Storage as ProgramArray
from proofmass.runner.program.form import Value
from proofmass.runner.program.slots import FLOATS, INTEGERS, array_of
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.tick_loop import TickLoop, settled_before
from proofmass.runner.program.varying import ALL
from proofmass.runner.targets.lane_text import LanesOf
from proofmass.runner.targets.machine_code import Settings, load_lanes
from proofmass.runner.targets.native import LoopLayout, arrays_of, block_values, dtype_of, finite_places, moving

CHUNK = 1 << 20  # ticks of all lanes between looks at an interruption
_WIDE = Settings(wide=True)  # vectors as wide as the processor has them
_LINE = 64  # bytes of a cache line, and of the widest vector
_RUN = 3  # the place of the run's number among the arguments: first, last, seed, run


class CompiledLanes:
    """The loop of a plan for several runs, compiled once; they differ in noise and in the varied parameters."""

    def __init__(self, plan: Plan, varied: Collection[Endpoint], lanes: int) -> None:
        self.plan, self.lanes = plan, lanes
        self.settled = settled_before(plan, varied)  # blocks of which a run brings constants, start and buffers
        written = self.written = write_tick(plan, varied, lanes=True)
        self.loop = load_lanes(written.program, lanes, _differing(plan, written, varied, self.settled), _WIDE)
        memory = start(plan)
        self.constants = arrays_of(written.constants, written.constant_values, lanes)
        self.state = arrays_of(written.memory, {key: moving(memory, key) for key in written.memory.kinds}, lanes)
        named = zip(written.vectors, written.vector_kinds, strict=True)
        self.vectors = {node: self._vector(memory, node, kind) for node, kind in named}
        self.watched = finite_places(plan, written)
        self.layout = LoopLayout.of(plan, written, [name for name in plan.digital if name in memory.overflows])

    @property
    def size(self) -> int:
        """Bytes that a group of runs takes."""
        own = [rows for node, rows in self.vectors.items() if node not in self.plan.recorded]
        return sum(rows.nbytes for rows in (*self.constants.values(), *self.state.values(), *own))

    def _vector(self, memory: Memory, node: VectorOf, kind: type) -> AnyArray:
        held = np.array(memory.vector(node), dtype=dtype_of(kind))
        return held if node in self.plan.recorded else np.repeat(held[:, None], self.lanes, axis=1)


class Lanes:
    """Runs of a plan in groups of as many as there are lanes; each run to the bit what it would be alone.

    `values` has a number for each run of the varied parameters; of blocks that are settled before a
    run starts, it is `plans` that have them, one for each run.
    """

    def __init__(
        self,
        compiled: CompiledLanes,
        seed: int,
        runs: Sequence[int] | AnyArray,
        values: Mapping[Endpoint, AnyArray],
        plans: Sequence[Plan] = (),
    ) -> None:
        self._compiled, self._seed, self.tick = compiled, seed, 0
        self._count, self._groups = len(runs), -(-len(runs) // compiled.lanes)
        self._runs = self._padded(np.asarray(runs, dtype=np.int64))
        self._constants = self._copied(compiled.constants)
        self._state = self._copied(compiled.state)
        recorded = compiled.plan.recorded
        own = self._copied({node: rows for node, rows in compiled.vectors.items() if node not in recorded})
        self._vectors = {node: own.get(node, rows) for node, rows in compiled.vectors.items()}
        self._scratch = aligned((compiled.written.scratch * compiled.lanes + 1,), np.dtype(float))
        self._set(values)
        if compiled.settled:
            for number, plan in enumerate(plans):
                self._settle(*divmod(number, compiled.lanes), plan)

    def _copied(self, rows: Mapping[Any, AnyArray]) -> dict[Any, AnyArray]:
        """Return a copy of the rows for every group."""
        copies: dict[Any, AnyArray] = {}
        for key, of_one in rows.items():
            copies[key] = aligned((self._groups, *of_one.shape), of_one.dtype)
            copies[key][:] = of_one
        return copies

    def _padded(self, numbers: AnyArray) -> AnyArray:
        """A number for every lane of every group; lanes without a run do as the first one."""
        padded = aligned((self._groups, self._compiled.lanes), numbers.dtype)
        padded[:] = numbers[0]
        padded.reshape(-1)[: self._count] = numbers
        return padded

    def _set(self, values: Mapping[Endpoint, AnyArray]) -> None:
        """The varied parameters."""
        places = self._compiled.written.constants.kinds
        for node, given in values.items():
            if node[0] not in self._compiled.settled:
                place = places.get(ParameterOf(*node)) or places[ConstantOf(*node)]
                self._constants[FLOATS][:, place[1]] = self._padded(given)

    def _settle(self, group: int, lane: int, plan: Plan) -> None:
        """Constants, start and buffers of the blocks that are settled before a run."""
        memory, written = start(plan), self._compiled.written
        for name in self._compiled.settled:
            for given, value in block_values(plan, name).items():
                if given in written.constants.kinds:  # truth values are a part of the loop
                    kind, place = written.constants.kinds[given]
                    self._constants[array_of(kind)][group, place, lane] = value
            for key, (kind, place) in written.memory.kinds.items():
                if key.block == name:
                    self._state[array_of(kind)][group, place, lane] = moving(memory, key)
            for node, rows in self._vectors.items():
                of_block = not isinstance(node, LargestOf) and node[0] == name
                if of_block and node not in plan.recorded:
                    rows[group, :, lane] = memory.vector(node)

    def advance(self, last: int, stop: threading.Event | None = None) -> None:
        """Run all of them up to, not including, the tick `last`, group after group.

        Raises `StoppedError` soon after the event is set.
        """
        own = [self._runs, *self._constants.values(), *self._state.values()]
        recorded = self._compiled.plan.recorded
        places = [(rows.ctypes.data, rows.strides[0]) for rows in own] + [(self._scratch.ctypes.data, 0)]
        for node, rows in self._vectors.items():
            places.append((rows.ctypes.data, 0 if node in recorded else rows.strides[0]))
        step = CHUNK // self._compiled.lanes
        for group in range(self._groups):
            pointers = [begin + group * length for begin, length in places]
            for first in range(self.tick, last, step):
                if stop is not None and stop.is_set():
                    raise StoppedError
                self._scratch.fill(np.nan)  # no number has been computed from it yet
                self._compiled.loop(first, min(first + step, last), self._seed, *pointers)
        self.tick = last

    def sound(self) -> AnyArray:
        """Return for each run whether its numbers were finite and fitted their formats so far."""
        refused = self._state[INTEGERS][:, self._compiled.written.memory.counts[INTEGERS]]
        finite = np.isfinite(self._state[FLOATS][:, self._compiled.watched]).all(axis=1)
        return self._of_runs(finite & (refused == 0))

    def value(self, key: Moving) -> AnyArray:
        """Return for each run a wire that a measure reads, or a field of a state."""
        kind, place = self._compiled.written.memory.kinds[key]
        return self._of_runs(self._state[array_of(kind)][:, place])

    def held(self, entries: Sequence[tuple[str, str, int]]) -> AnyArray:
        """Return reals that blocks hold, a row for each run: fields of states, numbered -1, and entries of buffers."""
        columns = [
            self.value(StateField(*of[:2])) if of[2] < 0 else self._of_runs(self._vectors[of[:2]][:, of[2]])
            for of in entries
        ]
        return np.array(columns).reshape(len(entries), self._count).T

    def memory(self, run: int, plan: Plan) -> Memory:
        """Return the memory of one of the runs, of a plan whose numbers it has."""
        group, lane = divmod(run, self._compiled.lanes)
        state = {kind: rows[group, :, lane] for kind, rows in self._state.items()}
        own = ((node, rows) for node, rows in self._vectors.items() if node not in self._compiled.plan.recorded)
        vectors = {node: rows[group, :, lane] for node, rows in own}
        return self._compiled.layout.memory(plan, self.tick, state, vectors)

    def scalars(self) -> Iterable[Moving]:
        """Return the wires, fields of states and counts that runs have in lanes."""
        return self._compiled.written.memory.kinds.keys()

    def vectors(self) -> Iterator[tuple[VectorOf, AnyArray]]:
        """Yield each buffer and each wire with a shape: a row for each run."""
        for node, rows in self._vectors.items():
            if node not in self._compiled.plan.recorded:
                yield node, np.moveaxis(rows, 1, 2).reshape(-1, rows.shape[1])[: self._count]

    def _of_runs(self, rows: AnyArray) -> AnyArray:
        return rows.reshape(-1)[: self._count]


def _differing(plan: Plan, written: TickLoop, varied: Collection[Endpoint], settled: Collection[str]) -> LanesOf:
    """Return what differs from run to run when the first tick begins.

    That is noise, varied parameters, and what follows from them in blocks that are settled before.
    """
    entry = written.program.entry.parameters
    arrays = [parameter for parameter in entry if isinstance(parameter, ProgramArray)]
    constants, moving_, vectors = arrays[:2], arrays[2:4], dict(zip(written.vectors, arrays[5:], strict=True))
    entries = dict.fromkeys(arrays, 0)
    for key, (kind, place) in written.constants.kinds.items():
        if isinstance(key, ConstantOf | ParameterOf):
            name = key.field if isinstance(key, ConstantOf) else key.parameter
            if key.block in settled or (key.block, name) in varied:
                entries[constants[kind is not float]] |= 1 << place
    for moves, (kind, place) in written.memory.kinds.items():
        if moves.block in settled:
            entries[moving_[kind is not float]] |= 1 << place
    for node, array in vectors.items():
        if not isinstance(node, LargestOf) and node[0] in settled:
            entries[array] = ALL
    shared = frozenset(vectors[node] for node in vectors if node in plan.recorded)
    run = entry[_RUN]
    assert isinstance(run, Value)
    return LanesOf(frozenset({run}), shared, {a: bits for a, bits in entries.items() if a not in shared})


def aligned(shape: tuple[int, ...], dtype: Any) -> AnyArray:
    """An empty array that begins with a cache line, so that no vector lies in two of them."""
    size = math.prod(shape) * dtype.itemsize
    room = np.empty(size + _LINE, dtype=np.uint8)
    first = -room.ctypes.data % _LINE
    line: AnyArray = room[first : first + size].view(dtype)
    return line.reshape(shape)
