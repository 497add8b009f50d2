"""A checked graph made ready to run: constants, start values, solvers, probes. Both engines read this."""

import math
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from proofmass.blocks.declare import Block
from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.check import checked
from proofmass.graphs.flatten import flatten
from proofmass.graphs.graph import LARGEST_RUN, Graph, split
from proofmass.graphs.rates import write_rate
from proofmass.graphs.schedule import Node, Schedule, schedule
from proofmass.runner.constants import constants_of, start_of
from proofmass.runner.groups import ahead
from proofmass.runner.recording import read_recordings
from proofmass.runner.solvers import Solver, find_solvers


@dataclass(frozen=True)
class PlannedProbe:
    """A probe with the base ticks between its rows and the facts of what it records."""

    signal: str
    node: Node
    stride: int
    dtype: type
    shape: tuple[int, ...]
    unit: str
    doc: str

    def rows(self, first: int, last: int) -> int:
        """Rows recorded in the ticks from `first` up to, not including, `last`."""
        return -(-last // self.stride) - -(-first // self.stride)


@dataclass(frozen=True)
class Plan:
    """Everything that a run needs besides seed and length, in plain values."""

    graph: Graph
    schedule: Schedule
    constants: Mapping[str, Any]  # per block; None where driven parameters make them anew in every tick
    starts: Mapping[str, Any]  # state of each block at tick 0, None for blocks without
    buffers: Mapping[Node, tuple[float, ...]]  # content at tick 0
    solvers: tuple[Solver, ...]
    probes: tuple[PlannedProbe, ...]  # by name, whatever their order in the graph

    @cached_property
    def recorded(self) -> frozenset[Node]:
        """Buffers that hold a recording: nothing writes to them."""
        return frozenset((n, b) for n, b in self.buffers if n and self.blocks[n].buffers[b].recorded)

    @cached_property
    def ahead(self) -> tuple[Node, ...]:
        """What is computed for the next tick too, since inputs of continuous blocks move towards it."""
        return ahead(self.graph, self.schedule, (solver.group for solver in self.solvers))

    @property
    def blocks(self) -> Mapping[str, Block]:
        """Blocks by name."""
        return self.graph.blocks

    @property
    def period(self) -> float:
        """Base period in seconds."""
        return float(1 / self.schedule.base_rate)

    def block_period(self, name: str) -> float:
        """Period of a block in seconds."""
        return float(self.schedule.divisors[name] / self.schedule.base_rate)

    def ticks(self, duration: Fraction | None = None, samples: int | None = None) -> int:
        """Base ticks of a run: `samples`, or all from 0 to `duration` with both ends; else what the graph says."""
        if samples is None and duration is None:
            samples, duration = self.graph.samples, self.graph.duration
        if samples is not None:
            ticks = samples
        elif duration is not None:
            ticks = math.floor(duration * self.schedule.base_rate) + 1
        else:
            hint = 'add duration = "1 s" at the top of the file, or say --duration "1 s"'
            raise self._refused(Problem(message="how long to run is not said", key="duration", hint=hint))
        if ticks > LARGEST_RUN:
            expected = f"at most {LARGEST_RUN:g} ticks of {write_rate(self.schedule.base_rate)}"
            raise self._refused(Problem(message="too long", key="duration", got=f"{ticks:g} ticks", expected=expected))
        return ticks

    def _refused(self, problem: Problem) -> ModelError:
        return ModelError([self.graph.placed(problem)])

    def stride(self, node: Node) -> int:
        """Base ticks from one value of an output to its next."""
        block = self.blocks[node[0]]
        return self.schedule.divisors[node[0]] * block.size(block.outputs[node[1]].every)

    def stream(self, name: str) -> int:
        """Number of the block's random stream: from its name alone, so that nothing else moves its noise."""
        return zlib.crc32(name.encode())


def plan(graph: Graph) -> Plan:
    """Check, schedule and prepare a graph; raises `ModelError`."""
    probed = graph.probes  # as they are named there
    graph = flatten(checked(graph))
    scheduled = schedule(graph)
    made = Plan(graph, scheduled, {}, {}, {}, (), ())  # answers what follows from the schedule alone
    constants, starts, problems = dict[str, Any](), dict[str, Any](), list[Problem]()
    buffers: dict[Node, tuple[float, ...]] = {}
    as_set: dict[str, Any] = {}  # of blocks with driven parameters too
    for name, block in graph.blocks.items():
        driven = any((name, p) in scheduled.drivers for p in block.parameters)
        try:
            as_set[name] = constants_of(block, block, made.block_period(name))
            constants[name] = None if driven else as_set[name]
            if not all(map(math.isfinite, as_set[name] or ())):
                raise ArithmeticError("one of them is not finite")
            recorded = read_recordings(graph, name)
            filled = {b: recorded.get(b) or _zeros(block, b) for b in block.buffers}
            starts[name] = start_of(block, filled)
        except ModelError as error:
            problems += error.problems
        except (ArithmeticError, ValueError) as error:
            problems.append(
                Problem(
                    message=f"its constants cannot be computed: {error}",
                    key=f"blocks.{name}",
                    got=repr(block),
                    hint="look for a parameter many orders of magnitude off",
                    path=("blocks", name),
                )
            )
        else:
            buffers |= {(name, b): tuple(values) for b, values in filled.items()}
    if problems:
        raise ModelError([graph.placed(problem) for problem in problems])
    ready = Plan(graph, scheduled, constants, starts, buffers, (), ())
    solvers = find_solvers(ready, as_set, lambda: _first_tick(ready))
    buffers |= {solver.largest: (0.0,) * len(solver.group.states) for solver in solvers if solver.tolerance}
    named = sorted(zip(probed, graph.probes, strict=True))
    probes = tuple(_probe(made, probe.signal, split(inner.signal), probe.every) for probe, inner in named)
    return Plan(graph, scheduled, constants, starts, buffers, solvers, probes)


def _first_tick(ready: Plan) -> tuple[Mapping[str, Any], Mapping[Node, Any]]:
    """Constants and wires of tick 0, about which the continuous groups are linearised."""
    from proofmass.runner.interpret import Interpreter

    return Interpreter(ready, ready.graph.seed).first_tick()


def _zeros(block: Block, buffer: str) -> list[float]:
    declared = block.buffers[buffer]
    zero = 0 if declared.dtype is int else 0.0
    return [zero] * math.prod(block.shape_of(declared))


def _probe(made: Plan, signal: str, node: Node, every: int) -> PlannedProbe:
    block = made.blocks[node[0]]
    port = block.outputs[node[1]]
    return PlannedProbe(
        signal, node, made.stride(node) * every, port.dtype, block.shape_of(port), block.unit_of(port), port.doc
    )
