"""A graph for a diagram: a subgraph is one box with the ports that it exports and those that wires reach."""

import inspect
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, NamedTuple

from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import Endpoint, Graph, split
from proofmass.graphs.model.names import Missing, find_any


@dataclass(frozen=True)
class Box:
    """A block, or a subgraph seen from outside, as a diagram shows it; units are filled in."""

    kind: str  # in words
    doc: str
    inputs: Mapping[str, Port]
    outputs: Mapping[str, Port]
    parameters: Mapping[str, Parameter]
    values: Mapping[str, Any]  # of the parameters
    continuous: bool = False  # never a subgraph: there may be blocks of both sorts inside
    noise: bool = False
    subgraph: bool = False

    def setting(self, driven: Collection[str]) -> str:
        """Return the first number of a block that is set to other than its default, with its unit; empty without one.

        A subgraph shows none, and a parameter that a wire drives has none.
        """
        for name, parameter in self.parameters.items():
            value = self.values[name]
            number = parameter.kind in (float, int) and value != parameter.default and not self.subgraph
            if number and name not in driven:
                shown = in_print(value, short_unit(parameter.unit), 6)
                said = name in (self.kind.lower(), f"{parameter.unit}s")  # already, by the kind or the unit
                return shown if said else f"{name} {shown}"
        return ""


class Picture(NamedTuple):
    """Contents of a diagram: blocks and boxes, wires and probes by block and port."""

    name: str
    rate: Fraction | None
    rates: Mapping[str, Fraction]
    blocks: Mapping[str, Box]
    wires: list[tuple[Endpoint, Endpoint]]
    probes: list[Endpoint]


def picture(graph: Graph) -> Picture:
    """Return the picture of a graph."""
    flat = flatten(graph)
    wires = [(_node(graph, wire.source), _node(graph, wire.target)) for wire in graph.wires]
    probes = sorted({_node(graph, probe.signal) for probe in graph.probes})
    reached: dict[str, set[str]] = {name: set(part.exports) for name, part in graph.subgraphs.items()}
    for name, port in (*(end for wire in wires for end in wire), *probes):
        if name in reached:
            reached[name].add(port)
    boxes = {name: _block(block) for name, block in graph.blocks.items()}
    boxes |= {name: _subgraph(flat, name, ports) for name, ports in reached.items()}
    rates = {name: part.rate for name, part in graph.subgraphs.items() if part.rate is not None}
    return Picture(graph.name, graph.rate, {**graph.rates, **rates}, dict(sorted(boxes.items())), wires, probes)


def _node(graph: Graph, signal: str) -> Endpoint:
    head, _, tail = signal.partition(".")
    return (head, tail) if head in graph.subgraphs else split(signal)


def _block(block: Block) -> Box:
    kind = type(block)
    return Box(
        kind.__name__,
        inspect.getdoc(kind) or "",
        {name: replace(port, unit=unit_of(block, port)) for name, port in kind.inputs.items()},
        {name: replace(port, unit=unit_of(block, port)) for name, port in kind.outputs.items()},
        {name: replace(parameter, unit=unit_of(block, parameter)) for name, parameter in kind.parameters.items()},
        {name: getattr(block, name) for name in kind.parameters},
        continuous=kind.continuous(),
        noise=any(Meaning.DEVIATE in behaviour.meanings for behaviour in kind.output_functions.values()),
    )


def _subgraph(flat: FlatGraph, name: str, ports: set[str]) -> Box:
    inputs, outputs = dict[str, Port](), dict[str, Port]()
    parameters, values = dict[str, Parameter](), dict[str, Any]()
    for port in sorted(ports):
        signal = inside(flat.root, f"{name}.{port}")
        known = find_any(flat, signal)
        if isinstance(known, Missing):
            continue
        block, inner = known
        unit = unit_of(block, inner)
        if isinstance(inner, Parameter):
            parameters[port] = replace(inner, name=port, unit=unit)
            values[port] = getattr(block, inner.name)
        elif split(signal)[1] in type(block).outputs:
            outputs[port] = replace(inner, name=port, unit=unit)
        else:
            inputs[port] = replace(inner, name=port, unit=unit)
    part = flat.root.subgraphs[name]
    about = [part.name, part.description.strip(), f"{part.size.blocks} block{'s' * (part.size.blocks != 1)} inside"]
    return Box("Graph", "\n".join(filter(None, about)), inputs, outputs, parameters, values, subgraph=True)
