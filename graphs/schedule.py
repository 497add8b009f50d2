"""When and in which order everything happens: base rate, divisors, topological order over direct feedthrough."""

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.flatten import flatten
from proofmass.graphs.graph import Graph, split
from proofmass.graphs.rates import base_rate

_NAMED = 40  # wires of a loop
Node = tuple[str, str]  # block and output port; the port is "" for the constants of a block with driven parameters


@dataclass(frozen=True)
class Schedule:
    """What both engines follow.

    `divisors` gives the base ticks per tick of each block; `order` the outputs in the order of a tick, with "" where
    the constants of a block are computed anew from its driven parameters; `drivers` the output behind each input and
    driven parameter.
    """

    base_rate: Fraction
    divisors: dict[str, int]
    order: tuple[Node, ...]
    drivers: dict[Node, Node]


def schedule(graph: Graph) -> Schedule:
    """Schedule a graph whose wires are right; raises `ModelError` for a loop without delay.

    Alphabetical among what may come in any order, so that the order of declaration changes nothing.
    """
    graph = flatten(graph)
    drivers = {split(wire.target): split(wire.source) for wire in graph.wires}
    rates = {name: block_rate(graph, name) for name, block in graph.blocks.items() if not block.continuous()}
    base = base_rate(rates.values()) if rates or graph.rate is None else graph.rate
    divisors = {name: int(base / rates[name]) if name in rates else 1 for name in graph.blocks}
    return Schedule(base, divisors, _in_order(graph, _needs(graph, drivers), drivers), drivers)


def _needs(graph: Graph, drivers: dict[Node, Node]) -> dict[Node, list[Node]]:
    """What must be known before each output, and before the constants of each block with driven parameters."""
    needs: dict[Node, list[Node]] = {}
    for name, block in graph.blocks.items():
        constants: list[Node] = []
        driven = [drivers[name, parameter] for parameter in block.parameters if (name, parameter) in drivers]
        if driven:
            constants = [(name, "")]
            needs[name, ""] = driven
        for port in block.outputs:
            needs[name, port] = [drivers[name, i] for i in block.feedthrough(port) if (name, i) in drivers]
            needs[name, port] += constants if block.output_functions[port].reads_constants else []
    return needs


def _in_order(graph: Graph, needs: dict[Node, list[Node]], drivers: dict[Node, Node]) -> tuple[Node, ...]:
    import networkx  # here, since it is the largest part of what a check takes

    wiring: networkx.DiGraph[Node] = networkx.DiGraph()
    wiring.add_nodes_from(needs)
    wiring.add_edges_from((before, after) for after, befores in needs.items() for before in befores)
    try:
        return tuple(networkx.lexicographical_topological_sort(wiring))
    except networkx.NetworkXUnfeasible:
        edges = networkx.find_cycle(wiring)
        raise ModelError([_loop(graph, [*(edge[0] for edge in edges), edges[0][0]], drivers)]) from None


def block_rate(graph: Graph, name: str) -> Fraction:
    """The rate of a discrete block: its own or the graph's."""
    rate = graph.rates.get(name, graph.rate)
    if rate is None:
        raise ModelError([Problem(message="has no rate, and neither has the graph", key=f"blocks.{name}")])
    return rate


def _loop(graph: Graph, cycle: list[Node], drivers: dict[Node, Node]) -> Problem:
    """The loop named port by port, from its alphabetically first wire on; the first and last node are the same."""
    wires = []
    for source, (name, port) in pairwise(cycle):
        if source == (name, ""):
            continue
        block = graph.blocks[name]
        entries = block.feedthrough(port) if port else block.parameters
        entry = next(entry for entry in entries if drivers.get((name, entry)) == source)
        wires.append(f"{'.'.join(source)} -> {name}.{entry}")
    first = wires.index(min(wires))
    wires = wires[first:] + wires[:first]
    named = wires if len(wires) <= _NAMED else [*wires[:_NAMED], f"and {len(wires) - _NAMED} more"]
    return Problem(
        message="algebraic loop: each of these outputs needs the one before it within the same tick",
        key="wires",
        got=", ".join(named),
        expected="at least one block in the loop whose output does not depend on its input in the same tick",
        hint=f"put a UnitDelay into one of these wires, for example into {wires[-1]}",
        path=("wires", wires[-1]),
    )
