"""Groups of wired continuous blocks, assembled and stepped exactly for inputs held over the tick."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import networkx

from proofmass.blocks.problem import ModelError, Problem
from proofmass.graphs.graph import Graph
from proofmass.graphs.schedule import Node, Schedule
from proofmass.runner.exact_hold import Matrix, hold


@dataclass(frozen=True)
class Group:
    """Continuous blocks that are wired to each other: x[n+1] = transition x[n] + entry u[n].

    The states are those of `blocks`, field by field; `inputs` are the outputs of other blocks that act on the group.
    """

    blocks: tuple[str, ...]
    states: tuple[tuple[str, str], ...]  # block and field
    inputs: tuple[Node, ...]
    transition: Matrix
    entry: Matrix


def find_groups(graph: Graph, schedule: Schedule, constants: Mapping[str, Any], period: float) -> tuple[Group, ...]:
    """All continuous groups of a graph, in alphabetical order."""
    wired: networkx.Graph[str] = networkx.Graph()
    continuous = {name for name, block in graph.blocks.items() if block.continuous()}
    wired.add_nodes_from(continuous)
    for (target, _), (source, _) in schedule.drivers.items():
        if source in continuous and target in continuous:
            wired.add_edge(source, target)
    members = sorted(tuple(sorted(part, key=_last_name)) for part in networkx.connected_components(wired))
    return tuple(_assemble(graph, schedule, constants, blocks, period) for blocks in members)


def _assemble(
    graph: Graph, schedule: Schedule, constants: Mapping[str, Any], blocks: tuple[str, ...], period: float
) -> Group:
    states = tuple((name, field) for name in blocks for field in _state_class(graph, name)._fields)
    drivers = (schedule.drivers.get((name, i)) for name in blocks for i in graph.blocks[name].inputs)
    outside = {node for node in drivers if node is not None and node[0] not in blocks}
    inputs = tuple(sorted(outside, key=lambda node: (_last_name(node[0]), node[1])))

    def column(values: dict[Node, float]) -> list[float]:
        return _derivatives(graph, schedule, constants, blocks, values)

    _refuse_nonlinear(graph, blocks, [*states, *inputs], column)
    a = [column({state: 1.0}) for state in states]
    b = [column({node: 1.0}) for node in inputs]
    transition, entry = hold(_transposed(a), _transposed(b) if b else [[] for _ in states], period)
    return Group(blocks, states, inputs, transition, entry)


def _refuse_nonlinear(
    graph: Graph, blocks: tuple[str, ...], nodes: list[Node], rates_at: Callable[[dict[Node, float]], list[float]]
) -> None:
    """Only what is linear can be stepped by matrices: f(0) = 0, f(2 z) = 2 f(z), f(-z) = -f(z), exact in floats."""
    point = {node: 1.0 + 0.375 * number for number, node in enumerate(nodes)}
    once = rates_at(point)
    linear = all(graph.blocks[name].linear for name in blocks) and not any(rates_at({}))
    for factor in (2.0, -1.0):
        moved = rates_at({node: factor * value for node, value in point.items()})
        linear = linear and moved == [factor * rate for rate in once]
    if not linear:
        hint = "build it from linear blocks, or declare it as a discrete block with an update"
        message = f"the derivatives of {', '.join(blocks)} are not linear in states and inputs, as they must be"
        problem = Problem(message=message, key=f"blocks.{blocks[0]}", hint=hint, path=("blocks", blocks[0]))
        raise ModelError([graph.placed(problem)])


def _derivatives(
    graph: Graph, schedule: Schedule, constants: Mapping[str, Any], blocks: tuple[str, ...], values: dict[Node, float]
) -> list[float]:
    """Derivatives of all states of a group for given states and inputs; whatever is not given is zero."""
    signals = dict(values)
    x = {}
    for name in blocks:
        state = _state_class(graph, name)
        x[name] = state(*(values.get((name, field), 0.0) for field in state._fields))

    def argument(name: str, wanted: str) -> Any:
        if wanted == "x":
            return x[name]
        driver = schedule.drivers.get((name, wanted))
        return graph.blocks[name].inputs[wanted].default if driver is None else signals.get(driver, 0.0)

    # A state and an output may bear the same name, so outputs are kept apart under the key of their wire.
    signals = {node: value for node, value in values.items() if node[0] not in blocks}
    for name, port in schedule.order:
        if name in blocks:
            output = graph.blocks[name].output_functions[port]
            signals[name, port] = output.function(constants[name], *(argument(name, a) for a in output.arguments))
    rates: list[float] = []
    for name in blocks:
        derivative = graph.blocks[name].functions["derivative"]
        rates += derivative.function(constants[name], *(argument(name, a) for a in derivative.arguments))
    return rates


def _last_name(path: str) -> tuple[str, str]:
    """What the terms of a sum are ordered by, so that its bits do not depend on the subgraphs that blocks lie in."""
    return path.rpartition(".")[2], path


def _state_class(graph: Graph, name: str) -> Any:
    return graph.blocks[name].state_class()


def _transposed(columns: Matrix) -> Matrix:
    return [list(row) for row in zip(*columns, strict=True)]
