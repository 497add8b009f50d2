"""Tabs of an opened subgraph: one for each port that wires outside reach."""

from dataclasses import replace

from proofmass.blocks.declaration.declare import Port
from proofmass.graphs.drawing.picture import TAB, Box, Picture, node_of, outside
from proofmass.graphs.model.flatten import FlatGraph, inside
from proofmass.graphs.model.graph import Endpoint, Graph

_PORT = "value"


def with_tabs(flat: FlatGraph, graph: Graph, picture: Picture, path: str) -> Picture:
    """Return the picture of a subgraph with its tabs; `path` ends in a dot."""
    known = {inside(flat.root, path + name): name for name in graph.exports}
    blocks, wires = dict(picture.blocks), list(picture.wires)
    for wire in flat.wires:
        within = wire.source.startswith(path), wire.target.startswith(path)
        if within[0] == within[1]:
            continue
        signal = wire.source if within[0] else wire.target
        rest = signal.removeprefix(path)
        node = node_of(graph, outside(graph, rest))
        port = _port(picture, node)
        if port is None:
            continue
        label = known.get(signal, rest)
        if within[0]:
            name = f"{label}{TAB}"
            blocks[name] = Box("", f"{label}: {port.doc}", {_PORT: port}, {}, {}, {})
            wires.append((node, (name, _PORT)))
        else:
            name = f"{TAB}{label}"
            signals, types = {_PORT: wire.source}, {_PORT: "number"}
            blocks[name] = Box("", f"{label}: {port.doc}", {}, {_PORT: port}, {}, {}, signals=signals, types=types)
            wires.append(((name, _PORT), node))
    return picture._replace(blocks=dict(sorted(blocks.items())), wires=sorted(set(wires)))


def _port(picture: Picture, node: Endpoint) -> Port | None:
    """Return a port, or a parameter as one; None for what does not exist."""
    box = picture.blocks.get(node[0])
    if box is None:
        return None
    port = box.inputs.get(node[1]) or box.outputs.get(node[1])
    if port is not None:
        return replace(port, name=_PORT)
    parameter = box.parameters.get(node[1])
    return Port(_PORT, parameter.unit, parameter.doc, float) if parameter else None
