"""Runs in machine code of a graph whose quantisers of one bit also say what they choose a level from.

Such a block is given one more output. Its function is that of an output that is a level as it is
chosen, where each rule that chooses returns its argument instead.
"""

import builtins
import types
from collections.abc import Callable, Hashable, Iterator, Mapping, MutableMapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from proofmass.blocks.arithmetic.rounding import nearest_even_level, nearest_level, two_level
from proofmass.blocks.declaration.declare import Block, BlockType
from proofmass.graphs.model.build import read_probe
from proofmass.graphs.model.graph import split
from proofmass.runner.analysis.linearisation.map_blocks import upstream_of
from proofmass.runner.derivatives.dual_functions import LEVELS, reaches
from proofmass.runner.derivatives.dual_noise import OneBitGain, given
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import Deviate
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan as planned
from proofmass.runner.run.engines import choose
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import RunOptions, simulate_plan

FEWEST, MOST, SETTLING = 1 << 19, 1 << 22, 1 << 14  # decisions that count, and before them
_MOST_CALLS = 200_000_000  # of functions of blocks
_PLACES = 32  # in a run, at which the decisions that count may begin
_LEFT = 0.5  # part of the ticks of runs that are to be left for a later tick
_SHOWN = 1 << 18  # decisions whose sources of noise are drawn once more
_PORT = "value_that_is_quantised"


class Decisions(NamedTuple):
    """Inputs of a quantiser with the levels that it chooses, and some sources of noise as they are drawn."""

    values: Array
    levels: Array
    sources: Sequence[Array] = ()

    def settled(self, number: int) -> "Decisions":
        """Return those after a number of decisions and as many as a loop takes to settle; of few the second half.

        They begin at one of few places in a run, so that operating points near each other have the same.
        """
        apart = max(SETTLING, len(self.values) // _PLACES)
        first = min(-(-(number + SETTLING) // apart) * apart, len(self.values) // 2)
        return Decisions(self.values[first:], self.levels[first:])


@dataclass(frozen=True, eq=False)
class TwoRuns:
    """The decisions of a quantiser in two runs with different noise, and the gains that they show."""

    first: Decisions
    second: Decisions
    gains: dict[bool, OneBitGain] = field(default_factory=dict)  # in a loop, or not


@dataclass(frozen=True)
class CompiledRuns:
    """Two runs from tick 0 to some ticks for the decisions from a first tick on, by block."""

    decisions: Sequence[Mapping[str, Decisions]]  # without sources
    first: int
    ticks: int
    settled: dict[Hashable, Mapping[str, TwoRuns]] = field(default_factory=dict)  # by how many decisions are left


KeptRuns: TypeAlias = MutableMapping[Hashable, Any]  # `CompiledRuns` by blocks and span


def level_port(kind: BlockType) -> str | None:
    """Return an output that is a level as it is chosen, if there is one."""
    ports = kind.output_functions.items()
    levels = (n for n, of in ports if of.returns is float and reaches(of.function, LEVELS))
    return next(levels, None)


def compiled_runs(
    plan: Plan,
    tick: int,
    upstream: AbstractSet[str],
    ports: Mapping[str, str],
    seeds: tuple[int, int],
    span: int,
    kept: KeptRuns,
) -> Mapping[str, TwoRuns] | None:
    """Return the decisions of each block from a tick on with two seeds.

    The runs last for a `span` of base ticks, if that is not too few decisions, or too many. Those
    that are `kept` of an earlier tick will do if they go on for long enough. None for a graph that
    machine code cannot run.
    """
    key = frozenset(upstream), span
    known: CompiledRuns | None = kept.get(key)
    if known is None or known.ticks - tick < _LEFT * (known.ticks - known.first):
        watching, ticks = _watching(plan, upstream, ports, span)
        if choose(watching, tick + ticks, "auto") != "compiled":
            return None
        options = (RunOptions(samples=tick + ticks, seed=seed) for seed in seeds)
        results = (simulate_plan(watching, watching.graph.root, each) for each in options)
        runs = [{name: _decisions(watching, result, name, ports[name]) for name in ports} for result in results]
        known = kept[key] = CompiledRuns(runs, tick, tick + ticks)
    strides = {name: plan.stride((name, port)) for name, port in ports.items()}
    settled = [{name: of.settled(tick // strides[name]) for name, of in run.items()} for run in known.decisions]
    left = tuple(len(of.values) for of in settled[0].values())
    if left not in known.settled:
        whole = len(next(iter(known.decisions[0].values())).values)
        drawn = [_drawn(plan, upstream, ports, seed, whole - left[0], left[0]) for seed in seeds]
        first, second = (
            {n: of._replace(sources=own) for n, of in run.items()} for run, own in zip(settled, drawn, strict=True)
        )
        known.settled[left] = {name: TwoRuns(first[name], second[name]) for name in ports}
    return known.settled[left]


def _drawn(
    plan: Plan, upstream: AbstractSet[str], ports: Mapping[str, str], seed: int, first: int, count: int
) -> list[Array]:
    """Return sources of noise as they are drawn for some decisions from a first one on, but for no more than show."""
    sources = [*_sources(plan, upstream, ports)]
    if not sources:
        return []
    drawing = part_of(plan, upstream_of(plan, (split(source)[0] for source in sources)), sources, {})
    last = first + min(count, _SHOWN)
    stride = plan.stride(split(sources[0]))
    result = simulate_plan(drawing, drawing.graph.root, RunOptions(samples=last * stride, seed=seed))
    return [result[source].values[first:last] for source in sources]


def part_of(plan: Plan, upstream: AbstractSet[str], probes: Sequence[str], instead: Mapping[str, Block]) -> Plan:
    """Return the plan of some blocks alone, some of them replaced, with these probes."""
    flat = plan.graph
    graph = flat.as_graph().bare(
        blocks={name: instead.get(name, plan.blocks[name]) for name in upstream},
        wires=tuple(wire for wire in flat.wires if {split(wire.source)[0], split(wire.target)[0]} <= upstream),
        rates={name: rate for name, rate in flat.rates.items() if name in upstream},
        offsets={name: offset for name, offset in flat.offsets.items() if name in upstream},
        probes=tuple(map(read_probe, probes)),
    )
    return planned(graph)


def _watching(plan: Plan, upstream: AbstractSet[str], ports: Mapping[str, str], span: int) -> tuple[Plan, int]:
    """Return the plan of the blocks upstream alone, with the further outputs, and how many ticks it should run."""
    telling = {name: _telling(plan.blocks[name], port) for name, port in ports.items()}
    signals = [f"{name}.{port}" for name in ports for port in (_PORT, ports[name])]
    watching = part_of(plan, upstream, signals, telling)
    slowest = max(watching.schedule.divisors[name] for name in ports)
    decisions = min(max(span // slowest, FEWEST), MOST) + SETTLING
    return watching, min(decisions * slowest, _MOST_CALLS // len(watching.schedule.order))


def _sources(plan: Plan, upstream: AbstractSet[str], ports: Mapping[str, str]) -> Iterator[str]:
    """Yield the outputs of blocks that draw random numbers as often as every quantiser decides."""
    beats = {plan.beat((name, port)) for name, port in ports.items()}
    for name in sorted(given(plan, (Deviate,)) & upstream):
        for port, declared in type(plan.blocks[name]).outputs.items():
            if declared.dtype is float and not declared.shape and beats == {plan.beat((name, port))}:
                yield f"{name}.{port}"


def _telling(block: Block, port: str) -> Block:
    """Return the same block with an output for what the quantiser of another output is given, in the same units."""
    kind = type(block)
    own: Any = BlockType(kind.__name__, (kind,), {"__doc__": kind.__doc__, "__module__": kind.__module__})
    declared = kind.__declaration__
    own.__declaration__ = replace(
        declared, outputs=dict(declared.outputs), output_functions=dict(declared.output_functions)
    )
    function = _without_levels(kind.output_functions[port].function)
    function.__name__ = _PORT
    own.output("1")(function)
    told: Block = own(**vars(block))
    return told


def _value(value: float, last: float) -> float:
    return value


def _second(on: bool, value: float) -> float:
    return value


_INSTEAD: Mapping[Any, Any] = {nearest_level: _value, nearest_even_level: _value, two_level: _second, int: float}


def _without_levels(function: Any) -> Any:
    """Return a copy of a function that calls none of the rules that choose a level, but has their argument."""
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        value = names.get(name, getattr(builtins, name, None))
        if isinstance(value, Callable) and value in _INSTEAD:  # type: ignore[arg-type]
            names[name] = _INSTEAD[value]
        elif isinstance(value, types.FunctionType) and reaches(value, LEVELS):
            names[name] = _without_levels(value)
    code, defaults = function.__code__, function.__defaults__
    copy = types.FunctionType(code, names, function.__name__, defaults, function.__closure__)
    copy.__doc__, copy.__kwdefaults__ = function.__doc__, function.__kwdefaults__
    copy.__annotations__ = {**function.__annotations__, "return": float}  # also that of a number of a level
    return copy


def _decisions(watching: Plan, result: Result, name: str, port: str) -> Decisions:
    """Return the decisions of a run in units of levels that the rule chooses."""
    values, levels = (np.array(result[f"{name}.{each}"].values, dtype=float) for each in (_PORT, port))
    low, high = float(levels.min()), float(levels.max())
    signs = reaches(type(watching.blocks[name]).output_functions[port].function, {two_level})
    step = (high - low) / (2.0 if signs else 1.0) or 1.0
    for each in (values, levels):
        each -= low
        each /= step
        each -= 1.0 if signs else 0.0
    return Decisions(values, levels)
