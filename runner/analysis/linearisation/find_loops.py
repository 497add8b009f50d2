"""Control loops in the wires of a graph, and the outputs at which each can be opened."""

import itertools
import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from proofmass.graphs.model.digraph import loops
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.plan.planned import Plan

_TRIED = 10_000  # sets of outputs

_Wiring = Mapping[Endpoint, Collection[Endpoint]]  # outputs that each reaches through one block


@dataclass(frozen=True)
class LoopGroup:
    """Outputs in loops that share wires, and those at which all of these loops can be opened, best first.

    Where no output opens them all, `together` is a smallest set of outputs that do, one for each
    loop to analyse. Loops among continuous blocks, as of a plant with feedback of its own, are a
    group too, and stay closed in others.
    """

    ports: tuple[str, ...]
    open_at: tuple[str, ...]
    together: tuple[str, ...] = ()


def find_loops(plan: Plan) -> list[LoopGroup]:
    """Return all loops, grouped by shared wires."""
    wiring = _port_graph(plan)
    groups = (group for part in loops(wiring) for group in _groups(plan, _within(wiring, part)))
    return sorted(groups, key=lambda loop: loop.ports)


def _groups(plan: Plan, part: _Wiring) -> Iterator[LoopGroup]:
    """Yield the loops of outputs that all reach each other, and apart those that go through none that can be cut."""
    wires = sorted((node for node in part if _can_be_cut(plan, part, node)), key=lambda n: (-plan.stride(n), n))
    apart = loops(_within(part, part.keys() - wires)) if wires else []
    for inner in apart:
        yield from _groups(plan, _within(part, inner))
    one = {node: min(inner) for inner in apart for node in inner}
    about: dict[Endpoint, list[Endpoint]] = {}
    for node, others in part.items():
        mine = one.get(node, node)
        about.setdefault(mine, []).extend(one.get(n, n) for n in others if node not in one or one.get(n) != mine)
    cuts = [node for node in wires if _opens(about, {node})]
    together = [] if cuts else _fewest(about, wires)
    yield LoopGroup(_texts(sorted(part)), _texts(cuts), _texts(together))


def _within(wiring: _Wiring, part: Collection[Endpoint]) -> _Wiring:
    return {node: [after for after in wiring.get(node, ()) if after in part] for node in part}


def _port_graph(plan: Plan) -> dict[Endpoint, list[Endpoint]]:
    """Return the outputs that each output reaches through one block, at once or later."""
    wiring: dict[Endpoint, list[Endpoint]] = {}
    for (name, entry), source in plan.schedule.drivers.items():
        kind = type(plan.blocks[name])
        later = kind.state_class() is not None or bool(kind.buffers) or entry in kind.parameters
        ports = [(name, port) for port in kind.outputs if later or entry in kind.feedthrough(port)]
        wiring.setdefault(source, []).extend(ports)
    return wiring


def _can_be_cut(plan: Plan, part: _Wiring, node: Endpoint) -> bool:
    """Return whether a loop can be opened at an output: one number, sampled or held.

    It need not be sampled if the whole loop lies among continuous blocks.
    """
    if not type(plan.blocks[node[0]]).outputs[node[1]].is_number:
        return False
    groups = [set(solver.group.nodes) for solver in plan.solvers if node in solver.group.nodes]
    return not groups or set(part) <= groups[0]


def _opens(part: _Wiring, cuts: Collection[Endpoint]) -> bool:
    """Return whether cutting these outputs leaves no loop."""
    return not loops(_within(part, part.keys() - cuts))


def _fewest(part: _Wiring, wires: list[Endpoint]) -> list[Endpoint]:
    """Return the first of the smallest sets of outputs whose cuts leave no loop; none if there is no such set.

    Beyond `_TRIED` sets, outputs are taken out of the set of all while the rest leaves no loop.
    """
    for size in range(2, len(wires) + 1):
        if math.comb(len(wires), size) > _TRIED:
            break
        found = next((cuts for cuts in itertools.combinations(wires, size) if _opens(part, cuts)), None)
        if found:
            return list(found)
    fewer = list(wires)
    if not _opens(part, fewer):
        return []
    for wire in reversed(wires):
        rest = [cut for cut in fewer if cut != wire]
        fewer = rest if _opens(part, rest) else fewer
    return fewer


def _texts(nodes: list[Endpoint]) -> tuple[str, ...]:
    return tuple(".".join(node) for node in nodes)
