"""Control loops in the wires of a graph, and the outputs at which each can be opened."""

from dataclasses import dataclass
from typing import Any

import networkx

from proofmass.graphs.checks.schedule import Node
from proofmass.runner.plan.planned import Plan


@dataclass(frozen=True)
class Found:
    """Outputs that lie in loops with each other, and those of them that all of these loops go through, best first."""

    ports: tuple[str, ...]
    open_at: tuple[str, ...]


def find_loops(plan: Plan) -> list[Found]:
    """All loops, those that share wires together."""
    wiring = _port_graph(plan)
    found = []
    for part in networkx.strongly_connected_components(wiring):
        inner = wiring.subgraph(part)
        if len(part) > 1 or networkx.number_of_selfloops(inner):
            cuts = sorted((node for node in part if _opens(plan, inner, node)), key=lambda n: (-plan.stride(n), n))
            found.append(Found(_texts(sorted(part)), _texts(cuts)))
    return sorted(found, key=lambda loop: loop.ports)


def _port_graph(plan: Plan) -> Any:
    """An edge from each output to the outputs that its value reaches through one block, at once or later."""
    wiring: Any = networkx.DiGraph()
    for (name, entry), source in plan.schedule.drivers.items():
        kind = type(plan.blocks[name])
        later = kind.state_class() is not None or bool(kind.buffers) or entry in kind.parameters
        wiring.add_edges_from(
            (source, (name, port)) for port in kind.outputs if later or entry in kind.feedthrough(port)
        )
    return wiring


def _opens(plan: Plan, part: Any, node: Node) -> bool:
    """Whether no loop is left without the output, which must be one number.

    It must be sampled or held, or all of the loop lie among continuous blocks.
    """
    port = type(plan.blocks[node[0]]).outputs[node[1]]
    if port.shape or port.dtype is bool:
        return False
    groups = [set(solver.group.nodes) for solver in plan.solvers if node in solver.group.nodes]
    if groups and not set(part) <= groups[0]:
        return False
    rest = part.subgraph(set(part) - {node})
    return bool(networkx.is_directed_acyclic_graph(rest))


def _texts(nodes: list[Node]) -> tuple[str, ...]:
    return tuple(".".join(node) for node in nodes)
