"""The compiled engine: the generated loop, called chunk by chunk on arrays that hold everything that moves."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property
from itertools import groupby
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.host.arrays import AnyArray, Array
from proofmass.runner.plan.keys import (
    ConstantOf,
    Given,
    LargestOf,
    Moving,
    OverflowsOf,
    ParameterOf,
    StateField,
    VectorOf,
    WireOf,
)
from proofmass.runner.plan.memory import Memory, Rows, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.program.slots import FLOATS, INTEGERS, K, Slots, array_of, fields, numbers_of
from proofmass.runner.program.tick import write_tick
from proofmass.runner.program.tick_loop import TickLoop
from proofmass.runner.targets.machine_code import QUICK, LlvmModule, Settings, is_cached, load_module

_Place: TypeAlias = tuple[type, int]
BegunNumbers: TypeAlias = tuple[dict[str, AnyArray], dict[str, AnyArray], dict[VectorOf, AnyArray]]


class LoopLayout(NamedTuple):
    """Places of the states of blocks, of wires, and of counters of overflows."""

    states: list[tuple[str, Any, list[_Place]]]
    wires: list[tuple[Endpoint, _Place]]
    overflows: list[tuple[str, _Place | None]]

    @classmethod
    def of(cls, plan: Plan, written: TickLoop, counted: Iterable[str]) -> "LoopLayout":
        """Return the places in a loop of a plan, with the overflows of some blocks."""
        kinds, states = written.memory.kinds, list[tuple[str, Any, list[_Place]]]()
        for name, block in plan.blocks.items():
            made: Any = type(block).state_class()
            if made is not None:
                states.append((name, made, [kinds[StateField(name, field)] for field in made._fields]))
        wires = [((key.block, key.port), place) for key, place in kinds.items() if isinstance(key, WireOf)]
        return cls(states, wires, [(name, kinds.get(OverflowsOf(name))) for name in counted])

    def memory(
        self, plan: Plan, tick: int, state: Mapping[str, AnyArray], vectors: Mapping[VectorOf, AnyArray]
    ) -> Memory:
        """Return the memory of a run of a plan, from the numbers of its loop."""
        floats, integers = state[FLOATS].tolist(), state[INTEGERS].tolist()

        def number(place: _Place) -> Any:
            kind, index = place
            return floats[index] if kind is float else kind(integers[index])

        states: dict[str, Any] = dict.fromkeys(plan.blocks)
        states |= {name: made(*map(number, places)) for name, made, places in self.states}
        wires: dict[Endpoint, Any] = {node: number(place) for node, place in self.wires}
        shaped = ((node, array) for node, array in vectors.items() if not isinstance(node, LargestOf))
        wires |= {node: array.tolist() for node, array in shaped if node not in plan.buffers}
        buffers: dict[VectorOf, Sequence[float]] = {
            n: held if n in plan.recorded else vectors[n].tolist() for n, held in plan.buffers.items()
        }
        overflows = {name: number(place) if place else 0 for name, place in self.overflows}
        return Memory(tick, states, buffers, wires, overflows)


class CompiledPlan:
    """The loop of a plan, compiled once for all runs of it and of the plans that differ from it in numbers alone.

    A loop that is not given is compiled; `quick` is for short runs.
    """

    def __init__(
        self, plan: Plan, written: TickLoop | None = None, loop: Callable[..., Any] | None = None, quick: bool = False
    ) -> None:
        self.plan, self.written = plan, written or write_tick(plan)
        self.loop = loop or load_module(module_of(self.written, quick))
        self._recorded = dict[VectorOf, tuple[Sequence[float], AnyArray]]()
        self._held = dict[tuple[tuple[str, str, int], ...], list[tuple[Endpoint | None, list[int]]]]()

    def vector(self, memory: Memory, node: VectorOf, kind: type) -> AnyArray:
        """A vector that a run begins with; what runs only read is made once for all of them."""
        initial = memory.vector(node)
        if node not in self.plan.recorded:
            return np.array(initial, dtype=dtype_of(kind))
        known = self._recorded.get(node)
        if known is None or known[0] is not initial:
            known = self._recorded[node] = initial, np.array(initial, dtype=dtype_of(kind))
        return known[1]

    def held(self, entries: tuple[tuple[str, str, int], ...]) -> list[tuple[Endpoint | None, list[int]]]:
        """Return the buffers of numbers blocks hold, None for states, and their places there."""
        if entries not in self._held:
            kinds, several = self.written.memory.kinds, groupby(entries, lambda of: of[:2] if of[2] >= 0 else None)
            places = (
                (node, [kinds[StateField(*of[:2])][1] if node is None else of[2] for of in own])
                for node, own in several
            )
            self._held[entries] = list(places)
        return self._held[entries]

    def constant_values(self, plan: Plan) -> Mapping[Given, Any]:
        """The numbers of the loop for a plan with some blocks changed."""
        changed = (name for name, block in plan.blocks.items() if block is not self.plan.blocks[name])
        values = dict(self.written.constant_values)
        for name in changed:
            values |= block_values(plan, name)
        return values


class CompiledLoop:
    """A run of a plan as one compiled loop; bit for bit the reference engine."""

    name = "compiled"

    def __init__(
        self,
        plan: Plan,
        seed: int,
        run: int = 0,
        memory: Memory | None = None,
        compiled: CompiledPlan | None = None,
    ) -> None:
        self.plan, self.seed, self.run = plan, seed, run
        if compiled is None or not plan.same_sizes(compiled.plan):
            compiled = CompiledPlan(plan)
        self._compiled, self._loop = compiled, compiled.loop
        written = self._written = compiled.written
        memory = memory or start(plan)
        self.tick = memory.tick
        self._counted = [name for name in plan.digital if name in memory.overflows]
        self._constants, self._state, self._vectors = self.numbers_of(plan, memory)
        self._scratch = np.full(written.scratch + 1, np.nan)  # nothing was computed from it yet
        self._watched = finite_places(plan, written)
        self._refused = written.memory.counts[INTEGERS]  # place of `state_integers`

    def again(self, plan: Plan, memory: Memory, numbers: BegunNumbers | None = None) -> None:
        """Begin again, at the same addresses, a plan of other numbers and no recordings."""
        self.plan, self.tick = plan, memory.tick
        kept = (*self._constants.values(), *self._state.values(), *self._vectors.values())
        given = (array for arrays in numbers or self.numbers_of(plan, memory) for array in arrays.values())
        for array, held in zip(kept, given, strict=True):
            array[:] = held
        self._scratch[:] = np.nan

    def numbers_of(self, plan: Plan, memory: Memory) -> BegunNumbers:
        """Return the constants of a plan, and the numbers and the vectors a run begins with."""
        compiled, written = self._compiled, self._written
        vectors = zip(written.vectors, written.vector_kinds, strict=True)
        return (
            arrays_of(written.constants, compiled.constant_values(plan)),
            arrays_of(written.memory, {key: moving(memory, key) for key in written.memory.kinds}),
            {node: compiled.vector(memory, node, kind) for node, kind in vectors},
        )

    def advance(self, last: int, rows: Rows) -> bool:
        """Run up to, not including, the tick `last`; false when a number was not finite or did not fit its format."""
        of_rows = (array.ctypes.data for array in rows)
        self._loop(self.tick, last, self.seed, self.run, *self._own, *of_rows)
        self.tick = last
        return self.is_sound()

    def kinds(self) -> Iterable[tuple[Moving, type]]:
        """Return the single numbers that move, each with its type."""
        return ((key, kind) for key, (kind, _) in self._written.memory.kinds.items())

    def wires(self, nodes: Sequence[Endpoint], last: int) -> Array:
        """Run up to, not including, the tick `last`, and return what wires of one number hold: a row for each tick.

        They are those of the plan's probes, which record in each tick.
        """
        made: dict[Endpoint, AnyArray] = {p.node: np.zeros(last - self.tick, p.dtype) for p in self.plan.probes}
        self.advance(last, [*made.values()])
        return np.column_stack([made[node] for node in nodes]).astype(float)

    def numbers(self, keys: Sequence[Moving], last: int, every: int = 1) -> Array:
        """Run up to, not including, the tick `last`, and return some single numbers: a row for `every` tick."""
        places = [self._written.memory.kinds[key] for key in keys]
        floats = np.array([kind is float for kind, _ in places], dtype=bool)
        read = np.array([index for _, index in places], dtype=np.int64)
        of_kinds = [(self._state[kind], read[own], own) for kind, own in ((FLOATS, floats), (INTEGERS, ~floats))]
        rows = np.zeros((max(0, -(-(last - self.tick) // every)), len(places)))
        kept = [(array, at, own, np.zeros((len(rows), len(at)))) for array, at, own in of_kinds if len(at)]
        given = self.seed, self.run, *self._own
        for number in range(len(rows)):
            self._loop(self.tick, self.tick + every, *given)
            self.tick += every
            for array, at, _, numbers in kept:
                numbers[number] = array[at]
        for _, _, own, numbers in kept:
            rows[:, own] = numbers
        return rows

    def held(self, entries: tuple[tuple[str, str, int], ...]) -> Array:
        """Return reals that blocks hold: fields of states, numbered -1, and entries of buffers."""
        places, floats = self._compiled.held(entries), self._state[FLOATS]
        parts = [(floats if node is None else self._vectors[node])[own] for node, own in places]
        return np.concatenate(parts) if parts else np.zeros(0)

    def is_sound(self) -> bool:
        """Return whether every number is finite and fits its format now."""
        return self.sound(self._state[FLOATS], self._state[INTEGERS])

    def sound(self, numbers: AnyArray, integers: AnyArray) -> bool:
        """Return whether every number was finite and fitted its format, by the memory's arrays."""
        return bool(np.isfinite(numbers[self._watched]).all()) and not integers[self._refused]

    def arrays(self, rows: Rows) -> list[AnyArray]:
        """Everything that the program reads and writes, in the order of its parameters."""
        return [*self._constants.values(), *self._state.values(), self._scratch, *self._vectors.values(), *rows]

    def memory(self) -> Memory:
        """Return the memory of this moment."""
        return self.snapshot()()

    def snapshot(self) -> Callable[[], Memory]:
        """Return a function that gives this moment's memory; the `Memory` is made when called."""
        tick, recorded = self.tick, self.plan.recorded
        state = {name: array.copy() for name, array in self._state.items()}
        vectors = {node: array.copy() for node, array in self._vectors.items() if node not in recorded}
        return lambda: self._layout.memory(self.plan, tick, state, vectors)

    @cached_property
    def _own(self) -> list[int]:
        """Return the addresses of its arrays, which stay."""
        return [array.ctypes.data for array in self.arrays(())]

    @cached_property
    def _layout(self) -> LoopLayout:
        return LoopLayout.of(self.plan, self._written, self._counted)


def settings(written: TickLoop) -> Settings:
    """Return the settings by which LLVM compiles a loop of one run.

    Only with vectors among the wires are numbers gathered into short vectors: it makes correlation
    cells fast, and the chain of operations round a loop of scalars slow.
    """
    return Settings(rows=bool(written.vectors))


def block_values(plan: Plan, name: str) -> dict[Given, Any]:
    """The numbers of the loop that a block brings: its constants, or the parameters that they follow from."""
    made, block = plan.constants[name], plan.blocks[name]
    if not plan.is_driven(name):
        return numbers_of(made, lambda field: ConstantOf(name, field))
    kind, drivers = type(block).parameters_class(), plan.schedule.drivers
    given = numbers_of(kind(*(getattr(block, p) for p, _ in fields(kind))), lambda p: ParameterOf(name, p))
    driven = {ParameterOf(name, p) for p, _ in fields(kind) if (name, p) in drivers}
    return {key: value for key, value in given.items() if key not in driven}


def module_of(written: TickLoop, quick: bool = False) -> LlvmModule:
    """Return the loop of one run as LLVM is given it; a `quick` one is not optimised, unless it has been before."""
    module = LlvmModule.of(written.program, settings(written))
    return in_little_time(module) if quick else module


def in_little_time(module: LlvmModule) -> LlvmModule:
    """Return a module as it is compiled if it does not run for long: as it is, if that has been done before."""
    return module if is_cached(module.key) else module.compiled_by(QUICK)


def already_compiled(plan: Plan, quick: bool) -> bool:
    """Return whether the loop of a plan is in the cache."""
    return is_cached(module_of(write_tick(plan), quick).key)


def arrays_of(slots: Slots[K], values: Mapping[K, Any], *lanes: int) -> dict[str, AnyArray]:
    """An array of floats and one of integers, each with a place to spare at its end; of rows if there are `lanes`."""
    arrays: dict[str, AnyArray] = {
        FLOATS: np.zeros((slots.counts[FLOATS] + 1, *lanes)),
        INTEGERS: np.zeros((slots.counts[INTEGERS] + 1, *lanes), dtype=np.int64),
    }
    for key, (kind, index) in slots.kinds.items():
        arrays[array_of(kind)][index] = values[key]
    return arrays


def finite_places(plan: Plan, written: TickLoop) -> list[int]:
    """Return the places of floats that must stay finite: integrals, and the check of the wires."""
    kinds = written.memory.kinds
    states = [kinds[StateField(*state)] for solver in plan.solvers for state in solver.group.states]
    return [*(place for kind, place in states if kind is float), written.memory.counts[FLOATS]]


def moving(memory: Memory, key: Moving) -> Any:
    """Return a state's field, a wire or the overflow count of a block in the memory."""
    match key:
        case OverflowsOf(block):
            return memory.overflows.get(block, 0)
        case StateField(block, field):
            return getattr(memory.states[block], field)
        case WireOf(block, port):
            return memory.wires[block, port]


def dtype_of(kind: type) -> Any:
    return np.float64 if kind is float else np.int64
