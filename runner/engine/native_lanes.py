"""The compiled loop of several runs side by side, on arrays that hold everything that moves in each."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from proofmass.graphs.schedule import Node
from proofmass.runner.engine.compile import load
from proofmass.runner.engine.lanes import generate_lanes, settled_before
from proofmass.runner.engine.memory import Memory, start
from proofmass.runner.engine.native import Array, argument_kinds, block_values, dtype_of, moving
from proofmass.runner.engine.pieces import FLOATS, INTEGERS, Slots
from proofmass.runner.engine.planned import Plan

_RUN_ARGUMENT = 3  # of the loop: first, last, seed, run


class CompiledLanes:
    """The loop of a plan for several runs, compiled once; they differ in noise and in the varied parameters."""

    def __init__(self, plan: Plan, varied: Collection[Node], lanes: int) -> None:
        self.plan, self.lanes = plan, lanes
        self.settled = settled_before(plan, varied)  # blocks of which a run brings constants, start and buffers
        made = self.generated = generate_lanes(plan, varied, lanes)
        kinds = list(argument_kinds(made, plan))
        kinds[_RUN_ARGUMENT] = "int*"
        self.loop = load(made, tuple(kinds))
        memory = start(plan)
        self.constants = _rows(made.constants, made.constant_values, lanes)
        self.state = _rows(made.memory, {key: moving(memory, key) for key in made.memory.kinds}, lanes)
        named = zip(made.vectors, made.vector_kinds, strict=True)
        self.vectors = {node: self._vector(memory, node, kind) for node, kind in named}
        integrated = [made.memory.kinds[name, "x", f] for solver in plan.solvers for name, f in solver.group.states]
        self.watched = [place for kind, place in integrated if kind is float] + [made.memory.counts[FLOATS]]

    def _vector(self, memory: Memory, node: Node, kind: type) -> Array:
        held = np.array(memory.buffers.get(node, memory.wires.get(node)), dtype=dtype_of(kind))
        return held if node in self.plan.recorded else np.tile(held, (self.lanes, 1))


class Lanes:
    """Some runs of a plan, at most as many as there are lanes; each to the bit what it would be alone.

    `values` has a number for each run of the varied parameters; of blocks that are settled before a run starts, it is
    `plans` that have them.
    """

    def __init__(
        self,
        compiled: CompiledLanes,
        seed: int,
        runs: Sequence[int],
        values: Mapping[Node, Array],
        plans: Sequence[Plan],
    ) -> None:
        self._compiled, self._seed, self.tick = compiled, seed, 0
        self._runs = np.full(compiled.lanes, runs[0], dtype=np.int64)
        self._runs[: len(runs)] = runs
        self._constants = {kind: rows.copy() for kind, rows in compiled.constants.items()}
        self._state = {kind: rows.copy() for kind, rows in compiled.state.items()}
        recorded = compiled.plan.recorded
        self._vectors = {n: rows if n in recorded else rows.copy() for n, rows in compiled.vectors.items()}
        self._scratch = np.empty(compiled.generated.scratch * compiled.lanes + 1)
        self._set(values)
        for lane, plan in enumerate(plans):
            if compiled.settled:
                self._settle(lane, plan)

    def _set(self, values: Mapping[Node, Array]) -> None:
        """The varied parameters; lanes without a run do as the first."""
        places = self._compiled.generated.constants.kinds
        for node, given in values.items():
            key = (node[0], "parameter", node[1])
            if node[0] not in self._compiled.settled:
                row = self._constants[FLOATS][places[key if key in places else node][1]]
                row[:] = given[0]
                row[: len(given)] = given

    def _settle(self, lane: int, plan: Plan) -> None:
        """Constants, start and buffers of the blocks that are settled before a run."""
        memory, made = start(plan), self._compiled.generated
        for name in self._compiled.settled:
            for key, value in block_values(plan, name).items():
                kind, place = made.constants.kinds[key]
                self._constants[FLOATS if kind is float else INTEGERS][place, lane] = value
            for key, (kind, place) in made.memory.kinds.items():
                if key[0] == name:
                    self._state[FLOATS if kind is float else INTEGERS][place, lane] = moving(memory, key)
            for node, rows in self._vectors.items():
                if node[0] == name and node not in plan.recorded:
                    rows[lane] = memory.buffers.get(node, memory.wires.get(node))

    def advance(self, last: int) -> None:
        """Run all of them up to, not including, the tick `last`."""
        self._scratch.fill(np.nan)  # what nothing has been computed from yet
        arrays = [self._runs, *self._constants.values(), *self._state.values(), self._scratch, *self._vectors.values()]
        self._compiled.loop(self.tick, last, self._seed, *(array.ctypes.data for array in arrays))
        self.tick = last

    def sound(self) -> list[bool]:
        """Of each lane, whether its numbers were finite and fitted their formats, so far."""
        refused = self._state[INTEGERS][self._compiled.generated.memory.counts[INTEGERS]]
        finite = np.isfinite(self._state[FLOATS][self._compiled.watched]).all(axis=0)
        return (finite & (refused == 0)).tolist()  # type: ignore[no-any-return]

    def memories(self, names: Collection[str]) -> Iterator[Memory]:
        """States and wires of some blocks, as they stand, lane by lane."""
        plan, kinds = self._compiled.plan, self._compiled.generated.memory.kinds
        columns: dict[Any, list[Any]] = {}
        for key, (kind, place) in kinds.items():
            if key[0] in names:
                row = self._state[FLOATS if kind is float else INTEGERS][place].tolist()
                columns[key] = row if kind is not bool else [value != 0 for value in row]
        made: dict[str, Any] = {name: plan.blocks[name].state_class() for name in names}
        fields = {name: [columns[name, "x", f] for f in kind._fields] for name, kind in made.items() if kind}
        wires = {key: column for key, column in columns.items() if len(key) == 2}
        for lane in range(self._compiled.lanes):
            states = dict.fromkeys(names) | {
                name: made[name](*(column[lane] for column in own)) for name, own in fields.items()
            }
            yield Memory(self.tick, states, {}, {key: column[lane] for key, column in wires.items()}, {})


def _rows(slots: Slots, values: Mapping[Any, Any], lanes: int) -> dict[str, Array]:
    """An array of floats and one of integers, with a row of lanes for each number and one to spare."""
    rows: dict[str, Array] = {
        FLOATS: np.zeros((slots.counts[FLOATS] + 1, lanes)),
        INTEGERS: np.zeros((slots.counts[INTEGERS] + 1, lanes), dtype=np.int64),
    }
    for key, (kind, index) in slots.kinds.items():
        rows[FLOATS if kind is float else INTEGERS][index] = values[key]
    return rows
