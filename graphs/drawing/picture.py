"""A graph for a diagram: a subgraph is a box with its exported and wired ports."""

import inspect
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import PurePath
from typing import Any, NamedTuple

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.arguments import Meaning
from proofmass.blocks.declaration.declare import Block, Port
from proofmass.blocks.declaration.instance import format_of, unit_of, written
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.shown_units import as_written, in_print
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside
from proofmass.graphs.model.graph import Endpoint, Graph, split
from proofmass.graphs.model.names import Missing, find_any

TAB = "\N{RIGHTWARDS ARROW}"  # of a port of an opened subgraph; in no name of a block
_SHORT = 9  # characters of a quantity


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
    path: str = ""  # in the flat graph
    rate: Fraction | None = None  # in hertz
    file: str = ""  # of a subgraph
    signals: Mapping[str, str] = field(default_factory=dict)  # of the flat graph, by output
    types: Mapping[str, str] = field(default_factory=dict)  # of outputs, in words
    written: Mapping[str, str] = field(default_factory=dict)  # quantities as written, by parameter

    def shown(self, name: str) -> str:
        """Return the number of a parameter with its unit: as written, where that is short."""
        text, unit = self.written.get(name, ""), short_unit(self.parameters[name].unit)
        return as_written(text if len(text) <= _SHORT else "", self.values[name], unit, 6)

    def in_full(self, name: str) -> str:
        """Return the number of a parameter with its unit: as it was written, however long."""
        return as_written(self.written.get(name, ""), self.values[name], short_unit(self.parameters[name].unit), 6)

    def _as_default(self, name: str) -> bool:
        """Return whether a number and its default are the same in all digits that are shown."""
        unit, default = short_unit(self.parameters[name].unit), self.parameters[name].default
        return default is not None and in_print(self.values[name], unit, 6) == in_print(default, unit, 6)

    def settings(self, driven: Collection[str]) -> Iterator[str]:
        """Yield the numbers of a block that are set to other than their defaults, with their units.

        A subgraph shows none, and a parameter that a wire drives has none.
        """
        for name, parameter in self.parameters.items():
            value = self.values[name]
            number = parameter.kind in (float, int) and value != parameter.default and not self.subgraph
            if number and name not in driven and not self._as_default(name):
                shown = self.shown(name)
                said = name in (self.kind.lower(), f"{parameter.unit}s")  # the kind or the unit says the name already
                yield shown if said else f"{name} {shown}"


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
    return picture_of(flatten(graph), graph, "")


def picture_of(flat: FlatGraph, graph: Graph, path: str) -> Picture:
    """Return the picture of a graph inside another; `path` ends in a dot, or is empty."""
    wires = [(node_of(graph, wire.source), node_of(graph, wire.target)) for wire in graph.wires]
    probes = sorted({node_of(graph, probe.signal) for probe in graph.probes})
    if path:  # probes of the whole graph that reach inside
        below = (probe.signal.removeprefix(path) for probe in flat.probes if probe.signal.startswith(path))
        probes = sorted({node_of(graph, outside(graph, signal)) for signal in below})
    reached: dict[str, set[str]] = {name: set(part.exports) for name, part in graph.subgraphs.items()}
    for name, port in (*(end for wire in wires for end in wire), *probes):
        if name in reached:
            reached[name].add(port)
    boxes = {name: box_of(flat, f"{path}{name}", block) for name, block in graph.blocks.items()}
    boxes |= {name: _subgraph(flat, graph, path, name, ports) for name, ports in reached.items()}
    rates = {name: part.rate for name, part in graph.subgraphs.items() if part.rate is not None}
    return Picture(graph.name, graph.rate, {**graph.rates, **rates}, dict(sorted(boxes.items())), wires, probes)


def node_of(graph: Graph, signal: str) -> Endpoint:
    """Return block and port of a signal, with a subgraph as the block."""
    head, _, tail = signal.partition(".")
    return (head, tail) if head in graph.subgraphs else split(signal)


def outside(graph: Graph, signal: str) -> str:
    """Return the name of a subgraph's signal where it is exported; unchanged if it is not."""
    head, _, tail = signal.partition(".")
    part = graph.subgraphs.get(head)
    if part is None:
        return signal
    tail = outside(part, tail)
    names = [name for name, inner in part.exports.items() if inner == tail]
    return f"{head}.{names[0] if names else tail}"


def box_of(flat: FlatGraph, path: str, block: Block) -> Box:
    """Return a block of the flat graph as a diagram shows it."""
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
        path=path,
        rate=None if kind.continuous() else flat.rates.get(path, flat.rate),
        signals={name: f"{path}.{name}" for name in kind.outputs},
        types={name: _type(block, port) for name, port in kind.outputs.items()},
        written={name: written(block, name) for name in kind.parameters},
    )


def _subgraph(flat: FlatGraph, graph: Graph, path: str, name: str, ports: set[str]) -> Box:
    inputs, outputs = dict[str, Port](), dict[str, Port]()
    parameters, values = dict[str, Parameter](), dict[str, Any]()
    signals, types = dict[str, str](), dict[str, str]()
    for port in sorted(ports):
        signal = inside(flat.root, f"{path}{name}.{port}")
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
            signals[port], types[port] = signal, _type(block, inner)
        else:
            inputs[port] = replace(inner, name=port, unit=unit)
    part = graph.subgraphs[name]
    own, around = part.place.file, graph.place.file
    file = PurePath(own).name if own and own != around else ""
    about = [part.name, part.description.strip(), f"{part.size.blocks} block{'s' * (part.size.blocks != 1)} inside"]
    return Box(
        "Graph",
        "\n".join(filter(None, [*about, file and f"from {file}"])),
        inputs,
        outputs,
        parameters,
        values,
        subgraph=True,
        path=f"{path}{name}",
        rate=part.rate if part.rate is not None else flat.rate,
        file=file,
        signals=signals,
        types=types,
    )


def _type(block: Block, port: Port) -> str:
    """Return the type of a signal in words."""
    if port.dtype is FixedValue:
        return f"fixed point {format_of(block, port.name)}"
    shape = f", {len(port.shape)} lengths" if len(port.shape) > 1 else ", a vector" if port.shape else ""
    return {int: "integer", bool: "true or false"}.get(port.dtype, "number") + shape
