"""When and in which order everything happens: base rate, divisors, topological order over direct feedthrough."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.instance import size_of
from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.rates import base_rate

if TYPE_CHECKING:
    import networkx

_NAMED = 40  # wires of a loop
Node = tuple[str, str]  # block and output port; the port is "" for the constants of a block with driven parameters


@dataclass(frozen=True)
class AlgebraicLoop:
    """Outputs that need each other within an instant.

    Once the values of the `tears` are known, the `others` follow from them one after the other, in this order.
    """

    tears: tuple[Node, ...]
    others: tuple[Node, ...]

    @property
    def nodes(self) -> tuple[Node, ...]:
        """All of it, the tears first."""
        return self.tears + self.others


@dataclass(frozen=True)
class Schedule:
    """What both engines follow.

    `divisors` gives the base ticks per tick of each block; `order` the outputs in the order of a tick, with "" where
    the constants of a block are computed anew from its driven parameters, and the nodes of a loop one behind the other;
    `drivers` the output behind each input and driven parameter; `loops` what is solved within a tick.
    """

    base_rate: Fraction
    divisors: dict[str, int]
    order: tuple[Node, ...]
    drivers: dict[Node, Node]
    loops: tuple[AlgebraicLoop, ...] = ()


def schedule(graph: Graph) -> Schedule:
    """Schedule a graph whose wires are right; raises `ModelError` for a loop without delay that is not to be solved.

    Alphabetical among what may come in any order, so that the order of declaration changes nothing.
    """
    graph = flatten(graph)
    drivers = {split(wire.target): split(wire.source) for wire in graph.wires}
    rates = {name: block_rate(graph, name) for name, block in graph.blocks.items() if not type(block).continuous()}
    base = base_rate(rates.values()) if rates or graph.rate is None else graph.rate
    divisors = {name: int(base / rates[name]) if name in rates else 1 for name in graph.blocks}
    needs = _needs(graph, drivers)
    order, loops = in_order(needs)
    for loop in loops:
        obstacle = _obstacle(graph, divisors, loop)
        if obstacle or graph.integration.algebraic_loops == "refuse":
            raise ModelError([_loop(graph, _cycle(loop, needs), drivers, obstacle)])
    return Schedule(base, divisors, order, drivers, loops)


def _needs(graph: Graph, drivers: dict[Node, Node]) -> dict[Node, list[Node]]:
    """What must be known before each output, and before the constants of each block with driven parameters."""
    needs: dict[Node, list[Node]] = {}
    for name, block in graph.blocks.items():
        kind = type(block)
        constants: list[Node] = []
        driven = [drivers[name, parameter] for parameter in kind.parameters if (name, parameter) in drivers]
        if driven:
            constants = [(name, "")]
            needs[name, ""] = driven
        for port in kind.outputs:
            needs[name, port] = [drivers[name, i] for i in kind.feedthrough(port) if (name, i) in drivers]
            needs[name, port] += constants if kind.output_functions[port].reads_constants else []
    return needs


def last_name(path: str) -> tuple[str, str]:
    """What terms of a sum and unknowns are ordered by: their bits do not depend on the subgraphs that blocks lie in."""
    return path.rpartition(".")[2], path


def in_order(needs: Mapping[Node, Sequence[Node]]) -> tuple[tuple[Node, ...], tuple[AlgebraicLoop, ...]]:
    """The alphabetically first order in which each node comes after all that it needs, and the loops in it."""
    import networkx  # here, since it is the largest part of what a check takes

    wiring: networkx.DiGraph[Node] = networkx.DiGraph()
    wiring.add_nodes_from(needs)
    wiring.add_edges_from((before, after) for after, befores in needs.items() for before in befores)
    loops = sorted((_torn(wiring.subgraph(part)) for part in _cyclic(wiring)), key=lambda loop: loop.tears)
    if not loops:
        return tuple(networkx.lexicographical_topological_sort(wiring)), ()
    merged = networkx.relabel_nodes(wiring, {node: loop.tears[0] for loop in loops for node in loop.nodes})
    merged.remove_edges_from(list(networkx.selfloop_edges(merged)))
    whole = {loop.tears[0]: loop.nodes for loop in loops}
    order = networkx.lexicographical_topological_sort(merged)
    return tuple(node for first in order for node in whole.get(first, (first,))), tuple(loops)


def _cyclic(wiring: "networkx.DiGraph[Node]") -> list[set[Node]]:
    """Sets of nodes that all need each other."""
    import networkx

    parts = networkx.strongly_connected_components(wiring)
    return [part for part in parts if len(part) > 1 or wiring.has_edge(*part, *part)]


def _torn(wiring: "networkx.DiGraph[Node]") -> AlgebraicLoop:
    """A loop whose tears are, of each set of nodes that still need each other, the alphabetically first."""
    import networkx

    left, tears = wiring.copy(), set[Node]()
    while parts := _cyclic(left):
        for part in parts:
            first = min(part, key=_by_last_name)
            tears.add(first)
            left.remove_edges_from(list(left.out_edges(first)))
    order = networkx.lexicographical_topological_sort(left)
    return AlgebraicLoop(tuple(sorted(tears, key=_by_last_name)), tuple(node for node in order if node not in tears))


def _by_last_name(node: Node) -> tuple[str, str, str]:
    return *last_name(node[0]), node[1]


def _obstacle(graph: Graph, divisors: Mapping[str, int], loop: AlgebraicLoop) -> str:
    """Why Newton's method cannot solve a loop; empty when it can."""
    strides = set[int]()
    for name, port in loop.nodes:
        block = graph.blocks[name]
        if not port:
            return f"the parameters of {name} depend on its own outputs"
        output = type(block).outputs[port]
        if output.dtype is not float or output.shape:
            return f"{name}.{port} is not a single number of type float"
        if Meaning.DEVIATE in type(block).output_functions[port].meanings:
            return f"{name}.{port} draws noise"
        strides.add(divisors[name] * size_of(block, output.every))
    return "its outputs have different rates" if len(strides) > 1 else ""


def block_rate(graph: Graph, name: str) -> Fraction:
    """The rate of a discrete block: its own or the graph's."""
    rate = graph.rates.get(name, graph.rate)
    if rate is None:
        raise ModelError([Problem(message="has no rate, and neither has the graph", key=f"blocks.{name}")])
    return rate


def _cycle(loop: AlgebraicLoop, needs: Mapping[Node, Sequence[Node]]) -> list[Node]:
    """One way round a loop; the first and last node are the same."""
    inside, path = set(loop.nodes), dict[Node, None]()
    node = loop.nodes[0]
    while node not in path:
        path[node] = None
        node = min(before for before in needs[node] if before in inside)
    backwards = [*path, node]
    return backwards[backwards.index(node) :][::-1]


def _loop(graph: Graph, cycle: list[Node], drivers: dict[Node, Node], obstacle: str) -> Problem:
    """The loop named port by port, from its alphabetically first wire on; the first and last node are the same."""
    wires = []
    for source, (name, port) in pairwise(cycle):
        if source == (name, ""):
            continue
        block = graph.blocks[name]
        entries = type(block).feedthrough(port) if port else type(block).parameters
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
        hint=f"put a UnitDelay into one of these wires, for example into {wires[-1]}; {cannot if obstacle else solve}",
        path=("wires", wires[-1]),
    )
