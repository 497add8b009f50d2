"""Control loops in the wires of a graph, and the outputs at which each can be opened."""

from dataclasses import dataclass
from typing import Any

import networkx

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan


@dataclass(frozen=True)
class LoopGroup:
    """Outputs in loops that share wires, and those at which all of these loops can be opened, best first."""

    ports: tuple[str, ...]
    open_at: tuple[str, ...]


def find_loops(plan: Plan) -> list[LoopGroup]:
    """Return all loops, grouped by shared wires."""
    wiring = _port_graph(plan)
    groups = []
    for part in networkx.strongly_connected_components(wiring):
        inner = wiring.subgraph(part)
        if len(part) > 1 or networkx.number_of_selfloops(inner):
            cuts = sorted((node for node in part if _opens(plan, inner, node)), key=lambda n: (-plan.stride(n), n))
            groups.append(LoopGroup(_texts(sorted(part)), _texts(cuts)))
    return sorted(groups, key=lambda loop: loop.ports)


def _port_graph(plan: Plan) -> Any:
    """Return a graph with an edge from each output to those that it reaches through one block, at once or later."""
    wiring: Any = networkx.DiGraph()
    for (name, entry), source in plan.schedule.drivers.items():
        kind = type(plan.blocks[name])
        later = kind.state_class() is not None or bool(kind.buffers) or entry in kind.parameters
        wiring.add_edges_from(
            (source, (name, port)) for port in kind.outputs if later or entry in kind.feedthrough(port)
        )
    return wiring


def _opens(plan: Plan, part: Any, node: Endpoint) -> bool:
    """Return whether cutting this output, which must be one number, leaves no loop.

    It must be sampled or held, unless the whole loop lies among continuous blocks.
    """
    port = type(plan.blocks[node[0]]).outputs[node[1]]
    if port.shape or port.dtype is bool:
        return False
    groups = [set(solver.group.nodes) for solver in plan.solvers if node in solver.group.nodes]
    if groups and not set(part) <= groups[0]:
        return False
    rest = part.subgraph(set(part) - {node})
    return bool(networkx.is_directed_acyclic_graph(rest))


def _texts(nodes: list[Endpoint]) -> tuple[str, ...]:
    return tuple(".".join(node) for node in nodes)
