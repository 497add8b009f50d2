"""Breaks of the layers of a diagram into rows, as of words into lines."""

from collections.abc import Iterable, Iterator, Sequence
from math import ceil

from proofmass.graphs.drawing.items import Item, Net, NetName, Pin

WIDEST = 1300  # pixels: what a page of 1400 shows without making its text smaller
ASPECT = 1.25  # preferred width over height of a large diagram
ASPECT_NAMED = 0.9  # where long wires are named, more rows cost no lines between them, and a page scrolls down
_CROSSING = 0.015  # cost of a wire between rows; a row costs the square of its deviation from the preferred width
_LONGEST = 1.35  # largest width of a row over the preferred one
_TRIES = 5

RowRanges = Sequence[tuple[int, int]]  # first layer of each row, and the first of the next
NetsOf = dict[tuple[NetName, int, int], Net]  # by net, row and gap


def widths_to_try(width: int, height: int, aspect: float) -> Iterator[float]:
    """Yield widths for the rows of a diagram so large in one row; the first that does is taken."""
    goal = max(float(WIDEST), (aspect * width * height) ** 0.5)
    if not fits(width, height, aspect):
        fewest = max(2, ceil(width / goal))
        yield from (width / number for number in range(fewest, fewest + _TRIES))


def fits(width: int, height: int, aspect: float) -> bool:
    """Return whether a diagram needs no more rows."""
    return width <= max(WIDEST, aspect * height)


def rows_of(starts: Sequence[int], width: int, crossing: Sequence[int], wanted: float) -> RowRanges:
    """Return rows of about the wanted width.

    `starts` are the places of the layers in one row of the given width, `crossing` the wires in the
    gap before each. The sum over rows of (1 - width / wanted)^2, and of the wires between rows, is
    least.
    """
    count, ends = len(starts), [*starts[1:], width]
    best: list[tuple[float, int]] = [(0.0, 0)]  # least cost of the first layers, and the start of their last row
    for last in range(count):
        options = []
        for first in range(last, -1, -1):
            part = (ends[last] - starts[first]) / wanted
            if part > _LONGEST and first < last:
                break
            options.append((best[first][0] + (1.0 - part) ** 2 + _CROSSING * bool(first) * crossing[first], first))
        best.append(min(options))
    rows, last = list[tuple[int, int]](), count
    while last:
        first = best[last][1]
        rows.append((first, last))
        last = first
    return rows[::-1]


def broken(
    columns: Iterable[Sequence[Item]], nets: dict[tuple[str, str, int], Net], rows: RowRanges
) -> tuple[list[list[Item]], NetsOf]:
    """Return columns and nets within rows. A wire that goes on in another row leaves its row beside
    its last pin.

    Pins of the items become those within the row.
    """
    row_of = [number for number, (first, last) in enumerate(rows) for _ in range(first, last)]
    columns = [list(column) for column in columns]
    layer_of = {item: layer for layer, column in enumerate(columns) for item in column}
    reach: dict[tuple[NetName, int], tuple[int, int]] = {}  # gaps between which a net has pins of blocks, by row
    for (source, output, gap), net in nets.items():
        for pin in (*net.left, *net.right):
            if pin.item.name:
                key = (source, output), row_of[layer_of[pin.item]]
                low, high = reach.get(key, (gap, gap))
                reach[key] = min(low, gap), max(high, gap)
    within: NetsOf = {}
    for column in columns:
        for item in column:
            item.pins = ([], [])
    waypoints = set[Item]()
    for (source, output, gap), net in nets.items():
        for on_left, pins in ((False, net.left), (True, net.right)):  # of the gap's left side: right sides of items
            for pin in pins:
                layer = layer_of[pin.item]
                row = row_of[layer]
                low, high = reach.get(((source, output), row), (0, -1))
                if not (pin.item.name or low <= layer < high):
                    continue
                own = within.setdefault(((source, output), row, gap), Net())
                placed = Pin(pin.item, pin.below, pin.across, own)
                (own.right if on_left else own.left).append(placed)
                pin.item.pins[not on_left].append(placed)
                waypoints.add(pin.item)
    return [[item for item in column if item.name or item in waypoints] for column in columns], within
