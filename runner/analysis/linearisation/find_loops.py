"""Control loops in the wires of a graph, and the outputs at which each can be opened."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from proofmass.graphs.model.digraph import loops
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
    for part in loops(wiring):
        inner = {node: [after for after in wiring.get(node, ()) if after in part] for node in part}
        cuts = sorted((node for node in part if _opens(plan, inner, node)), key=lambda n: (-plan.stride(n), n))
        groups.append(LoopGroup(_texts(sorted(part)), _texts(cuts)))
    return sorted(groups, key=lambda loop: loop.ports)


def _port_graph(plan: Plan) -> dict[Endpoint, list[Endpoint]]:
    """Return the outputs that each output reaches through one block, at once or later."""
    wiring: dict[Endpoint, list[Endpoint]] = {}
    for (name, entry), source in plan.schedule.drivers.items():
        kind = type(plan.blocks[name])
        later = kind.state_class() is not None or bool(kind.buffers) or entry in kind.parameters
        ports = [(name, port) for port in kind.outputs if later or entry in kind.feedthrough(port)]
        wiring.setdefault(source, []).extend(ports)
    return wiring


def _opens(plan: Plan, part: Mapping[Endpoint, Collection[Endpoint]], node: Endpoint) -> bool:
    """Return whether cutting this output, which must be one number, leaves no loop.

    It must be sampled or held, unless the whole loop lies among continuous blocks.
    """
    port = type(plan.blocks[node[0]]).outputs[node[1]]
    if port.shape or port.dtype is bool:
        return False
    groups = [set(solver.group.nodes) for solver in plan.solvers if node in solver.group.nodes]
    if groups and not set(part) <= groups[0]:
        return False
    return not loops({one: [after for after in others if after != node] for one, others in part.items() if one != node})


def _texts(nodes: list[Endpoint]) -> tuple[str, ...]:
    return tuple(".".join(node) for node in nodes)
