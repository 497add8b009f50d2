"""Block diagrams of a graph as SVG.

The pictures depend on the graph alone, never on the order in which blocks and wires were declared. Wires whose ends do
not exist are left out: `check` reports them.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence

from proofmass.graphs.drawing.boxes import block_lines, flag
from proofmass.graphs.drawing.items import Layout
from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.layout import lay_out
from proofmass.graphs.drawing.links import WiredPorts, links_of, probed, rate_text
from proofmass.graphs.drawing.looks import Look, inner_place, look_of
from proofmass.graphs.drawing.opened import with_tabs
from proofmass.graphs.drawing.overlays import Overlays
from proofmass.graphs.drawing.picture import picture_of
from proofmass.graphs.drawing.routing import GridPoint
from proofmass.graphs.drawing.style import SHADES, STYLE
from proofmass.graphs.drawing.texts import text, unit_in_print, width_of
from proofmass.graphs.drawing.wires import drawn_path, hops_of, shared
from proofmass.graphs.model.flatten import FlatGraph, flatten, inside, parts
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.rates import write_rate

_MARGIN = 20
_LEGEND = 20  # pixels of one line

Mark = tuple[str, int, str]  # of a legend: drawing, its width, words


def svg(graph: Graph, unfolded: Collection[str] = (), overlay: str = "") -> str:
    """Return the block diagram as SVG: signals from left to right, return paths below, details as tooltips.

    `unfolded` names subgraphs by their paths, as in `"x_axis"`: what is inside is drawn in their place. An overlay,
    `"rates"`, `"loops"` or `"formats"`, colours blocks and wires by what they share.
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
    """Drawing of a graph, or of an opened subgraph: a picture, its layout, and the drawings inside."""

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
        self.wired = WiredPorts(self.picture, self.links)
        self.looks = {name: self._look(name) for name in self.picture.blocks}
        self.layout: Layout = lay_out({name: look.shape for name, look in self.looks.items()}, self.links)

    def _look(self, name: str) -> Look:
        inner = self.inner.get(name)
        size = (inner.layout.width, inner.layout.height) if inner else None
        return look_of(name, self.picture.blocks[name], self.wired, rate_text(self.picture, name), size)

    def lines(self) -> Iterator[str]:
        """Yield the wires, then the blocks, so that symbols cover the ends of wires."""
        hops = hops_of(self.layout)
        paths: dict[GridPoint, list[tuple[GridPoint, ...]]] = {}  # by start
        dots: dict[GridPoint, str] = {}
        for link in sorted(self.links, key=lambda link: (link.driven, link)):
            path = self.layout.paths[link]
            others = paths.setdefault(path[0], [])
            own = path[max((shared(path, other) for other in others), default=0) :]
            net = link.source, link.output
            levels = {y: places for (other, y), places in hops.items() if other == net}
            yield self._wire(link, own, levels)
            others.append(path)
            shade = self._net(link)
            dots |= {point: shade for point in path if point in self.layout.dots and (shade or point not in dots)}
        plain = {(link.source, link.output) for link in self.links if not link.driven}
        carrying = (link for link in self.links if (link.source, link.output) in plain)
        signals = {point for link in carrying for point in self.layout.paths[link]}
        for point in sorted(self.layout.dots):
            style = "dot" if point in signals else f"dot {dots[point]}".strip()
            yield f'<circle class="{style}" cx="{point[0]}" cy="{point[1]}" r="3.2"/>'
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

    def _net(self, link: Link) -> str:
        return f"net{self.wired.net_of[link.source, link.output] % SHADES}" if link.driven else ""

    def _wire(self, link: Link, own: Sequence[GridPoint], hops: Mapping[int, Sequence[int]]) -> str:
        """Return one wire; `own` is the part that it does not share with other wires from the same output."""
        layout, source, target = self.layout, self.looks[link.source], self.looks[link.target]
        path = list(layout.paths[link])
        box = self.picture.blocks[link.source]
        port, signal, kind = box.outputs[link.output], box.signals[link.output], box.types[link.output]
        unit = unit_in_print(port)
        ends = f"{_end(self.path, link.source, link.output)} → {_end(self.path, link.target, link.port)}"
        rate = f"at {write_rate(box.rate)}" if box.rate and not box.continuous else ""
        about = ", ".join(filter(None, (unit and f"in {unit}", kind, "continuous" if box.continuous else rate)))
        (x, y), (before_x, before_y) = path[-1], path[-2]
        back = (before_x > x) - (before_x < x), (before_y > y) - (before_y < y)
        inset = target.insets.get(link.port, 0.0)
        end = x - back[0] * inset, y - back[1] * inset
        tip = [(end[0] + 9 * back[0] + s * 4 * back[1], end[1] + 9 * back[1] + s * 4 * back[0]) for s in (1, -1)]
        begin = _outwards(path[0], path[1], source.insets.get(link.output, 0.0))
        whole = [begin, *path[1:-1], end]
        mine = [begin if tuple(own[0]) == path[0] else own[0], *own[1:-1], end]
        flat_target = inside(self.flat.root, f"{self.path}{link.target}.{link.port}")
        driven = ["driven", self._net(link)] if link.driven else []
        classes = ["wire", *driven, *self.overlays.of_wire(signal, flat_target, kind)]
        mark = f"M{end[0]:g} {end[1]:g}L{tip[0][0]:g} {tip[0][1]:g}L{tip[1][0]:g} {tip[1][1]:g}Z"
        return (
            f'<g class="{" ".join(classes)}" data-wire="{text(ends)}" data-signal="{text(signal)}">'
            f"<title>{text(chr(10).join((ends, about, port.doc)))}</title>"
            f'<path class="reach" d="{drawn_path(whole, layout.dots, {})}"/>'
            f'<path class="line" d="{drawn_path(mine, layout.dots, hops)}"/>'
            f'<path class="tip" d="{mark}"/></g>'
        )

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


def _end(path: str, name: str, port: str) -> str:
    return f"{path}{name}.{port}"


def _outwards(start: GridPoint, after: GridPoint, inset: float) -> tuple[float, float]:
    """Return the start of a wire at the symbol that it leaves, which is smaller than its block."""
    return start[0] - inset * ((after[0] > start[0]) - (after[0] < start[0])), start[1]


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
