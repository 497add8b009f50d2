"""A block diagram as plain data: what is drawn, and where."""

from collections.abc import Collection, Iterator
from typing import Any

from proofmass.graphs.drawing.diagram import Drawing, corner
from proofmass.graphs.drawing.links import probed
from proofmass.graphs.drawing.looks import inner_place
from proofmass.graphs.drawing.overlays import Overlays
from proofmass.graphs.drawing.picture import TAB
from proofmass.graphs.model.flatten import flatten
from proofmass.graphs.model.graph import Graph

Data = dict[str, Any]


def diagram_data(graph: Graph, unfolded: Collection[str] = ()) -> Data:
    """Return blocks, wires and probes of the diagram that `svg` draws; places are in its pixels,
    from the upper left.

    `unfolded` names subgraphs by their paths, as for `svg`. What is inside has the whole path as
    its name.
    """
    flat = flatten(graph)
    drawing = Drawing(flat, graph, "", frozenset(unfolded), Overlays(flat))
    data: Data = {"blocks": [], "wires": [], "probes": []}
    for path, one, x, y in _drawings(drawing, "", *corner(graph)):
        data["blocks"] += _blocks(path, one, x, y)
        data["wires"] += _wires(path, one, x, y)
        data["probes"] += [f"{path}{name}.{port}" for name, port in probed(one.picture)]
    rate = None if graph.rate is None else float(graph.rate)
    return {"graph": graph.name, "rate_hz": rate, **data}


def _drawings(drawing: Drawing, path: str, x: int, y: int) -> Iterator[tuple[str, Drawing, int, int]]:
    """Yield a drawing and those inside it, each with its path and its upper left corner."""
    yield path, drawing, x, y
    for name, inner in drawing.inner.items():
        spot = drawing.layout.spots[name]
        right, down = inner_place(drawing.looks[name], spot.mirrored)
        yield from _drawings(inner, f"{path}{name}.", x + spot.x + right, y + spot.y + down)


def _blocks(path: str, drawing: Drawing, x: int, y: int) -> Iterator[Data]:
    for name, spot in drawing.layout.spots.items():
        box, shape = drawing.picture.blocks[name], drawing.looks[name].shape
        if not box.kind:
            continue  # a port of the subgraph around
        into = (link for link in drawing.links if link.target == name)
        sources = {link.port: _end(path, drawing, link.source, link.output) for link in into}
        yield {
            "name": f"{path}{name}",
            "kind": box.kind,
            "subgraph": box.subgraph,
            **({"file": box.file} if box.file else {}),
            "continuous": box.continuous,
            "rate_hz": None if box.rate is None else float(box.rate),
            "x": x + spot.x,
            "y": y + spot.y,
            "width": shape.width,
            "height": shape.height,
            "inputs": {port: {"unit": of.unit, "from": sources.get(port)} for port, of in box.inputs.items()},
            "outputs": {port: {"unit": of.unit, "type": box.types[port]} for port, of in box.outputs.items()},
            "driven": {name: source for name, source in sources.items() if name not in box.inputs},
            "settings": list(box.settings(sources)),
        }


def _wires(path: str, drawing: Drawing, x: int, y: int) -> Iterator[Data]:
    for link in drawing.links:
        box = drawing.picture.blocks[link.source]
        ends = drawing.ends.get(link)
        points = drawing.paths[link] if ends is None else (*ends.source, *ends.reader)
        yield {
            "from": _end(path, drawing, link.source, link.output),
            "to": _end(path, drawing, link.target, link.port),
            "signal": box.signals[link.output],
            "unit": box.outputs[link.output].unit,
            "type": box.types[link.output],
            "drives_parameter": link.driven,
            "points": [[x + right, y + down] for right, down in points],
            **({} if ends is None else {"named": drawing.wired.net_label(link)}),
        }


def _end(path: str, drawing: Drawing, name: str, port: str) -> str:
    """Return the end of a wire: a port of a block, or one of the subgraph around, a tab."""
    return f"{path}{name}.{port}" if drawing.picture.blocks[name].kind else f"{path}{name.strip(TAB)}"
