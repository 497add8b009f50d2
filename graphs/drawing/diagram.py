"""Block diagrams of a graph as SVG.

The pictures depend on the graph alone, never on the order in which blocks and wires were declared.
Wires whose ends do not exist are left out: `check` reports them.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from proofmass.blocks.declaration.declare import Port
from proofmass.graphs.drawing.boxes import block_lines, flag
from proofmass.graphs.drawing.eased import Eased, Path, eased_of, fan_of, named_ends
from proofmass.graphs.drawing.items import Layout
from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.layout import lay_out
from proofmass.graphs.drawing.links import WiredPorts, links_of, probed, rate_text
from proofmass.graphs.drawing.looks import Look, inner_place, look_of
from proofmass.graphs.drawing.overlays import Overlays
from proofmass.graphs.drawing.picture import TAB, Box, Picture, node_of, outside, picture_of
from proofmass.graphs.drawing.routing import GridPoint
from proofmass.graphs.drawing.style import SHADES, STYLE
from proofmass.graphs.drawing.tabs import tab_below, tab_of_wire
from proofmass.graphs.drawing.texts import text, unit_in_print, width_of
from proofmass.graphs.drawing.wires import Hops, drawn_path, hops_of, net_of, shared
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside, parts
from proofmass.graphs.model.graph import Endpoint, Graph
from proofmass.graphs.model.rates import write_rate

_MARGIN = 20
_PORT = "value"  # of a tab
_LEGEND = 20  # pixels of one line

Mark = tuple[str, int, str]  # of a legend: drawing, its width, words


def svg(graph: Graph, unfolded: Collection[str] = (), overlay: str = "") -> str:
    """Return the block diagram as SVG: signals from left to right, return paths below, details as tooltips.

    `unfolded` names subgraphs by their paths, as in `"x_axis"`: what is inside is drawn in their
    place. An overlay, `"rates"`, `"loops"` or `"formats"`, colours blocks and wires by what they
    share.
    """
    flat = flatten(graph)
    overlays = Overlays(flat)
    drawing = Drawing(flat, graph, "", frozenset(unfolded), overlays)
    body = list(drawing.lines())
    width = max(drawing.layout.width, width_of(graph.name, 15, bold=True) + 80, 160) + 2 * _MARGIN
    legends = {"plain": list(drawing.legend())} | {
        f"only {name}": [_swatch(*entry) for entry in entries] for name, entries in overlays.legend().items()
    }
    lines_of = {name: _lined(marks, width - 2 * _MARGIN) for name, marks in legends.items()}
    top = corner(graph)[1]
    foot = _LEGEND * max(map(len, lines_of.values()))
    height = top + drawing.layout.height + _MARGIN + foot + 10
    about = text(f"Block diagram {graph.name}".strip())
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="{f"proofmass {overlay}".strip()}" width="{width}" '
        f'height="{height}" viewBox="0 0 {width} {height}" role="img" aria-label="{about}">',
        f"<style>{STYLE}</style>",
        f'<rect class="paper" width="{width}" height="{height}"/>',
    ]
    if graph.name:
        rate = f' <tspan class="soft small">{write_rate(graph.rate)}</tspan>' if graph.rate is not None else ""
        out.append(f'<text class="title" x="{_MARGIN}" y="{_MARGIN + 10}">{text(graph.name)}{rate}</text>')
    if not graph.blocks and not graph.subgraphs:
        out.append(f'<text class="soft" x="{_MARGIN}" y="{top + 10}">no blocks</text>')
    out += [f'<g transform="translate({_MARGIN} {top})">', *body, "</g>"]
    for name, rows in lines_of.items():
        out.append(f'<g class="legend {name}">')
        for number, row in enumerate(rows):
            y = height - foot - 4 + _LEGEND * number
            out += [f'<g transform="translate({_MARGIN + x} {y})">{mark}</g>' for x, mark in row]
        out.append("</g>")
    return "\n".join([*out, "</svg>", ""])


def corner(graph: Graph) -> tuple[int, int]:
    """Return where the blocks of a diagram begin, in pixels from the upper left."""
    return _MARGIN, _MARGIN + (30 if graph.name else 0)


def subgraph_paths(graph: Graph) -> list[str]:
    """Return the paths of all subgraphs, outer ones first."""
    return [path.rstrip(".") for path, _ in parts(graph) if path]


class Drawing:
    """Drawing of a graph, or of an opened subgraph: a picture, its layout, and those inside."""

    def __init__(self, flat: FlatGraph, graph: Graph, path: str, unfolded: frozenset[str], overlays: Overlays) -> None:
        self.flat, self.path, self.overlays = flat, path, overlays
        self.inner = {
            name: Drawing(flat, part, f"{path}{name}.", unfolded, overlays)
            for name, part in graph.subgraphs.items()
            if f"{path}{name}" in unfolded
        }
        picture = picture_of(flat, graph, path)
        self.picture = with_tabs(flat, graph, picture, path) if path else picture
        self.links = links_of(self.picture)
        self._lay_out(Eased())
        while (eased := eased_of(self.layout, self.paths, self.eased)) != self.eased:
            self._lay_out(eased)

    def _lay_out(self, eased: Eased) -> None:
        self.eased = eased
        self.wired = WiredPorts(self.picture, self.links, eased.named, eased.leaders)
        self.looks = {name: self._look(name) for name in self.picture.blocks}
        shapes = {name: look.shape for name, look in self.looks.items()}
        self.layout: Layout = lay_out(shapes, self.links, undrawn=eased.named | eased.followers)
        spots = self.layout.spots
        self.fans = {
            link: fan_of(link, self.layout.paths[leader], spots, self.looks) for link, leader in eased.leaders.items()
        }
        self.paths: Mapping[Link, Path] = {**self.layout.paths, **{link: fan.whole for link, fan in self.fans.items()}}
        self.ends = {link: named_ends(link, spots, self.looks) for link in eased.named}

    def _look(self, name: str) -> Look:
        inner = self.inner.get(name)
        size = (inner.layout.width, inner.layout.height) if inner else None
        return look_of(name, self.picture.blocks[name], self.wired, rate_text(self.picture, name), size)

    def lines(self) -> Iterator[str]:
        """Yield the wires, then the blocks, so that symbols cover the ends of wires."""
        yield from self._wires()
        for name, spot in self.layout.spots.items():
            box, look = self.picture.blocks[name], self.looks[name]
            classes = self.overlays.of_block(box) if box.kind else ()
            formats = {port: self.overlays.format(kind) for port, kind in box.types.items()}
            yield from block_lines(name, box, look, spot, self.wired, classes, formats)
            if name in self.inner:
                x, y = inner_place(look, spot.mirrored)
                yield f'<g transform="translate({spot.x + x} {spot.y + y})">'
                yield from self.inner[name].lines()
                yield "</g>"
            yield "</g>"

    def _wires(self) -> Iterator[str]:
        """Yield the wires and their dots, then bundles, then the named wires, net by net."""
        leaders = self.eased.leaders
        hops = hops_of(self.paths, leaders)
        paths: dict[GridPoint, list[Path]] = {}  # by start
        dots: dict[GridPoint, str] = {}
        alone = sorted(self.paths.keys() - leaders.keys(), key=_signals_first)
        for link in alone:
            path = self.paths[link]
            others = paths.setdefault(path[0], [])
            own = path[max((shared(path, other) for other in others), default=0) :]
            yield self._wire(link, [path], [own], hops)
            others.append(path)
            shade = self._net(link)
            dots |= {point: shade for point in path if point in self.layout.dots and (shade or point not in dots)}
        plain = {(link.source, link.output) for link in alone if not link.driven}
        carrying = (link for link in alone if (link.source, link.output) in plain)
        signals = {point for link in carrying for point in self.paths[link]}
        for point in sorted(self.layout.dots):
            style = "dot" if point in signals else f"dot {dots[point]}".strip()
            yield f'<circle class="{style}" cx="{point[0]}" cy="{point[1]}" r="3.2"/>'
        for leader in sorted(set(leaders.values())):
            yield from self._bundle(leader, hops)
        for name, port in sorted({(link.source, link.output) for link in self.ends}):
            yield from self._named(name, port)

    def _bundle(self, leader: Link, hops: Hops) -> Iterator[str]:
        """Yield the wires of a bundle where they are apart, and the line that stands for all, with their number."""
        links = [link for link in sorted(self.paths) if self.eased.leaders.get(link) == leader]
        trunk = self.fans[leader].trunk
        for link in links:
            fan = self.fans[link]
            yield self._wire(link, [fan.whole], [fan.source, fan.reader], hops)
        signals = " ".join(self.picture.blocks[link.source].signals[link.output] for link in links)
        (x, y), (to, _) = max(pairwise(trunk), key=lambda line: abs(line[1][0] - line[0][0]))
        x = (x + to) // 2
        yield (
            f'<g class="bundle" data-signals="{text(signals)}">'
            f"<title>{len(links)} wires\n{text(chr(10).join(map(self._told, links)))}</title>"
            f'<path class="reach" d="{drawn_path(trunk, self.layout.dots, {})}"/>'
            f'<path class="line" d="{drawn_path(trunk, self.layout.dots, self._levels(leader, hops))}"/>'
            f'<path class="count" d="M{x - 3} {y + 5}l6 -10"/>'
            f'<text class="soft small" x="{x}" y="{y - 7}" text-anchor="middle">{len(links)}</text></g>'
        )

    def _named(self, name: str, port: str) -> Iterator[str]:
        """Yield the named wires of an output, in one group: a pointer at one marks all."""
        links = sorted((link for link in self.ends if (link.source, link.output) == (name, port)), key=_signals_first)
        drawn = [link for link in self.paths if (link.source, link.output) == (name, port)]
        label, look, spot = self.wired.net_label(links[0]), self.looks[name], self.layout.spots[name]
        shade = self._net(links[0]) if all(link.driven for link in drawn) else ""
        yield f'<g class="named" data-net="{text(self.picture.blocks[name].signals[port])}">'
        for number, link in enumerate(links):
            start, end = self.ends[link]
            yield self._wire(link, [start, end], [end] if number or drawn else [start, end], {})
        for link in links:
            at, wide = self.ends[link].reader[0], self.looks[link.target].tabs[link.port][1]
            mirrored = self.layout.spots[link.target].mirrored
            below = tab_below(label, at, wide, self._net(link))
            yield below if link.driven else tab_of_wire(label, at, wide, mirrored, "")
        if port in look.tabs:
            yield tab_of_wire(label, self.ends[links[0]].source[1], look.tabs[port][1], spot.mirrored, shade)
        yield "</g>"

    def _told(self, link: Link) -> str:
        return f"{self.path}{link.source}.{link.output} → {self.path}{link.target}.{link.port}"

    def _levels(self, link: Link, hops: Hops) -> dict[int, Sequence[int]]:
        """Return the places at which a wire hops over others, by height."""
        net = net_of(link, self.eased.leaders)
        return {y: places for (other, y), places in hops.items() if other == net}

    def _wire(self, link: Link, whole: Sequence[Path], own: Sequence[Path], hops: Hops) -> str:
        """Return one wire by its pieces; `own` are the lines that no other wire draws."""
        source, target = self.looks[link.source], self.looks[link.target]
        box = self.picture.blocks[link.source]
        port, signal, kind = box.outputs[link.output], box.signals[link.output], box.types[link.output]
        unit = unit_in_print(port)
        rate = f"at {write_rate(box.rate)}" if box.rate and not box.continuous else ""
        about = ", ".join(filter(None, (unit and f"in {unit}", kind, "continuous" if box.continuous else rate)))
        (x, y), (before_x, before_y) = whole[-1][-1], whole[-1][-2]
        back = (before_x > x) - (before_x < x), (before_y > y) - (before_y < y)
        inset = target.insets.get(link.port, 0.0)
        end = x - back[0] * inset, y - back[1] * inset
        tip = [(end[0] + 9 * back[0] + s * 4 * back[1], end[1] + 9 * back[1] + s * 4 * back[0]) for s in (1, -1)]
        (x, y), (after_x, _) = whole[0][:2]
        begin = x - source.insets.get(link.output, 0.0) * ((after_x > x) - (after_x < x)), y
        met = {whole[0][0]: begin, whole[-1][-1]: end}  # at the edges of symbols, which are smaller than their blocks

        def drawn(pieces: Sequence[Path], levels: Mapping[int, Sequence[int]]) -> str:
            lines = ([met.get(point, point) for point in piece] for piece in pieces)
            return "".join(drawn_path(line, self.layout.dots, levels) for line in lines)

        flat_target = inside(self.flat.root, f"{self.path}{link.target}.{link.port}")
        driven = ["driven", self._net(link)] if link.driven else []
        classes = ["wire", *driven, *self.overlays.of_wire(signal, flat_target, kind)]
        mark = f"M{end[0]:g} {end[1]:g}L{tip[0][0]:g} {tip[0][1]:g}L{tip[1][0]:g} {tip[1][1]:g}Z"
        ends = self._told(link)
        return (
            f'<g class="{" ".join(classes)}" data-wire="{text(ends)}" data-signal="{text(signal)}">'
            f"<title>{text(chr(10).join((ends, about, port.doc)))}</title>"
            f'<path class="reach" d="{drawn(whole, {})}"/>'
            f'<path class="line" d="{drawn(own, self._levels(link, hops))}"/>'
            f'<path class="tip" d="{mark}"/></g>'
        )

    def _net(self, link: Link) -> str:
        return f"net{self.wired.net_of[link.source, link.output] % SHADES}" if link.driven else ""

    def legend(self) -> Iterator[Mark]:
        """Yield the marks that occur."""
        drawings = list(self._all())
        if any(box.continuous for one in drawings for box in one.picture.blocks.values()):
            yield '<g class="continuous"><rect class="box" y="-9" width="18" height="12" rx="5"/></g>', 18, "continuous"
        if any(link.driven for one in drawings for link in one.links):
            yield '<g class="net0"><path class="line" d="M0 -3H18"/></g>', 18, "drives a parameter"
        if any(probed(one.picture) for one in drawings):
            yield f'<path class="probe" d="M5 3{flag(1)}"/>', 18, "probe"

    def _all(self) -> Iterator["Drawing"]:
        yield self
        for inner in self.inner.values():
            yield from inner._all()


def _signals_first(link: Link) -> tuple[bool, Link]:
    return link.driven, link


def _swatch(style: str, words: str) -> Mark:
    mark = f'<g class="{style}"><rect class="box" y="-9" width="12" height="12"/><path class="line" d="M0 -3H12"/></g>'
    return (mark if style else ""), 12, words


def _lined(marks: Sequence[Mark], width: int) -> list[list[tuple[int, str]]]:
    """Return the lines of a legend: place and drawing of each mark."""
    lines: list[list[tuple[int, str]]] = [[]]
    x = 0
    for mark, size, words in marks:
        end = x + size + 6 + width_of(words, 10)
        if lines[-1] and end > width:
            lines.append([])
            x, end = 0, end - x
        lines[-1].append((x, f'{mark}<text class="soft small" x="{size + 6}" y="1">{text(words)}</text>'))
        x = end + 20
    return lines if lines[0] else []


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
