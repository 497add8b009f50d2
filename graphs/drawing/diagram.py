"""Block diagrams of a graph: SVG to look at, Mermaid and DOT text for documents and other tools.

The pictures depend on the graph alone, never on the order in which blocks and wires were declared. Wires whose ends do
not exist are left out: `check` reports them.
"""

import re
from collections.abc import Iterator, Mapping
from html import escape

from proofmass.blocks.declaration.declare import Port
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.shown_units import in_print, pretty
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.layout import Layout, Shape, Spot, lay_out
from proofmass.graphs.drawing.picture import Picture, picture
from proofmass.graphs.drawing.routing import Point
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import write_rate

_HEAD, _SETTING, _ROW, _FOOT = 40, 20, 20, 20  # of a block: name and kind, setting, one port, driven parameters
_MARGIN = 20
_ILLEGAL = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # in XML

# Okabe and Ito's colours, which differ for every kind of colour vision; shape and dashes say the same again.
_STYLE = """
.proofmass{--paper:#fff;--ink:#1a2530;--soft:#5b6b7a;--face:#f5f7f9;--flow:#e4f1fb;--wire:#3d4f60;--drive:#0072b2;--look:#c04a00}
@media screen and (prefers-color-scheme:dark){.proofmass{--paper:#12181e;--ink:#e8eef3;--soft:#a3b1be;--face:#1d262f;\
--flow:#12324a;--wire:#a9bac9;--drive:#56b4e9;--look:#f0a04b}}
.proofmass text{font:11px "Helvetica Neue",Arial,"DejaVu Sans",sans-serif;fill:#1a2530;fill:var(--ink)}
.proofmass .name{font-weight:bold;font-size:13px}
.proofmass .title{font-weight:bold;font-size:15px}
.proofmass .soft{fill:#5b6b7a;fill:var(--soft)}
.proofmass .small{font-size:10px}
.proofmass .rate{fill:#0072b2;fill:var(--drive);font-weight:bold}
.proofmass .paper{fill:#fff;fill:var(--paper)}
.proofmass .box{fill:#f5f7f9;fill:var(--face);stroke:#1a2530;stroke:var(--ink);stroke-width:1.4}
.proofmass .continuous .box{fill:#e4f1fb;fill:var(--flow)}
.proofmass .line{fill:none;stroke:#3d4f60;stroke:var(--wire);stroke-width:1.5}
.proofmass .reach{fill:none;stroke:#0072b2;stroke:var(--drive);stroke-width:9;stroke-opacity:0}
.proofmass .tip,.proofmass .dot{fill:#3d4f60;fill:var(--wire)}
.proofmass .driven .line{stroke:#0072b2;stroke:var(--drive);stroke-dasharray:5 3}
.proofmass .driven .tip{fill:#0072b2;fill:var(--drive)}
.proofmass .probe{fill:#c04a00;fill:var(--look);stroke:#c04a00;stroke:var(--look);stroke-width:1.4}
.proofmass .wire:hover .reach{stroke-opacity:.35}
"""


def svg(graph: Graph) -> str:
    """Return the block diagram as SVG: signals from left to right, return paths below, details as tooltips."""
    return _svg(picture(graph))


def _svg(graph: Picture) -> str:
    links = _links(graph)
    wired = _Wired(graph, links)
    shapes = {name: _shape(graph, name, wired) for name in graph.blocks}
    layout = lay_out(shapes, links)
    legend = list(_legend(graph, links))
    top = _MARGIN + (30 if graph.name else 0)
    width = max(layout.width, _width(graph.name, 15), *(end for _, _, end in legend), 160) + 2 * _MARGIN
    height = top + layout.height + _MARGIN + (30 if legend else 0)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="proofmass" width="{width}" height="{height}" '
        f'viewBox="0 0 {width} {height}" role="img" aria-label="{_text(f"Block diagram {graph.name}".strip())}">',
        f"<style>{_STYLE}</style>",
        f'<rect class="paper" width="{width}" height="{height}"/>',
    ]
    if graph.name:
        rate = f' <tspan class="soft small">{write_rate(graph.rate)}</tspan>' if graph.rate is not None else ""
        lines.append(f'<text class="title" x="{_MARGIN}" y="{_MARGIN + 10}">{_text(graph.name)}{rate}</text>')
    if not graph.blocks:
        lines.append(f'<text class="soft" x="{_MARGIN}" y="{top + 10}">no blocks</text>')
    lines.append(f'<g transform="translate({_MARGIN} {top})">')
    drawn: dict[Point, list[tuple[Point, ...]]] = {}  # by start
    for link in sorted(links, key=lambda link: (link.driven, link)):
        path = layout.paths[link]
        others = drawn.setdefault(path[0], [])
        lines += _wire(graph, link, path[max((_shared(path, other) for other in others), default=0) :], layout)
        others.append(path)
    lines += [f'<circle class="dot" cx="{x}" cy="{y}" r="3.2"/>' for x, y in sorted(layout.dots)]
    for name, spot in layout.spots.items():
        lines += _block(graph, name, shapes[name], spot, wired)
    lines.append("</g>")
    lines += [f'<g transform="translate({_MARGIN + x} {height - _MARGIN})">{mark}</g>' for x, mark, _ in legend]
    return "\n".join([*lines, "</svg>", ""])


def mermaid(graph: Graph) -> str:
    """Return the wiring as a Mermaid flowchart, which many document tools draw."""
    return _mermaid(picture(graph))


def _mermaid(graph: Picture) -> str:
    def node(name: str) -> str:
        return "block_" + name.replace(".", "__")

    def quoted(*lines: str) -> str:
        return '"' + "<br/>".join(escape(line).replace("&quot;", "#quot;") for line in lines if line) + '"'

    out = ["flowchart LR"]
    for name, block in graph.blocks.items():
        text = quoted(name, block.kind, _rate(graph, name))
        shape = f"[[{text}]]" if block.subgraph else f"({text})" if block.continuous else f"[{text}]"
        out.append(f"    {node(name)}{shape}")
    for link in _links(graph):
        arrow = "-.->" if link.driven else "-->"
        out.append(f"    {node(link.source)} {arrow}|{quoted(_edge(graph, link))}| {node(link.target)}")
    for index, (name, port) in enumerate(_probed(graph)):
        out += [f"    probe_{index}>{quoted(f'{name}.{port}')}]", f"    {node(name)} --o probe_{index}"]
    return "\n".join(out) + "\n"


def dot(graph: Graph) -> str:
    """Return the wiring as DOT text for Graphviz."""
    return _dot(picture(graph))


def _dot(graph: Picture) -> str:

    def quoted(*lines: str) -> str:
        return '"' + "\\n".join(_plain(x).replace("\\", "\\\\").replace('"', '\\"') for x in lines if x) + '"'

    out = [f"digraph {quoted(graph.name)} {{", "    rankdir=LR", "    node [shape=box]"]
    for name, block in graph.blocks.items():
        style = ", peripheries=2" if block.subgraph else ", style=rounded" if block.continuous else ""
        out.append(f"    {quoted(name)} [label={quoted(name, block.kind, _rate(graph, name))}{style}]")
    for link in _links(graph):
        style = ", style=dashed" if link.driven else ""
        out.append(f"    {quoted(link.source)} -> {quoted(link.target)} [label={quoted(_edge(graph, link))}{style}]")
    for name, port in _probed(graph):
        signal = quoted(f"{name}.{port}")
        out += [f"    {signal} [shape=cds]", f"    {quoted(name)} -> {signal} [arrowhead=none]"]
    return "\n".join([*out, "}", ""])


# -- what is drawn -----------------------------------------------------------------------------------------------


def _links(graph: Picture) -> list[Link]:
    """Return the wires whose ends exist, each once."""
    links = set()
    for (source, output), (target, port) in graph.wires:
        if source in graph.blocks and target in graph.blocks and output in graph.blocks[source].outputs:
            block = graph.blocks[target]
            if port in block.inputs or port in block.parameters:
                links.add(Link(source, output, target, port, port not in block.inputs))
    return sorted(links)


class _Wired:
    """Return by block the wired ports and parameters with their sources, the wired outputs and the probed ones."""

    def __init__(self, graph: Picture, links: list[Link]) -> None:
        self.into: dict[str, dict[str, str]] = {name: {} for name in graph.blocks}
        self.probed: dict[str, set[str]] = {name: set() for name in graph.blocks}
        self.used: dict[str, set[str]] = {name: set() for name in graph.blocks}
        for link in links:
            self.into[link.target][link.port] = f"{link.source}.{link.output}"
            self.used[link.source].add(link.output)
        for name, port in _probed(graph):
            self.probed[name].add(port)
            self.used[name].add(port)


def _probed(graph: Picture) -> list[tuple[str, str]]:
    return [(name, port) for name, port in graph.probes if name in graph.blocks and port in graph.blocks[name].outputs]


def _rate(graph: Picture, name: str) -> str:
    """Return the rate of a block if it differs from the graph's."""
    rate = graph.rates.get(name)
    return "" if rate is None or rate == graph.rate else write_rate(rate)


def _unit(what: Port | Parameter) -> str:
    """Return the unit as written by hand; empty for a plain number."""
    unit = pretty(short_unit(what.unit))
    return "" if unit == "1" else unit


def _edge(graph: Picture, link: Link) -> str:
    block = graph.blocks[link.source]
    unit = _unit(block.outputs[link.output])
    return f"{link.output} → {link.port}" + (f" [{unit}]" if unit else "")


def _shape(graph: Picture, name: str, wired: _Wired) -> Shape:
    block = graph.blocks[name]
    into, probed, used = wired.into[name], wired.probed[name], wired.used[name]
    needed = [port for port, declared in block.inputs.items() if declared.default is None or port in into]
    setting = block.setting(into)
    head = _HEAD + (_SETTING if setting else 0)
    inputs = {port: head + 10 + _ROW * i for i, port in enumerate(needed)}
    outputs = {port: head + 10 + _ROW * i for i, port in enumerate(block.outputs)}
    driven: dict[str, int] = {}
    across = 0
    for parameter in sorted(port for port in into if port not in block.inputs):
        half = -(-_width(parameter, 11) // 20) * 10  # a multiple of ten
        driven[parameter] = across + half + 10
        across += 2 * half + 10
    sides = max((_width(port, 11) for port in inputs), default=0) + max(
        (_width(port, 11) for port in outputs), default=0
    )
    kind = block.kind + "  " * bool(_rate(graph, name)) + _rate(graph, name)
    words = max(_width(name, 13, bold=True), _width(kind, 11), _width(setting, 11))
    width = max(words + 20, sides + 34, across + 10, 80)
    labels = (_width(_unit(block.outputs[port]), 10) + 4 + 14 * (port in probed) for port in used)
    height = head + _ROW * max(len(inputs), len(outputs), 1) + 10 + (_FOOT - 10 if driven else 0)
    return Shape(
        -(-width // 10) * 10, height, inputs, outputs, driven, max(labels, default=0), bool(probed), block.noise
    )


# -- SVG ---------------------------------------------------------------------------------------------------------


def _block(graph: Picture, name: str, shape: Shape, spot: Spot, wired: _Wired) -> Iterator[str]:
    """Yield a block with its ports; unused outputs are drawn in a soft colour."""
    block = graph.blocks[name]
    continuous = block.continuous
    x, y, right = spot.x, spot.y, spot.x + shape.width
    middle = x + shape.width / 2
    rate = _rate(graph, name)
    yield f'<g class="block{" continuous" * continuous}" data-block="{_text(name)}">'
    yield f"<title>{_text(_block_tooltip(graph, name, wired.into[name]))}</title>"
    corner = 14 if continuous else 2
    yield f'<rect class="box" x="{x}" y="{y}" width="{shape.width}" height="{shape.height}" rx="{corner}"/>'
    if block.subgraph:
        yield f'<rect class="box" x="{x + 3}" y="{y + 3}" width="{shape.width - 6}" height="{shape.height - 6}"/>'
    yield f'<text class="name" x="{middle:g}" y="{y + 18}" text-anchor="middle">{_text(name)}</text>'
    extra = f'<tspan class="rate" dx="6">{_text(rate)}</tspan>' if rate else ""
    kind = f"{_text(block.kind)}{extra}"
    yield f'<text class="soft" x="{middle:g}" y="{y + 33}" text-anchor="middle">{kind}</text>'
    if setting := block.setting(wired.into[name]):
        yield f'<text class="setting" x="{middle:g}" y="{y + 49}" text-anchor="middle">{_text(setting)}</text>'
    probed, used = wired.probed[name], {*shape.inputs, *wired.used[name]}
    for ports, on_right in ((shape.inputs, spot.mirrored), (shape.outputs, not spot.mirrored)):
        at, anchor = (right - 8, ' text-anchor="end"') if on_right else (x + 8, "")
        for port, below in ports.items():
            style = "port" if port in used else "port soft"
            yield f'<text class="{style}" x="{at}" y="{y + below + 4}"{anchor}>{_text(port)}</text>'
    bottom = y + shape.height
    for parameter, across in shape.driven.items():
        at = x + across
        yield f'<text class="port rate" x="{at}" y="{bottom - 7}" text-anchor="middle">{_text(parameter)}</text>'
    for port, below in shape.outputs.items():
        edge, way, anchor = (x, -1, ' text-anchor="end"') if spot.mirrored else (right, 1, "")
        height, start = y + below, edge + 4 * way
        if port in probed:
            yield f'<path class="probe" d="M{edge} {height}h{8 * way}m0 0{_flag(way)}"/>'
            start += 16 * way
        unit = _unit(block.outputs[port])
        if unit and port in used:
            yield f'<text class="soft small" x="{start}" y="{height - 4}"{anchor}>{_text(unit)}</text>'
    yield "</g>"


def _flag(way: int) -> str:
    return f"v-14h{8 * way}l{-3 * way} 3.5l{3 * way} 3.5h{-8 * way}"


def _block_tooltip(graph: Picture, name: str, drivers: Mapping[str, str]) -> str:
    block = graph.blocks[name]
    lines = [f"{name}: {block.kind}", block.doc]
    if block.continuous:
        lines.append("continuous")
    elif rate := graph.rates.get(name, graph.rate):
        lines.append(f"at {write_rate(rate)}")
    for parameter, declared in block.parameters.items():
        value = block.values[parameter]
        unit = _unit(declared)
        if parameter in drivers:
            lines.append(f"{parameter}: driven by {drivers[parameter]}")
        elif declared.kind in (float, int):
            lines.append(f"{parameter} = {in_print(value, short_unit(declared.unit), 6)}")
        else:
            text = f"{len(value)} values" if isinstance(value, tuple) and len(value) > 8 else f"{value}"
            lines.append(f"{parameter} = {text} {unit}".rstrip())
    return "\n".join(line for line in lines if line)


def _shared(first: tuple[Point, ...], second: tuple[Point, ...]) -> int:
    """Return the last point that two wires from one output share, counted from their start."""
    return next((i for i, (a, b) in enumerate(zip(first[1:], second[1:], strict=False)) if a != b), 0)


def _wire(graph: Picture, link: Link, own: tuple[Point, ...], layout: Layout) -> Iterator[str]:
    """Yield one wire; `own` is the part that it does not share with other wires from the same output."""
    path = layout.paths[link]
    block = graph.blocks[link.source]
    port = block.outputs[link.output]
    unit = _unit(port)
    ends = f"{link.source}.{link.output} → {link.target}.{link.port}"
    tooltip = "\n".join((ends + (f" [{unit}]" if unit else ""), port.doc))
    (x, y), (before_x, before_y) = path[-1], path[-2]
    back = (before_x > x) - (before_x < x), (before_y > y) - (before_y < y)
    tip = [(x + 9 * back[0] + s * 4 * back[1], y + 9 * back[1] + s * 4 * back[0]) for s in (1, -1)]
    yield f'<g class="wire{" driven" * link.driven}" data-wire="{_text(ends)}"><title>{_text(tooltip)}</title>'
    yield f'<path class="reach" d="{_rounded(path, layout.dots)}"/>'
    yield f'<path class="line" d="{_rounded(own, layout.dots)}"/>'
    yield f'<path class="tip" d="M{x} {y}L{tip[0][0]} {tip[0][1]}L{tip[1][0]} {tip[1][1]}Z"/></g>'


def _rounded(path: tuple[Point, ...], dots: frozenset[Point]) -> str:
    """Return the path with small arcs at its corners, except where wires branch."""
    out = [f"M{path[0][0]} {path[0][1]}"]
    for before, (x, y), after in zip(path, path[1:], path[2:], strict=False):
        near = min(abs(x - before[0]) + abs(y - before[1]), abs(after[0] - x) + abs(after[1] - y))
        radius = 0 if (x, y) in dots else min(5, near // 2)
        if radius:
            ends = [
                (x + radius * ((px > x) - (px < x)), y + radius * ((py > y) - (py < y))) for px, py in (before, after)
            ]
            out.append(f"L{ends[0][0]} {ends[0][1]}Q{x} {y} {ends[1][0]} {ends[1][1]}")
        else:
            out.append(f"L{x} {y}")
    return "".join([*out, f"L{path[-1][0]} {path[-1][1]}"])


def _legend(graph: Picture, links: list[Link]) -> Iterator[tuple[int, str, int]]:
    """Return the legend: place, drawing and right end of each mark that occurs."""
    marks: Mapping[str, tuple[bool, str]] = {
        "continuous": (
            any(block.continuous for block in graph.blocks.values()),
            '<g class="continuous"><rect class="box" y="-9" width="18" height="12" rx="5"/></g>',
        ),
        "drives a parameter": (
            any(link.driven for link in links),
            '<g class="driven"><path class="line" d="M0 -3H18"/></g>',
        ),
        "probe": (bool(_probed(graph)), '<path class="probe" d="M5 3' + _flag(1) + '"/>'),
    }
    x = 0
    for words, (occurs, mark) in marks.items():
        if occurs:
            end = x + 24 + _width(words, 10)
            yield x, f'{mark}<text class="soft small" x="24" y="1">{words}</text>', end
            x = end + 20


def _width(text: str, size: int, bold: bool = False) -> int:
    """Return the width of a text, estimated generously."""
    narrow = sum(c in "iljtfrI.,:;|!'()[]/ ·" for c in text)
    wide = sum(c in "mwMW@%" for c in text)
    units = 0.6 * (len(text) - narrow - wide) + 0.36 * narrow + 0.9 * wide
    return round(units * size * (1.08 if bold else 1.0) + 0.5)


def _plain(text: str) -> str:
    return _ILLEGAL.sub("\N{REPLACEMENT CHARACTER}", text)


def _text(text: str) -> str:
    return escape(_plain(text))
