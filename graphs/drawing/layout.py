"""Places of blocks and routes of wires on a grid: layers, order, rows, heights, then routes."""

from bisect import bisect_left, insort
from collections.abc import Collection, Mapping, Sequence
from itertools import accumulate

from proofmass.graphs.drawing.breaks import (
    ASPECT,
    ASPECT_NAMED,
    NetsOf,
    RowRanges,
    broken,
    fits,
    rows_of,
    widths_to_try,
)
from proofmass.graphs.drawing.items import Item, Layout, Net, Pin, Shape, Spot
from proofmass.graphs.drawing.layers import Layers, Link, assign_layers
from proofmass.graphs.drawing.routing import GRID, GridPoint, corners, walked
from proofmass.graphs.drawing.rows import Routed, route
from proofmass.graphs.model.digraph import connected

SWEEPS = 12
LARGEST_POLISHED = 3000  # items (blocks, and wires past blocks) that get every sweep
_BACKWARD = 0.3  # cost of a backward wire above a block, in crossings


def lay_out(
    shapes: Mapping[str, Shape], links: Sequence[Link], widest: int = 1200, undrawn: Collection[Link] = ()
) -> Layout:
    """Lay out each connected part on its own, then set the parts on shelves, the largest first.

    Undrawn wires have a say in the layers of blocks only; they get no path.
    """
    joined = _connected(sorted(shapes), links)
    parts = [_Part({n: shapes[n] for n in names}, own, undrawn).drawn() for names, own in joined]
    widest = max([widest, *(part.width for part in parts)])
    x = y = shelf = width = 0
    spots: dict[str, Spot] = {}
    paths: dict[Link, tuple[GridPoint, ...]] = {}
    dots: set[GridPoint] = set()
    for part in parts:
        if x and x + part.width > widest:
            x, y, shelf = 0, y + shelf + 4 * GRID, 0
        spots |= {name: Spot(s.x + x, s.y + y, s.mirrored) for name, s in part.spots.items()}
        paths |= {link: tuple((px + x, py + y) for px, py in path) for link, path in part.paths.items()}
        dots |= {(px + x, py + y) for px, py in part.dots}
        width, shelf = max(width, x + part.width), max(shelf, part.height)
        x += part.width + 4 * GRID
    return Layout(width, y + shelf, dict(sorted(spots.items())), dict(sorted(paths.items())), frozenset(dots))


def _connected(names: Sequence[str], links: Sequence[Link]) -> list[tuple[list[str], list[Link]]]:
    joined = connected(names, ((link.source, link.target) for link in links))
    parts = sorted(map(sorted, joined), key=lambda p: (-len(p), p))
    number = {name: i for i, part in enumerate(parts) for name in part}
    own: list[list[Link]] = [[] for _ in parts]
    for link in sorted(links):
        own[number[link.source]].append(link)
    return list(zip(parts, own, strict=True))


class _Part:
    """One connected part of the graph during layout."""

    def __init__(self, shapes: Mapping[str, Shape], links: Sequence[Link], undrawn: Collection[Link]) -> None:
        self.shapes = shapes
        self.aspect = ASPECT_NAMED if undrawn else ASPECT
        self.links: dict[tuple[str, str], list[Link]] = {}  # by source and output
        for link in (link for link in links if link not in undrawn):
            self.links.setdefault((link.source, link.output), []).append(link)
        self.layers: Layers = assign_layers(
            shapes, links, (n for n, s in shapes.items() if s.exit), (n for n, s in shapes.items() if s.noise)
        )
        self.columns: list[list[Item]] = [[] for _ in range(max(self.layers.of.values(), default=0) + 1)]
        self.blocks: dict[str, Item] = {}
        for name, shape in shapes.items():
            backward = name in self.layers.mirrored
            item = Item(name, shape.reserved(), (2 * backward, name, ""), backward, shape.width)
            self.blocks[name] = item
            self.columns[self.layers.of[name]].append(item)
        self.nets: dict[tuple[str, str, int], Net] = {}  # by source, output and gap
        self.within: NetsOf = {}
        self._connect()
        for column in self.columns:
            column.sort(key=lambda item: item.rank)

    def gap_of(self, name: str, is_output: bool, driven: bool = False) -> int:
        """Return the gap that a pin opens into; gap g lies left of layer g."""
        right = not driven and is_output != (name in self.layers.mirrored)
        return self.layers.of[name] + right

    def _connect(self) -> None:
        for (source, output), links in self.links.items():
            start = self.gap_of(source, True)
            pins = [(self.blocks[source], self.shapes[source].outputs[output], 0, start)]
            for link in links:
                shape = self.shapes[link.target]
                below, across = (
                    (shape.row(link.port), shape.driven[link.port]) if link.driven else (shape.inputs[link.port], 0)
                )
                pins.append((self.blocks[link.target], below, across, self.gap_of(link.target, False, link.driven)))
            first, last = min(gap for *_, gap in pins), max(gap for *_, gap in pins)
            nets = {gap: Net() for gap in range(first, last + 1)}
            self.nets |= {(source, output, gap): net for gap, net in nets.items()}
            for item, below, across, gap in pins:
                self._pin(Pin(item, below, across, nets[gap]), on_left=gap == self.layers.of[item.name])
            for layer in range(first, last):
                backward = layer < start
                item = Item("", 0, (1 + backward, source, output), backward)
                self.columns[layer].append(item)
                self._pin(Pin(item, 0, 0, nets[layer]), on_left=True)
                self._pin(Pin(item, 0, 0, nets[layer + 1]), on_left=False)

    def _pin(self, pin: Pin, on_left: bool) -> None:
        (pin.net.right if on_left else pin.net.left).append(pin)
        pin.item.pins[not on_left].append(pin)

    # -- order and heights -------------------------------------------------------------------------

    def drawn(self) -> Layout:
        """Return the layout in one row, or in more where one is too wide for a page."""
        self._order()
        ordered = self._state()
        layout, starts = self._in_rows([(0, len(self.columns))])
        crossing = [0] * len(self.columns)
        for _, _, gap in self.nets:
            if gap < len(crossing):
                crossing[gap] += 1
        whole = layout.width
        for wanted in widths_to_try(whole, layout.height, self.aspect):
            self._restore(ordered)
            rows = rows_of(starts, whole, crossing, wanted)
            tried, _ = self._in_rows(rows)
            if fits(tried.width, tried.height, self.aspect):
                return tried
            layout = min(layout, tried, key=lambda one: one.width)
        return layout

    def _order(self) -> None:
        """Put the items of each layer in the order in which their wires cross least."""
        for column in self.columns:
            self._settle(column, (0, 1))
        size = sum(len(column) for column in self.columns)
        best = self._state()
        for sweep in range(SWEEPS if size <= LARGEST_POLISHED else 2):
            side = sweep % 2  # one to the right compares with the layer on its left, and vice versa
            for column in self.columns if side == 0 else reversed(self.columns):
                wanted = {item: self._centre(item, side) for item in column}
                column.sort(key=lambda item: wanted[item])
                self._settle(column, (side,))
            best = min(best, self._state(), key=lambda state: state[0])
        self._restore(best)

    def _in_rows(self, rows: RowRanges) -> tuple[Layout, list[int]]:
        """Return the layout with the layers in these rows, and the place of each layer."""
        self.columns, self.within = broken(self.columns, self.nets, rows)
        best = self._state(straight=True)
        for sweep in range(SWEEPS):
            sides = ((0,), (1,), (0, 1), (1, 0))[sweep % 4]
            for column in self.columns if sides[0] == 0 else reversed(self.columns):
                self._settle(column, sides)
            best = min(best, self._state(straight=True), key=lambda state: state[0])
        self._restore(best)
        routed = route(self.columns, self.within, rows, self._room)
        return self._traced(routed), routed.starts

    def _state(self, straight: bool = False) -> tuple[float, list[list[Item]], list[list[int]]]:
        cost = self._bends() if straight else self._crossings()
        return cost, [list(column) for column in self.columns], [[i.top for i in column] for column in self.columns]

    def _restore(self, state: tuple[float, list[list[Item]], list[list[int]]]) -> None:
        self.columns = state[1]
        for column, tops in zip(state[1], state[2], strict=True):
            for item, top in zip(column, tops, strict=True):
                item.top = top

    def _centre(self, item: Item, side: int) -> float:
        """Return the best height for an item's middle, by the pins it is wired to on one side."""
        ends = [end.y - pin.below for pin in item.pins[side] for end in _opposite(pin, side) or _beside(pin, side)]
        return (sum(ends) / len(ends) if ends else item.top) + item.height / 2

    def _settle(self, column: list[Item], sides: tuple[int, ...]) -> None:
        """Set heights in a layer, in the same order, as close as possible to straight wires (isotonic medians)."""
        pools: list[tuple[int, list[tuple[int, float]], list[tuple[Item, int]]]] = []
        offset = 0
        for above, item in zip([None, *column], column, strict=False):
            offset += above.height + _between(above, item) if above else 0
            wants = [
                (end.y - pin.below - offset, _weight(pin, end))
                for side in sides
                for pin in item.pins[side]
                for end in _opposite(pin, side)
            ]
            wants.append((item.top - offset, 0.05))
            pool = (_median(wants), wants, [(item, offset)])
            while pools and pools[-1][0] > pool[0]:
                _, others, members = pools.pop()
                wants = others + pool[1]
                pool = (_median(wants), wants, members + pool[2])
            pools.append(pool)
        for position, _, members in pools:
            for item, offset in members:
                item.top = position + offset

    def _crossings(self) -> float:
        cost = 0.0
        by_gap: dict[int, list[Net]] = {}
        for (_, _, gap), net in self.nets.items():
            by_gap.setdefault(gap, []).append(net)
        for nets in by_gap.values():
            edges = sorted((a.y, b.y) for net in nets for a in net.left for b in net.right)
            seen: list[int] = []
            for _, y in edges:
                cost += len(seen) - bisect_left(seen, y + 1)
                insort(seen, y)
            for on_left in (True, False):
                ys = sorted(pin.y for net in nets for pin in (net.left if on_left else net.right))
                for net in nets:
                    own = [pin.y for pin in (net.left if on_left else net.right)]
                    if len(own) > 1 and not (net.right if on_left else net.left):
                        cost += bisect_left(ys, max(own)) - bisect_left(ys, min(own)) - len(own) + 1
        for column in self.columns:
            wires = 0
            for item in column:
                wires += item.backward
                cost += 0 if item.backward else _BACKWARD * wires * bool(item.name)
        return cost

    def _bends(self) -> float:
        """Return how far the wires are from straight; wires past blocks count more."""
        return sum(
            _weight(a, b) * (abs(a.y - b.y) + 2 * GRID * (a.y != b.y))
            for net in self.within.values()
            for a in net.left
            for b in net.right
        ) + 0.01 * sum(max((i.top + i.height for i in c), default=0) - c[0].top for c in self.columns if c)

    # -- pixels ------------------------------------------------------------------------------------

    def _room(self, layer: int, on_left: bool) -> int:
        """Return the space that a layer needs for labels beside outputs, and tabs beside inputs, on one side."""
        column = self.columns[layer] if 0 <= layer < len(self.columns) else []
        shapes = ((self.shapes[i.name], i.backward == on_left) for i in column if i.name)
        return max((shape.label if leaving else shape.entry for shape, leaving in shapes), default=0)

    def _traced(self, routed: Routed) -> Layout:
        spots = {name: Spot(item.x, item.top, item.backward) for name, item in self.blocks.items()}
        paths: dict[Link, tuple[GridPoint, ...]] = {}
        dots: set[GridPoint] = set()
        for name, tree in routed.trees.items():
            before = walked(tree, self._end(*name, is_output=True))
            dots |= {point for point, near in tree.items() if len(near) > 2}
            for link in self.links[name]:
                end = self._end(link.target, link.port, driven=link.driven)
                path = [end]
                while path[-1] in before:
                    path.append(before[path[-1]])
                if link.driven:
                    path.insert(0, (end[0], self.blocks[link.target].top + self.shapes[link.target].height))
                paths[link] = tuple(corners(path[::-1], dots))
        return Layout(routed.width, routed.height, spots, paths, frozenset(dots))

    def _end(self, name: str, port: str, is_output: bool = False, driven: bool = False) -> GridPoint:
        """Return where a wire leaves or reaches a block (a driven parameter: a row lower)."""
        item, shape = self.blocks[name], self.shapes[name]
        if driven:
            return item.x + shape.driven[port], item.top + shape.row(port)
        heights = shape.outputs if is_output else shape.inputs
        return item.x + item.width * (is_output != item.backward), item.top + heights[port]


def _opposite(pin: Pin, side: int) -> list[Pin]:
    return pin.net.left if side == 0 else pin.net.right


def _beside(pin: Pin, side: int) -> list[Pin]:
    return [other for other in (pin.net.right if side == 0 else pin.net.left) if other.item is not pin.item]


def _between(above: Item, below: Item) -> int:
    """Return the free height between two neighbours of a layer."""
    return GRID * (1 + bool(above.name) + bool(below.name))


def _weight(first: Pin, second: Pin) -> float:
    """Return the weight of a straight wire here."""
    if first.across or second.across:
        return 0.4
    return (8.0, 1.5, 3.0)[bool(first.item.name) + bool(second.item.name)]


def _median(wants: list[tuple[int, float]]) -> int:
    half = sum(weight for _, weight in wants) / 2
    wants = sorted(wants)
    reached = accumulate(weight for _, weight in wants)
    return next(value for (value, _), total in zip(wants, reached, strict=True) if total >= half)
