"""The schedule: base rate, divisors, and the topological order of outputs by direct feedthrough."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import pairwise
from typing import Generic, NamedTuple, TypeAlias, TypeVar

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.instance import size_of
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.digraph import alphabetical, loops
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.graphs.model.rates import base_rate, with_offsets

_NAMED = 40  # at most so many wires of a loop are named in a message


class ConstantsOf(NamedTuple):
    """The constants of a block with driven parameters, computed each tick before its outputs."""

    block: str


class Beat(NamedTuple):
    """Base ticks in which something happens: every `stride`, the first of them `phase`."""

    stride: int
    phase: int = 0

    def before(self, tick: int) -> int:
        """Return how many of them come before a tick."""
        return -((self.phase - tick) // self.stride)

    def at(self, number: int) -> int:
        """Return the base tick of the one with this number, counted from 0."""
        return self.phase + number * self.stride


OutputStep: TypeAlias = Endpoint | ConstantsOf  # one step of a tick
_Node = TypeVar("_Node", bound=OutputStep)


class Torn(NamedTuple, Generic[_Node]):
    """Steps that need each other within an instant.

    Once the values of the `tears` are known, the `others` follow from them one after the other, in
    this order.
    """

    tears: tuple[_Node, ...]
    others: tuple[_Node, ...]

    @property
    def nodes(self) -> tuple[_Node, ...]:
        """All members of the loop, the tears first."""
        return self.tears + self.others


AlgebraicLoop: TypeAlias = Torn[Endpoint]  # of outputs alone


@dataclass(frozen=True)
class Schedule:
    """The order of work in a tick, which all engines follow.

    `divisors` gives the base ticks per tick of each block, `phases` its first one where that is
    not 0. `order` has the outputs in the order of a tick, with the constants of blocks with driven
    parameters; the nodes of a loop follow each other. `drivers` gives the output that drives each
    input and driven parameter; `loops` are solved within a tick. `without_noise` makes all random
    numbers zero.
    """

    base_rate: Fraction
    divisors: dict[str, int]
    order: tuple[OutputStep, ...]
    drivers: dict[Endpoint, Endpoint]
    loops: tuple[AlgebraicLoop, ...] = ()
    without_noise: bool = False
    phases: dict[str, int] = field(default_factory=dict)

    def beat(self, name: str) -> Beat:
        """Return when a block ticks."""
        return Beat(self.divisors[name], self.phases.get(name, 0))


def schedule(graph: FlatGraph) -> Schedule:
    """Schedule a graph whose wires are right; raises `ModelError` for a loop without delay that is
    not to be solved.

    Steps that may come in any order are in alphabetical order, so the order of declaration changes
    nothing.
    """
    drivers = {split(wire.target): split(wire.source) for wire in graph.wires}
    rates = {name: block_rate(graph, name) for name, block in graph.blocks.items() if not type(block).continuous()}
    base = base_rate(rates.values()) if rates or graph.rate is None else graph.rate
    base = with_offsets(base, graph.offsets.values())
    divisors = {name: int(base / rates[name]) if name in rates else 1 for name in graph.blocks}
    phases = {name: int(base * offset) for name, offset in graph.offsets.items()}
    needs = _needs(graph, drivers)
    order, cycles = in_order(needs)
    for cycle in cycles:
        obstacle = _obstacle(graph, divisors, phases, cycle)
        if obstacle or graph.integration.algebraic_loops == "refuse":
            raise _loop(graph, _cycle(cycle, needs), drivers, obstacle).error
    return Schedule(base, divisors, order, drivers, tuple(map(loop_of, cycles)), phases=phases)


def outputs_of(steps: Iterable[OutputStep]) -> tuple[Endpoint, ...]:
    """Return the steps that are outputs."""
    return tuple(step for step in steps if not isinstance(step, ConstantsOf))


def loop_of(cycle: Torn[OutputStep]) -> AlgebraicLoop:
    """Return the algebraic loop of a cycle without an obstacle: it contains outputs alone."""
    return AlgebraicLoop(outputs_of(cycle.tears), outputs_of(cycle.others))


def _needs(graph: FlatGraph, drivers: dict[Endpoint, Endpoint]) -> dict[OutputStep, list[OutputStep]]:
    """Steps that must come before each output, and before the constants of each block with driven parameters."""
    needs: dict[OutputStep, list[OutputStep]] = {}
    for name, block in graph.blocks.items():
        constants: list[OutputStep] = []
        driven: list[OutputStep] = [drivers[name, p] for p in type(block).parameters if (name, p) in drivers]
        if driven:
            constants = [ConstantsOf(name)]
            needs[ConstantsOf(name)] = driven
        for port in type(block).outputs:
            needs[name, port] = [drivers[name, i] for i in type(block).feedthrough(port) if (name, i) in drivers]
            needs[name, port] += constants if type(block).output_functions[port].reads_constants else []
    return needs


def last_name(path: str) -> tuple[str, str]:
    """Sort key of terms of a sum and unknowns: bits do not depend on nesting of subgraphs."""
    return path.rpartition(".")[2], path


def in_order(
    needs: Mapping[OutputStep, Sequence[OutputStep]],
) -> tuple[tuple[OutputStep, ...], tuple[Torn[OutputStep], ...]]:
    """The alphabetically first order in which each step comes after all that it needs, and the cycles in it."""
    cycles = sorted((_torn(needs, part) for part in loops(needs)), key=lambda cycle: cycle.tears)
    if not cycles:
        return tuple(alphabetical(needs)), ()
    first = {node: cycle.tears[0] for cycle in cycles for node in cycle.nodes}
    merged: dict[OutputStep, set[OutputStep]] = {}
    for node, befores in needs.items():
        one = first.get(node, node)
        merged.setdefault(one, set()).update(other for b in befores if (other := first.get(b, b)) != one)
    whole = {cycle.tears[0]: cycle.nodes for cycle in cycles}
    return tuple(node for one in alphabetical(merged) for node in whole.get(one, (one,))), tuple(cycles)


def _torn(needs: Mapping[OutputStep, Sequence[OutputStep]], part: set[OutputStep]) -> Torn[OutputStep]:
    """Tear a cycle: the alphabetically first step of each set of steps that need each other."""
    left, tears = {node: [before for before in needs[node] if before in part] for node in part}, set[OutputStep]()
    while parts := loops(left):
        new = {min(part, key=_by_last_name) for part in parts}
        tears |= new
        left = {node: [before for before in befores if before not in new] for node, befores in left.items()}
    others = (node for node in alphabetical(left) if node not in tears)
    return Torn(tuple(sorted(tears, key=_by_last_name)), tuple(others))


def _by_last_name(step: OutputStep) -> tuple[str, str, str]:
    return *last_name(step[0]), "" if isinstance(step, ConstantsOf) else step[1]


def _obstacle(graph: FlatGraph, divisors: Mapping[str, int], phases: Mapping[str, int], cycle: Torn[OutputStep]) -> str:
    """Return why Newton's method cannot solve a loop; empty when it can."""
    beats = set[Beat]()
    for step in cycle.nodes:
        if isinstance(step, ConstantsOf):
            return f"the parameters of {step.block} depend on its own outputs"
        name, port = step
        block = graph.blocks[name]
        output = type(block).outputs[port]
        if output.dtype is not float or output.shape:
            return f"{name}.{port} is not a single number of type float"
        if Meaning.DEVIATE in type(block).output_functions[port].meanings:
            return f"{name}.{port} draws noise"
        beats.add(Beat(divisors[name] * size_of(block, output.every), phases.get(name, 0)))
    return "its outputs have different rates" if len(beats) > 1 else ""


def block_rate(graph: FlatGraph, name: str) -> Fraction:
    """The rate of a discrete block: its own or the graph's, one of which a checked graph has."""
    rate = graph.rates.get(name, graph.rate)
    assert rate is not None
    return rate


def _cycle(cycle: Torn[OutputStep], needs: Mapping[OutputStep, Sequence[OutputStep]]) -> list[OutputStep]:
    """One way round a cycle; the first and last step are the same."""
    inside, path = set(cycle.nodes), dict[OutputStep, None]()
    node = cycle.nodes[0]
    while node not in path:
        path[node] = None
        node = min(before for before in needs[node] if before in inside)
    backwards = [*path, node]
    return backwards[backwards.index(node) :][::-1]


def _loop(graph: FlatGraph, cycle: list[OutputStep], drivers: dict[Endpoint, Endpoint], obstacle: str) -> Problem:
    """The ports of a loop in order, from its alphabetically first wire on; the first and last are the same."""
    wires = []
    for source, target in pairwise(cycle):
        if isinstance(source, ConstantsOf):
            continue
        name, block = target[0], graph.blocks[target[0]]
        entries = type(block).parameters if isinstance(target, ConstantsOf) else type(block).feedthrough(target[1])
        entry = next(entry for entry in entries if drivers.get((name, entry)) == source)
        wires.append(f"{'.'.join(source)} -> {name}.{entry}")
    first = wires.index(min(wires))
    wires = wires[first:] + wires[:first]
    named = wires if len(wires) <= _NAMED else [*wires[:_NAMED], f"and {len(wires) - _NAMED} more"]
    solve = 'or have the loop solved: algebraic_loops = "newton" under [integration]'
    cannot = f"Newton's method cannot solve the loop, since {obstacle}"
    return Problem(
        message="algebraic loop: each of these outputs needs the one before it within the same tick",
        key="wires",
        got=", ".join(named),
        expected="at least one block in the loop whose output does not depend on its input in the same tick",
        hint=f"{_instead(graph, cycle)}put a UnitDelay into one of these wires, for example into {wires[-1]};"
        f" {cannot if obstacle else solve}",
        path=("wires", wires[-1]),
    )


def _instead(graph: FlatGraph, cycle: Sequence[OutputStep]) -> str:
    """Hint at an output to stand for one of the cycle, as the strictly proper part of a filter."""
    for name, port in outputs_of(cycle):
        kind = type(graph.blocks[name])
        own = kind.outputs[port]
        for other, output in kind.outputs.items():
            alike = (output.dtype, output.unit, output.shape) == (own.dtype, own.unit, own.shape)
            if alike and not kind.feedthrough(other):
                place = f"in place of {name}.{port}"
                return f"{name}.{other} needs no input of the same tick: wire it {place} if it serves. Or "
    return ""
