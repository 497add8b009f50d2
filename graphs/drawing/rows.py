"""Rows of a diagram: layers in lines, one below the other, and wires that go from row to row through corridors."""

from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from proofmass.graphs.drawing.breaks import NetsOf, RowRanges
from proofmass.graphs.drawing.items import Item, Net, NetName
from proofmass.graphs.drawing.routing import GRID, Bar, WireTree, add_line, channel

_BAND = 6 * GRID  # height of a band without blocks
_ABOVE, _BELOW = -2 * GRID, 2 * GRID  # where wires leave a row, from its top and its bottom, until corridors are known

Room = Callable[[int, bool], int]  # for labels beside the outputs of a layer, on its left or right


class Routed(NamedTuple):
    """Wires as trees of lines, the size of it all, and where each layer begins."""

    width: int
    height: int
    trees: Mapping[NetName, WireTree]
    starts: list[int]


class _Row:
    """One row: its layers with their places, and the bars of wires in the gaps between them."""

    def __init__(self, columns: Sequence[Sequence[Item]], first: int, last: int) -> None:
        self.columns, self.first, self.last = columns[first:last], first, last
        self.items = [item for column in self.columns for item in column]
        _close_up(self.items)
        self.height = max((item.top + item.height for item in self.items), default=0)
        self.nets: dict[int, dict[NetName, Net]] = {gap: {} for gap in range(first, last + 1)}
        self.leaves: dict[bool, dict[NetName, int]] = {False: {}, True: {}}  # gap of each net; downwards or not
        self.bars: dict[int, tuple[int, dict[NetName, list[Bar]]]] = {}
        self.starts: list[int] = []
        self.width = 0
        self.top = 0  # in the diagram

    def place(self, room: Room) -> None:
        """Set the places of layers and bars from the left."""
        x = 0
        for gap, nets in self.nets.items():
            self.starts.append(x)
            tracks, bars = channel({name: self._heights(name, gap, net) for name, net in nets.items()})
            side = self._room(room, gap - 1, False)
            x += side + (GRID if nets or self.first < gap < self.last else 0)
            self.bars[gap] = x, bars
            x += GRID * tracks + self._room(room, gap, True) + (GRID if nets or self.first < gap < self.last else 0)
            column = self.columns[gap - self.first] if gap < self.last else []
            width = max((item.width for item in column), default=0)
            for item in column:
                item.width = item.width or width
                item.x = x + (width - item.width) // 2 // GRID * GRID
            x += width
        self.width = x

    def _room(self, room: Room, layer: int, on_left: bool) -> int:
        return -(-room(layer, on_left) // GRID) * GRID if self.first <= layer < self.last else 0

    def _heights(self, name: NetName, gap: int, net: Net) -> tuple[list[int], list[int]]:
        """Heights of the pins of a net in a gap, and where it leaves the row."""
        left = [pin.y for pin in net.left]
        if self.leaves[False].get(name) == gap:
            left.append(_ABOVE)
        if self.leaves[True].get(name) == gap:
            left.append(self.height + _BELOW)
        return left, [pin.y for pin in net.right]

    def across(self, name: NetName, down: bool) -> int:
        """Return where a net leaves the row."""
        left, bars = self.bars[self.leaves[down][name]]
        return left + GRID * bars[name][0].track

    def grow(self, trees: dict[NetName, WireTree], corridors: Mapping[tuple[bool, NetName], int]) -> None:
        """Add the lines of the row to the trees; `corridors` has the heights at which nets go on, in the diagram."""
        for gap, nets in self.nets.items():
            left, bars = self.bars[gap]
            for name, net in nets.items():
                known = {_ABOVE: corridors.get((False, name)), self.height + _BELOW: corridors.get((True, name))}
                heights = {y: self.top + y if at is None else at for y, at in known.items()}
                _grow(trees.setdefault(name, {}), net, bars.get(name, []), left, self.top, heights)


def _close_up(items: Sequence[Item]) -> None:
    """Move items up: the first is at zero, and no empty level band is higher than need be."""
    bottom, up = 0, min((item.top for item in items), default=0)
    for item in sorted(items, key=lambda item: item.top):
        up += max(0, item.top - up - bottom - _BAND)
        item.top -= up
        bottom = max(bottom, item.top + item.height)


def route(columns: Sequence[Sequence[Item]], within: NetsOf, rows: RowRanges, room: Room) -> Routed:
    """Set the places of all items, row by row, and return the wires."""
    placed = [_Row(columns, first, last) for first, last in rows]
    for (name, number, gap), net in within.items():
        placed[number].nets[gap][name] = net
    for name, joined in _joined(within).items():
        for number in range(min(joined), max(joined) + 1):
            row, gaps = placed[number], joined.get(number, ())
            if not gaps:
                row.nets[row.first].setdefault(name, Net())  # past the whole row, on its left
            if number > min(joined):
                row.leaves[False][name] = min(gaps, default=row.first)
            if number < max(joined):
                row.leaves[True][name] = max(gaps, default=row.first)
    for row in placed:
        row.nets = {gap: dict(sorted(nets.items())) for gap, nets in row.nets.items()}
        row.place(room)
    trees: dict[NetName, WireTree] = {}
    levels: list[dict[tuple[bool, NetName], int]] = [{} for _ in placed]
    bottom = 0
    for number, row in enumerate(placed):
        row.top = bottom
        bottom += row.height
        if number + 1 < len(placed):
            bottom = _corridor(trees, placed, levels, number, bottom)
    for row, heights in zip(placed, levels, strict=True):
        for item in row.items:
            item.top += row.top
        row.grow(trees, heights)
    starts = [start for row in placed for start in row.starts[:-1]]
    return Routed(max((row.width for row in placed), default=0), bottom, trees, starts)


def _joined(within: NetsOf) -> dict[NetName, dict[int, list[int]]]:
    """The gaps in which each net has pins, by row."""
    joined: dict[NetName, dict[int, list[int]]] = {}
    for name, row, gap in within:
        joined.setdefault(name, {}).setdefault(row, []).append(gap)
    return joined


def _corridor(
    trees: dict[NetName, WireTree],
    placed: Sequence[_Row],
    levels: Sequence[dict[tuple[bool, NetName], int]],
    number: int,
    bottom: int,
) -> int:
    """Add the lines between a row and the next, and return the height at which that begins.

    A corridor is a channel turned by a right angle.
    """
    above, below = placed[number], placed[number + 1]
    ends = {name: ([above.across(name, True)], [below.across(name, False)]) for name in sorted(above.leaves[True])}
    tracks, bars = channel(ends)
    first = bottom + 2 * GRID
    for name in ends:
        tree = trees.setdefault(name, {})
        own = bars.get(name, [])
        heights = [first + GRID * bar.track for bar in own] or [first]
        for y, bar in zip(heights, own, strict=False):
            add_line(tree, *((x, y) for x in bar.heights))
        if own and own[0].join is not None:
            add_line(tree, *((own[0].join, y) for y in heights))
        levels[number][True, name], levels[number + 1][False, name] = heights[0], heights[-1]
    return first + GRID * tracks + 2 * GRID


def _grow(tree: WireTree, net: Net, bars: list[Bar], left: int, top: int, heights: Mapping[int, int]) -> None:
    """Add the lines of a net in one gap, and through the layer before it, to its tree."""
    for pin in net.left:
        if not pin.item.name:  # the layer that the wire comes through
            add_line(tree, (pin.item.x, pin.y), (pin.item.x + pin.item.width, pin.y))
    lefts = [(pin.item.x + pin.item.width, pin.y) for pin in net.left]
    rights = [(pin.item.x + pin.across, pin.y) for pin in net.right]
    if not bars:
        add_line(tree, *sorted({*lefts, *rights}))
        return
    places = [left + GRID * bar.track for bar in bars]
    for x, bar in zip(places, bars, strict=True):
        add_line(tree, *((x, heights.get(y, y + top)) for y in bar.heights))
    for x, y in lefts:
        add_line(tree, (x, y), (places[0], y))
    for x, y in rights:
        add_line(tree, (places[-1], y), (x, y))
    if bars[0].join is not None:
        add_line(tree, *((x, bars[0].join + top) for x in places))
