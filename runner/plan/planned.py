"""A checked graph made ready to run, as a plain value that all engines read."""

import math
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.behaviour import Behaviour
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import shape_of, size_of, unit_of
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.checks.schedule import Beat, Schedule
from proofmass.graphs.model.derived import Derived
from proofmass.graphs.model.digraph import with_following
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.limits import LARGEST_RUN
from proofmass.graphs.model.rates import write_rate
from proofmass.runner.fixed.digital import DigitalBlock
from proofmass.runner.plan.bindings import Binding, bindings
from proofmass.runner.plan.groups import ahead
from proofmass.runner.plan.keys import LargestOf, VectorOf
from proofmass.runner.plan.solver import Solver


@dataclass(frozen=True)
class PlannedProbe:
    """A probe with the base ticks between its rows and the facts of what it records."""

    signal: str
    node: Endpoint
    stride: int
    dtype: type
    shape: tuple[int, ...]
    unit: str
    doc: str
    format: Fixed | None = None  # of a fixed-point signal: its rows are mantissas
    phase: int = 0  # base tick of the first row

    @property
    def beat(self) -> Beat:
        """Ticks in which the probe records."""
        return Beat(self.stride, self.phase)

    def rows(self, first: int, last: int) -> int:
        """Rows recorded in the ticks from `first` up to, not including, `last`."""
        return self.beat.before(last) - self.beat.before(first)


@dataclass(frozen=True)
class PlannedMeasure:
    """A measure: the output that gives it after a run, of a hidden block if the measure has one, and its first tick."""

    name: str
    signal: str
    statistic: str
    unit: str
    node: Endpoint
    reduced: bool
    first: int  # base tick of the first value that counts
    shown_in: str = ""  # unit of tables, such as "deg/h", where the graph says one


@dataclass(frozen=True)
class Driven:
    """Stands for constants that each tick computes from the signals that drive parameters."""


@dataclass(frozen=True, kw_only=True)
class WiredPlan:
    """A flat graph with its schedule: all that is known before the constants."""

    graph: FlatGraph
    schedule: Schedule
    blocks: Mapping[str, Block]  # those of the graph, or the same with other numbers

    @property
    def period(self) -> float:
        """Base period in seconds."""
        return float(1 / self.schedule.base_rate)

    def block_period(self, name: str) -> float:
        """Period of a block in seconds."""
        return float(self.schedule.divisors[name] / self.schedule.base_rate)

    def ticks(self, duration: Fraction | None = None, samples: int | None = None) -> int:
        """Base ticks of a run: `samples`, or all from 0 to `duration` with both ends; by default those of the graph."""
        if samples is None and duration is None:
            samples, duration = self.graph.samples, self.graph.duration
        if samples is not None:
            ticks = samples
        elif duration is not None:
            ticks = math.floor(duration * self.schedule.base_rate) + 1
        else:
            in_file = 'add duration = "1 s" at the top of the file, or say --duration "1 s"'
            hint = in_file if self.graph.root.place.file else 'say how long: simulate(graph, duration="1 s")'
            raise self._refused(Problem(message="how long to run is not said", key="duration", hint=hint))
        if ticks > LARGEST_RUN:
            expected = f"at most {LARGEST_RUN:g} ticks of {write_rate(self.schedule.base_rate)}"
            raise self._refused(Problem(message="too long", key="duration", got=f"{ticks:g} ticks", expected=expected))
        return ticks

    def _refused(self, problem: Problem) -> ModelError:
        return self.graph.placed(problem).error

    def stride(self, node: Endpoint) -> int:
        """Base ticks from one value of an output to its next."""
        block = self.blocks[node[0]]
        return self.schedule.divisors[node[0]] * size_of(block, type(block).outputs[node[1]].every)

    def unit(self, node: Endpoint) -> str:
        """Unit of an output."""
        block = self.blocks[node[0]]
        return unit_of(block, type(block).outputs[node[1]])

    @cached_property
    def readers(self) -> dict[str, list[str]]:
        """The blocks that read each block, driven parameters included."""
        readers: dict[str, list[str]] = {name: [] for name in self.blocks}
        for (target, _), (source, _) in self.schedule.drivers.items():
            readers[source].append(target)
        return readers

    def beat(self, node: Endpoint) -> Beat:
        """Ticks in which an output has a new value."""
        return Beat(self.stride(node), self.schedule.phases.get(node[0], 0))

    def bindings(self, name: str, function: str) -> tuple[Binding, ...]:
        """Return the bindings of a function of a block, named by its role or by its output."""
        block = self.blocks[name]
        behaviour = type(block).output_functions.get(function) or type(block).functions[function]
        return tuple(self.bound(name, function, behaviour))

    def bound(self, name: str, port: str, behaviour: Behaviour) -> Iterator[Binding]:
        """Yield the binding of each argument of a function of a block, with or without a role."""
        return bindings(self.schedule, self.blocks[name], name, port, behaviour)

    def stream(self, name: str) -> int:
        """Number of the block's random stream: the hash of the shortest end of its path that no
        other block shares.

        So the noise of a block does not change when the block moves into a subgraph, and two blocks
        never share noise.
        """
        ends = list(_ends(name))
        return zlib.crc32(next((end for end in ends if self._ends[end] == 1), ends[-1]).encode())

    @cached_property
    def _ends(self) -> Counter[str]:
        return Counter(end for name in self.graph.blocks for end in _ends(name))


@dataclass(frozen=True, kw_only=True)
class Filled(WiredPlan):
    """A `WiredPlan` with the numbers of every block: outputs can be computed, continuous blocks cannot move yet."""

    constants: Mapping[str, Any]  # per block; `Driven` if each tick computes them
    starts: Mapping[str, Any]  # state of each block at tick 0, None for blocks without
    buffers: Mapping[VectorOf, tuple[float, ...]]  # content at tick 0
    digital: Mapping[str, DigitalBlock]  # the blocks that work in fixed point

    def is_driven(self, name: str) -> bool:
        """Return whether each tick computes the constants of a block."""
        return isinstance(self.constants[name], Driven)

    @cached_property
    def recorded(self) -> frozenset[Endpoint]:
        """Buffers with a recording: nothing writes to them."""
        nodes = (node for node in self.buffers if not isinstance(node, LargestOf))
        return frozenset((name, buffer) for name, buffer in nodes if type(self.blocks[name]).buffers[buffer].recorded)


@dataclass(frozen=True, kw_only=True)
class Plan(Filled):
    """Everything that a run needs besides seed and length, in plain values; fixed-point values are mantissas."""

    solvers: tuple[Solver, ...]
    probes: tuple[PlannedProbe, ...]  # by name, whatever their order in the graph
    measures: tuple[PlannedMeasure, ...]  # by name
    derived: tuple[Derived, ...] = ()  # measures that follow from these, each after those it needs

    def same_sizes(self, other: "Plan") -> bool:
        """Return whether the loop of this plan can run another plan that differs in parameters alone.

        Parameters that are true or false are a part of the loop. The length of a buffer may depend
        on a number: the wider the band of flicker noise, the longer its buffer.
        """
        changed = (name for name, block in self.blocks.items() if block is not other.blocks[name])
        return all(self._sizes(name) == other._sizes(name) for name in changed)

    def _sizes(self, name: str) -> list[Any]:
        """Return the lengths of a block's buffers, outputs and lists among its constants, and its truth values."""
        block, constants = self.blocks[name], self.constants[name]
        lists = [] if isinstance(constants, Driven) else [_lengths(value) for value in constants or ()]
        buffers = [len(self.buffers[name, buffer]) for buffer in type(block).buffers]
        truths = [getattr(block, name) for name, declared in type(block).parameters.items() if declared.kind is bool]
        return [buffers, [shape_of(block, port) for port in type(block).outputs.values()], lists, truths]

    @cached_property
    def ahead(self) -> tuple[Endpoint, ...]:
        """Outputs that are computed for the next tick too, since inputs of continuous blocks move towards it."""
        return ahead(self.graph, self.schedule, (solver.group for solver in self.solvers))

    def part(self, blocks: AbstractSet[str]) -> "Plan":
        """The plan of some blocks, of what they depend on, and of the groups that they move with,
        without its probes.

        Each has the ticks, the numbers and the random stream that it has in the whole.
        """
        drivers, solvers = self.schedule.drivers, self.solvers
        sources: dict[str, set[str]] = {name: set() for name in self.blocks}
        for (target, _), (source, _) in drivers.items():
            sources[target].add(source)
        for solver in solvers:
            for name in solver.group.blocks:
                sources[name] |= {*solver.group.blocks, *(node[0] for node in solver.group.nodes)}
        own = with_following({*blocks}, sources.__getitem__)
        schedule = replace(
            self.schedule,
            order=tuple(step for step in self.schedule.order if step[0] in own),
            drivers={target: source for target, source in drivers.items() if target[0] in own},
            loops=tuple(loop for loop in self.schedule.loops if loop.tears[0][0] in own),
        )
        held = tuple(solver for solver in solvers if not own.isdisjoint(solver.group.blocks))
        return replace(
            self,
            schedule=schedule,
            blocks={name: block for name, block in self.blocks.items() if name in own},
            buffers={
                node: kept
                for node, kept in self.buffers.items()
                if (node in (s.largest for s in held) if isinstance(node, LargestOf) else node[0] in own)
            },
            digital={name: block for name, block in self.digital.items() if name in own},
            solvers=held,
            probes=(),
            measures=(),
            derived=(),
        )

    @cached_property
    def without_noise(self) -> "Plan":
        """The plan with random numbers that are all zero; itself where none are drawn."""
        kinds = {type(block) for block in self.blocks.values()}
        functions = (f for kind in kinds for f in (*kind.output_functions.values(), *kind.functions.values()))
        drawn = any(Meaning.DEVIATE in function.meanings for function in functions)
        return replace(self, schedule=replace(self.schedule, without_noise=True)) if drawn else self


def _lengths(value: Any) -> Any:
    """Return the lengths of lists in lists, as deep as they go."""
    return [_lengths(entry) for entry in value] if isinstance(value, tuple) else None


def _ends(path: str) -> Iterator[str]:
    """Every end of a path, the shortest first.

    >>> list(_ends("imu.x_axis.noise"))
    ['noise', 'x_axis.noise', 'imu.x_axis.noise']
    """
    parts = path.split(".")
    return (".".join(parts[-length:]) for length in range(1, len(parts) + 1))
