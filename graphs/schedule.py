"""When and in which order everything happens: base rate, divisors, topological order over direct feedthrough."""

from dataclasses import dataclass
from fractions import Fraction


from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.graph import Graph, split
from proofmass.graphs.rates import base_rate

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
    import networkx

    drivers = {split(wire.target): split(wire.source) for wire in graph.wires}  # type: ignore[union-attr]
    base = base_rate([block_rate(graph, name) for name, block in graph.blocks.items() if not block.continuous()])
    if all(block.continuous() for block in graph.blocks.values()) and graph.rate is not None:
        base = Fraction(graph.rate)
    divisors = {
        name: 1 if block.continuous() else int(base / block_rate(graph, name)) for name, block in graph.blocks.items()
    }
    needs: networkx.DiGraph[Node] = networkx.DiGraph()
    for name, block in graph.blocks.items():
        driven = [p for p in block.parameters if (name, p) in drivers]
        if driven:
            needs.add_edges_from((drivers[name, p], (name, "")) for p in driven)
        for port in block.outputs:
            needs.add_node((name, port))
            needs.add_edges_from((drivers[name, i], (name, port)) for i in block.feedthrough(port) if (name, i) in drivers)
            if driven:
                needs.add_edge((name, ""), (name, port))
    try:
        order = tuple(networkx.lexicographical_topological_sort(needs))
    except networkx.NetworkXUnfeasible:
        raise ModelError([_loop(graph, networkx.find_cycle(needs), drivers)]) from None
    return Schedule(base, divisors, order, drivers)


def block_rate(graph: Graph, name: str) -> Fraction:
    """The rate of a discrete block: its own or the graph's."""
    return Fraction(graph.rates.get(name, graph.rate))  # type: ignore[arg-type]


def _loop(graph: Graph, edges: list[tuple[Node, Node]], drivers: dict[Node, Node]) -> Problem:
    """The loop named port by port, from its alphabetically first port on."""
    first = min(range(len(edges)), key=lambda i: edges[i][0])
    edges = edges[first:] + edges[:first]
    steps = []
    for source, target in edges:
        name, port = target
        block = graph.blocks[name]
        if port == "":
            entry = next(p for p in block.parameters if drivers.get((name, p)) == source)
        elif source == (name, ""):
            continue
        else:
            entry = next(i for i in block.feedthrough(port) if drivers.get((name, i)) == source)
        steps.append(f"{'.'.join(source)} -> {name}.{entry}")
    return Problem(
        message="algebraic loop: each of these outputs needs the next within the same tick",
        key="wires",
        got=", ".join(steps),
        expected="at least one block in the loop whose output does not depend on its input in the same tick",
        hint=f"put a UnitDelay into one of these wires, for example into {steps[-1]}",
        path=("wires",),
    )


