"""Runs to an operating point: in plain Python at first, in machine code once that takes long."""

import threading
import time
from collections.abc import Callable, Hashable, Sequence
from collections.abc import Set as AbstractSet
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.runner.analysis.linearisation.rings import Entry, Rings
from proofmass.runner.fixed.step_formats import held_as
from proofmass.runner.host.arrays import Array
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.keys import StateField
from proofmass.runner.plan.memory import Engine, Memory, start
from proofmass.runner.plan.planned import Plan, PlannedProbe
from proofmass.runner.reference.interpret import TickError
from proofmass.runner.reference.part import PartInterpreter
from proofmass.runner.run.engines import choose, make_engine
from proofmass.runner.run.estimates import is_short
from proofmass.runner.run.faults import failed, name_fault

if TYPE_CHECKING:
    from proofmass.runner.analysis.linearisation.period_map import PeriodMap
    from proofmass.runner.program.tick_loop import TickLoop
    from proofmass.runner.targets.machine_code import LlvmModule
    from proofmass.runner.targets.native import CompiledLoop, CompiledPlan
    from proofmass.runner.targets.native_slopes import CompiledSlopes, SlopeCode


INTERPRETED = 1.5  # seconds of plain Python, after which the loop is compiled
_RUNS = 20  # as long as one, of an analysis, about
_CHUNK = 0.05  # seconds from one report of progress to the next
_AWAY, _FROM_ZERO = 1.001, 1e-6  # factor and offset of held signals that nothing moves
_FEW = 64  # ticks that plain Python follows in dual numbers
_LONG = 2_048  # ticks of a period, from which compiling slowly pays


class Forward:
    """A run that can be continued. Plain Python and machine code give the same bits."""

    progress: Progress | None = None

    def __init__(self, plan: Plan, memory: Memory | None = None, code: "MachineCode | None" = None) -> None:
        self._plan = replace(plan, probes=())
        self._code = code or MachineCode(self._plan)
        begin = memory or start(plan)
        self._engine: Engine = (
            self._code.run(self._plan, begin, 0)
            if self._code.known
            else make_engine(self._plan, "python", self._plan.graph.seed, 0, begin, begin.tick)
        )
        self.tick, self._spent, self._chunk = begin.tick, 0.0, 16
        self._asked = 0  # ticks for which an engine was chosen

    def to(self, last: int, of: int = 0) -> Memory:
        """Run to the start of the tick `last` and return the memory there; raises `ModelError` if a tick fails."""
        return self.reach(last, of).memory().copy()

    def reach(self, last: int, of: int = 0) -> Engine:
        """Run to the start of the tick `last` and return the engine there; raises `ModelError` if a tick fails."""
        if last - self.tick > self._asked:
            self._asked = last - self.tick  # asking costs as much as some ticks, too much for each of many short parts
            if self._code.pays(self._asked) if self._engine.name == "python" else self._code.is_outgrown(self._asked):
                self.compile(self._asked)
        while self.tick < last:
            if self.progress:
                self.progress(self.tick, max(of, last))
            first, following, before = self.tick, min(self.tick + self._chunk, last), self._engine.snapshot()
            began = time.perf_counter()
            try:
                if not self._engine.advance(following, ()):
                    name_fault(self._plan, self._plan.graph.seed, 0, before(), following)
            except TickError as error:
                self.tick = last + 1  # no run goes on from here
                raise failed(self._plan, error).error from error
            seconds = time.perf_counter() - began
            self.tick = following
            if seconds < _CHUNK / 2:
                self._chunk *= 2
            elif seconds > 2 * _CHUNK:
                self._chunk = max(self._chunk // 2, 1)
            self._spent += seconds
            left = seconds / (self.tick - first) * (max(of, last) - self.tick)
            if self._engine.name == "python" and self._spent > INTERPRETED < left:
                self.compile(max(of, last) - self.tick)
        return self._engine

    def compile(self, ticks: int) -> None:
        """Go on for some ticks in machine code, if the plan can."""
        if choose(self._plan, LARGEST_RUN, "auto") == "compiled":  # not with values beyond 64 bits
            self._engine = self._code.run(self._plan, self._engine.memory(), ticks)


class MachineCode:
    """Machine code of a plan and of all that differ from it in numbers alone, made when it is first wanted."""

    def __init__(self, plan: Plan) -> None:
        self._plan = plan
        self.known: CompiledPlan | None = None
        self._quick = False  # it is not optimised

    @cached_property
    def _text(self) -> "tuple[TickLoop, LlvmModule]":
        # start-up time: short runs need no compiler
        from proofmass.runner.program.tick import write_tick
        from proofmass.runner.targets.native import module_of

        written = write_tick(self._plan)
        return written, module_of(written)

    def is_outgrown(self, ticks: int) -> bool:
        """Return whether the code was made for less than some ticks."""
        return self._quick and not is_short(self._plan, _RUNS * ticks)

    def _module(self, ticks: int) -> "LlvmModule":
        """Return what is compiled for runs of so many ticks."""
        # start-up time: short runs need no compiler
        from proofmass.runner.targets.native import in_little_time

        _, module = self._text
        return in_little_time(module) if is_short(self._plan, _RUNS * ticks) else module

    def pays(self, ticks: int) -> bool:
        """Return whether some ticks are to be run in machine code: it is there, or plain Python would take longer."""
        cached = partial(self._is_cached, ticks)
        return self.known is not None or choose(self._plan, ticks, "auto", cached) == "compiled"

    def _is_cached(self, ticks: int) -> bool:
        # start-up time: short runs need no compiler
        from proofmass.runner.targets.machine_code import is_cached

        return is_cached(self._module(ticks).key)

    def run(self, plan: Plan, memory: Memory, ticks: int) -> "CompiledLoop":
        """Return a run from a memory on, of some ticks."""
        # start-up time: short runs need no compiler
        from proofmass.runner.targets.machine_code import QUICK, load_module
        from proofmass.runner.targets.native import CompiledLoop, CompiledPlan

        if self.known is None or self.is_outgrown(ticks):
            module = self._module(ticks)
            self.known = CompiledPlan(self._plan, self._text[0], load_module(module))
            self._quick = module.settings == QUICK
        return CompiledLoop(plan, plan.graph.seed, 0, memory, self.known)


class Course:
    """The run of a plan from tick 0, without noise: how far it has got, and its machine code.

    An analysis owns one. Runs that go on from elsewhere borrow its machine code, and so does a
    course `like` another whose plan differs in numbers alone.
    """

    def __init__(
        self, plan: Plan, like: "Course | None" = None, many: bool = False, begin: Memory | None = None
    ) -> None:
        """Take a plan, a course that it may share machine code with, and whether `many` courses will be like it.

        It begins at tick 0 as the plan does, or with another memory.
        """
        self.plan = plan.without_noise
        self._begin = begin
        self.kept: dict[Hashable, Any] = {}  # runs with noise, asked for at several points
        self.loops: tuple[Endpoint, ...] = ()  # wires at which an analysis opens loops one after the other
        self._run: Forward | None = None
        self._onward = dict[int, Onward]()
        self._slopes: dict[bool, list[SlopeCode]] = {False: [], True: []}  # without and with noise
        self._has_slopes: bool | None = None
        self._parts = dict[Hashable, MachineCode]()
        self._noisy, self._asked, self._noisy_code = plan, 0, MachineCode(replace(plan, probes=()))
        self._few = 0 if many else _FEW
        self.like = like if like is not None and self.plan.same_sizes(like.plan) else None
        self._code: MachineCode = (
            self.like._code if self.like is not None else MachineCode(replace(self.plan, probes=()))
        )

    def slopes(
        self, ticks: int = LARGEST_RUN, noise: bool = False, blocks: AbstractSet[str] = frozenset()
    ) -> "SlopeCode | None":
        """Return the machine code of ticks with their slopes, and those by all of `noise`, if the plan has such.

        There is none for a few `ticks` of one course, and with noise for a few in all: plain Python
        takes less time. It is that of some `blocks` and of what they depend on, where these are the
        lesser part of the plan.
        """
        if self.like is not None:
            return self.like.slopes(ticks, noise, blocks)
        self._asked += ticks if noise else 0
        if (self._asked if noise else ticks) < self._few:
            return None
        # start-up time: short periods need no compiler
        from proofmass.runner.targets.native_slopes import SlopeCode, has_slopes

        if self._has_slopes is None:
            self._has_slopes = has_slopes(self.plan) and choose(self.plan, LARGEST_RUN, "auto") == "compiled"
        if not self._has_slopes:
            return None
        own, made = self._noisy if noise else self.plan, self._slopes[noise]
        part = own.part(blocks) if blocks else own
        code = next((code for code in made if code.blocks.keys() >= part.blocks.keys()), None)
        if code is None:
            every = sum(len(code.blocks) for code in made) + len(part.blocks)  # parts of parts are made in vain
            lesser = 2 * len(part.blocks) <= len(own.blocks) and 2 * every <= 3 * len(own.blocks)
            code = SlopeCode(part if lesser else own, noise, ticks >= _LONG)
            made.append(code)
        return code

    def at(self, tick: int) -> Memory:
        """Return the memory at the start of a tick; raises `ModelError` if the run fails."""
        if tick:
            return self._reach(tick).memory().copy()
        return start(self.plan) if self._begin is None else self._begin.copy()

    def numbers(self, entries: tuple[Entry, ...], tick: int, progress: Progress | None = None, of: int = 0) -> Array:
        """Return real numbers that blocks hold at the start of a tick; raises `ModelError` if the run fails."""
        engine: Any = self._reach(tick, progress, of)
        if engine.name == "compiled":
            return np.asarray(engine.held(entries))
        held = dict(Rings().states_of(engine.memory(), [*dict.fromkeys(name for name, _, _ in entries)]))
        return np.array([held[entry] for entry in entries], dtype=float)

    def _reach(self, tick: int, progress: Progress | None = None, of: int = 0) -> Engine:
        if self._run is None or self._run.tick > tick:
            self._run = self.from_memory(self._begin)
        self._run.progress = progress
        return self._run.reach(tick, of)

    def onward(self, tick: int) -> "Onward":
        """Return the run on from a tick's start, shared by maps about it; raises `ModelError`."""
        if tick not in self._onward:
            self._onward[tick] = Onward(self, self.at(tick))
        return self._onward[tick]

    def machine_code(self, memory: Memory, ticks: int) -> "CompiledLoop | None":
        """Return a run in machine code from a memory on, if there is such code, or some ticks are worth making it."""
        if not self._code.pays(ticks):
            return None
        return self._code.run(replace(self.plan, probes=()), memory.copy(), ticks)

    def part_in_code(
        self, memory: Memory, ticks: int, blocks: AbstractSet[str], nodes: Sequence[Endpoint]
    ) -> "CompiledLoop | None":
        """Return such a run of some blocks alone, which depend on no others, that records what wires hold."""
        dtypes = [type(self.plan.blocks[name]).outputs[port].dtype for name, port in nodes]
        probes = [
            PlannedProbe(f"{n}.{p}", (n, p), 1, held_as(t), (), "", "") for (n, p), t in zip(nodes, dtypes, strict=True)
        ]
        part = replace(self.plan.part(blocks), probes=tuple(probes))
        code = (self.like or self)._parts.setdefault((frozenset(blocks), *nodes), MachineCode(part))
        return code.run(part, memory.copy(), ticks) if code.pays(ticks) else None

    def from_memory(self, memory: Memory | None) -> Forward:
        """Return a run from a memory on, or from tick 0."""
        return Forward(self.plan, memory and memory.copy(), self._code)

    def with_noise(self, memory: Memory) -> Forward:
        """Return a run with noise from a memory on."""
        return Forward(self._noisy, memory, self._noisy_code)


class Onward:
    """The run from an operating point on, shared by maps about it: memories, held wires."""

    def __init__(self, course: Course, begin: Memory) -> None:
        self.course, self.begin = course, begin
        self.maps: dict[Hashable, PeriodMap | None] = {}  # to several outputs, each a part
        self.slopes: dict[Hashable, tuple[CompiledSlopes | None, set[Endpoint]]] = {}  # of loops yet to be asked for
        self._run = course.from_memory(begin)
        self._memories = {begin.tick: begin}
        self._recorded: dict[Hashable, tuple[CompiledLoop | Alone, Array]] = {}
        self._recording = threading.Lock()  # sensors of a study that are alike ask in threads
        self._integers = dict[Hashable, list[list[int]]]()

    def at(self, tick: int) -> Memory:
        """Return the memory at the start of a tick; raises `ModelError` if the run fails."""
        if tick not in self._memories:
            if self._run.tick > tick:
                self._run = self.course.from_memory(self._memories[max(t for t in self._memories if t < tick)])
            self._memories[tick] = self._run.to(tick)
        return self._memories[tick]

    def wires(
        self,
        nodes: Sequence[Endpoint],
        ticks: int,
        alone: AbstractSet[str],
        timed: AbstractSet[str],
        entries: Sequence[Endpoint],
    ) -> Array:
        """Return what wires of one number hold, a row for each of some ticks.

        They are those of blocks that run `alone`, and of `timed` ones, whose signals are away from
        where they are, held or at the `entries` of small signals: nothing would show that a gate
        opens on a signal that is zero. From tick 0 on they are found once for all courses that are
        alike, where these blocks are the same.
        """
        like, blocks, running = self.course.like, self.course.plan.blocks, alone | timed
        if like is not None and not self.begin.tick and all(blocks[n] is like.plan.blocks[n] for n in running):
            return like.onward(0).wires(nodes, ticks, alone, timed, entries)
        with self._recording:
            none = np.zeros((0, len(nodes)))
            key = (*nodes, *(sorted(timed) and (*sorted(timed), *entries)))
            run, rows = self._recorded.get(key, (None, none))
            if len(rows) < ticks:
                asked = not timed and (run is None or isinstance(run, Alone))
                code = self.course.part_in_code(self.begin, ticks, alone, nodes) if asked else None
                run, rows = (
                    (code, none)
                    if code
                    else (run or Alone(self.course.plan, self.begin.copy(), running, entries), rows)
                )
                rows = np.concatenate([rows, run.wires(nodes, self.begin.tick + ticks)])
                self._recorded[key] = run, rows
            return rows[:ticks]

    def integers(self, names: Sequence[str], rings: Rings, ticks: int, periods: int) -> list[list[int]]:
        """Return the integers and truth values of blocks after 0, 1, 2 and so on periods of so many ticks each."""
        key = (*names, *sorted(rings.places())), ticks
        rows = self._integers.setdefault(key, [rings.integers_of(self.begin, names)])
        missing = periods - len(rows)
        if missing > 0 and rows[0]:
            memory = self.at(self.begin.tick + (len(rows) - 1) * ticks)
            run, last = self.course.from_memory(memory), memory.tick + missing * ticks
            ends = range(memory.tick + ticks, last + 1, ticks)
            rows += self._in_code(names, rings, ticks, missing, memory) or [
                rings.integers_of(run.to(end, last), names) for end in ends
            ]
        return (rows if rows[0] else rows * periods)[:periods]

    def _in_code(self, names: Sequence[str], rings: Rings, ticks: int, periods: int, memory: Memory) -> list[list[int]]:
        """Return the integers after some more periods by machine code, none without."""
        code = self.course.machine_code(memory, periods * ticks)
        held = (cells for (name, _), cells in memory.of_blocks().items() if name in names and isinstance(cells, list))
        if code is None or any(isinstance(cells[0], int) for cells in held if cells):
            return []
        places, kinds = rings.places(), dict(code.kinds())
        states = ((name, memory.states[name]) for name in names)
        fields = [(name, field) for name, state in states if state is not None for field in state._fields]
        keys = [StateField(*of) for of in fields if of not in places and kinds[StateField(*of)] is not float]
        rows = code.numbers(keys, memory.tick + periods * ticks, ticks)
        return rows.astype(np.int64).tolist() if code.is_sound() else []


class Alone(PartInterpreter):
    """Ticks of some blocks; what they read of others is held, and that at entries runs, a little away from itself."""

    def __init__(self, plan: Plan, memory: Memory, blocks: AbstractSet[str], entries: Sequence[Endpoint]) -> None:
        memory.wires |= {node: _away(value) for node, value in memory.wires.items() if node[0] not in blocks}
        super().__init__(plan, 0, memory, blocks)
        self._outputs = [
            (step, beat, _then_away(compute) if step in entries else compute) for step, beat, compute in self._outputs
        ]

    def wires(self, nodes: Sequence[Endpoint], last: int) -> Array:
        """Run up to, not including, the tick `last`, and return what wires of one number hold: a
        row for each tick.

        From a tick on that fails they hold nothing: a block that is given held signals may have
        none there.
        """
        rows = np.zeros((max(0, last - self._memory.tick), len(nodes)))
        with suppress(TickError):
            for row in rows:
                self.advance(self._memory.tick + 1, ())
                row[:] = [float(self._memory.wires[node]) for node in nodes]
        return rows


def _away(value: Any) -> Any:
    """Return a number a little away from itself; anything else as it is."""
    return value * _AWAY + _FROM_ZERO if isinstance(value, float) else value


def _then_away(compute: Callable[[int], Any]) -> Callable[[int], Any]:
    return lambda tick: _away(compute(tick))
