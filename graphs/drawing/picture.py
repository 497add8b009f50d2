"""A graph as a diagram shows it: a subgraph is one box with the ports that it exports and those that wires reach."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.names import Missing, find_any

Node = tuple[str, str]  # block and port


@dataclass(frozen=True)
class Box:
    """A subgraph seen from outside, with what a diagram asks of a block; units are filled in."""

    doc: str
    inputs: Mapping[str, Port]
    outputs: Mapping[str, Port]
    parameters: Mapping[str, Parameter]
    values: Mapping[str, Any]  # of the parameters

    def continuous(self) -> bool:
        """Never: there may be blocks of both sorts inside."""
        return False

    def unit_of(self, what: Port | Parameter) -> str:
        """The unit of a port or parameter."""
        return what.unit


class Picture(NamedTuple):
    """What is drawn: blocks and boxes, and wires and probes by block and port."""

    name: str
    rate: Fraction | None
    rates: Mapping[str, Fraction]
    blocks: Mapping[str, Block | Box]
    wires: list[tuple[Node, Node]]
    probes: list[Node]


def picture(graph: Graph) -> Picture:
    """The picture of a graph."""
    flat = flatten(graph)
    wires = [(_node(graph, wire.source), _node(graph, wire.target)) for wire in graph.wires]
    probes = sorted({_node(graph, probe.signal) for probe in graph.probes})
    reached: dict[str, set[str]] = {name: set(part.exports) for name, part in graph.subgraphs.items()}
    for name, port in (*(end for wire in wires for end in wire), *probes):
        if name in reached:
            reached[name].add(port)
    boxes = {name: _box(flat, name, ports) for name, ports in reached.items()}
    rates = {name: part.rate for name, part in graph.subgraphs.items() if part.rate is not None}
    blocks: dict[str, Block | Box] = {**graph.blocks, **boxes}
    return Picture(graph.name, graph.rate, {**graph.rates, **rates}, dict(sorted(blocks.items())), wires, probes)


def kind_of(block: Block | Box) -> str:
    """The kind of a block in words."""
    return "Graph" if isinstance(block, Box) else type(block).__name__


def _node(graph: Graph, signal: str) -> Node:
    head, _, tail = signal.partition(".")
    return (head, tail) if head in graph.subgraphs else split(signal)


def _box(flat: FlatGraph, name: str, ports: set[str]) -> Box:
    inputs, outputs = dict[str, Port](), dict[str, Port]()
    parameters, values = dict[str, Parameter](), dict[str, Any]()
    for port in sorted(ports):
        signal = inside(flat.root, f"{name}.{port}")
        known = find_any(flat, signal)
        if isinstance(known, Missing):
            continue
        block, what = known
        unit = block.unit_of(what)
        if isinstance(what, Parameter):
            parameters[port] = replace(what, name=port, unit=unit)
            values[port] = getattr(block, what.name)
        elif split(signal)[1] in block.outputs:
            outputs[port] = replace(what, name=port, unit=unit)
        else:
            inputs[port] = replace(what, name=port, unit=unit)
    part = flat.root.subgraphs[name]
    about = [part.name, part.description.strip(), f"{part.size.blocks} blocks inside"]
    return Box("\n".join(filter(None, about)), inputs, outputs, parameters, values)
