"""Wires in the gap between two layers of a diagram: upright bars on tracks, so that no two wires ever share a line."""

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import TypeVar

GRID = 10
GridPoint = tuple[int, int]
WireTree = dict[GridPoint, set[GridPoint]]  # lines of one wire: the neighbours of each point
_Key = TypeVar("_Key", bound=Hashable)
Heights = tuple[Sequence[int], Sequence[int]]  # of the pins of one net on the left and on the right side of a gap
LARGEST_SIFTED = 150  # bars in one gap
_NEVER = 10**6


@dataclass(eq=False)
class Bar:
    """An upright piece of wire on a track, with the heights where wires leave it to the left and to the right."""

    left: tuple[int, ...]
    right: tuple[int, ...]
    join: int | None = None  # height where it is joined to the other bar of the same net
    track: int = 0

    def __post_init__(self) -> None:
        joins = () if self.join is None else (self.join,)
        self.heights: list[int] = sorted({*self.left, *self.right, *joins})
        self.low: int = self.heights[0]
        self.high: int = self.heights[-1]


def channel(nets: Mapping[_Key, Heights]) -> tuple[int, dict[_Key, list[Bar]]]:
    """Return the number of tracks of a gap and the bars of each net: none if it runs straight, two
    if it must dodge.

    Where one net arrives on the left at the height where another leaves on the right, its bar
    stands further left; nets that demand this of each other get two bars.
    """
    bars = {
        key: [Bar(tuple(sorted(left)), tuple(sorted(right)))]
        for key, (left, right) in nets.items()
        if len({*left, *right}) > 1
    }
    free = _free_heights([bar for net_bars in bars.values() for bar in net_bars])
    while True:
        flat = [bar for net_bars in bars.values() for bar in net_bars]
        order, stuck = _sorted(flat, _before(bars))
        if not stuck:
            break
        key, (bar,) = next(
            (key, net_bars) for key, net_bars in bars.items() if len(net_bars) == 1 and net_bars[0] in stuck
        )
        join = min(free, key=lambda y: (abs(2 * y - bar.low - bar.high), y))
        free.remove(join)
        bars[key] = [Bar(bar.left, (), join), Bar((), bar.right, join)]
    before = _before(bars)
    if len(order) <= LARGEST_SIFTED:
        order = _sifted(order, before)
    for i, bar in enumerate(order):
        bar.track = 1 + max(
            (other.track for other in order[:i] if _apart(other, bar) or bar in before[other]), default=-1
        )
    return 1 + max((bar.track for bar in order), default=-1), bars


def _free_heights(bars: Sequence[Bar]) -> list[int]:
    """Return heights between the pins at which the two bars of a net may be joined."""
    if not bars:
        return []
    low = min(bar.low for bar in bars)
    high = max(max(bar.high for bar in bars), low + GRID * len(bars))
    return list(range(low + GRID // 2, high + GRID * (1 + len(bars)), GRID))


def _before(bars: Mapping[_Key, Sequence[Bar]]) -> dict[Bar, set[Bar]]:
    """Return for each bar those that must stand to its right."""
    ending: dict[int, list[tuple[_Key, Bar]]] = {}
    for key, net_bars in bars.items():
        for bar in net_bars:
            for y in bar.right:
                ending.setdefault(y, []).append((key, bar))
    out: dict[Bar, set[Bar]] = {}
    for key, net_bars in bars.items():
        for bar in net_bars:
            out[bar] = {other for y in bar.left for to, other in ending.get(y, ()) if to != key}
        if len(net_bars) == 2:
            out[net_bars[0]].add(net_bars[1])
    return out


def _sorted(bars: Sequence[Bar], before: Mapping[Bar, set[Bar]]) -> tuple[list[Bar], set[Bar]]:
    """Return the bars from left to right, and those in a circle, each of which must stand left of the next."""
    waiting = dict.fromkeys(bars, 0)
    for bar in bars:
        for other in before[bar]:
            waiting[other] += 1
    order = [bar for bar in bars if not waiting[bar]]
    for bar in order:
        for other in bars if before[bar] else ():
            if other in before[bar]:
                waiting[other] -= 1
                if not waiting[other]:
                    order.append(other)
    return order, set(bars).difference(order)


def _sifted(order: list[Bar], before: Mapping[Bar, set[Bar]]) -> list[Bar]:
    """Move each bar to the track where it crosses the fewest wires."""
    cost = {(a, b): _crossings(a, b) + _NEVER * (a in before[b]) for a in order for b in order if a is not b}
    for _ in range(4):
        changed = False
        for bar in list(order):
            at = order.index(bar)
            others = order[:at] + order[at + 1 :]
            # change of the cost when the bar moves right past each of the others, from the leftmost place on
            total = list(accumulate((cost[other, bar] - cost[bar, other] for other in others), initial=0))
            best = min(range(len(total)), key=lambda place: (total[place], abs(place - at)))
            if total[best] < total[at]:
                order = [*others[:best], bar, *others[best:]]
                changed = True
        if not changed:
            break
    return order


def _crossings(first: Bar, second: Bar) -> int:
    """Return the number of crossings if the first stands left of the second."""
    return sum(second.low < y < second.high for y in first.right) + sum(first.low < y < first.high for y in second.left)


def _apart(first: Bar, second: Bar) -> bool:
    """Return whether two bars need different tracks, since they overlap or nearly touch."""
    return first.low < second.high + GRID and second.low < first.high + GRID


def add_line(tree: WireTree, *points: GridPoint) -> None:
    """Add a line through points to a tree."""
    for a, b in pairwise(points):
        if a != b:
            tree.setdefault(a, set()).add(b)
            tree.setdefault(b, set()).add(a)


def walked(tree: WireTree, start: GridPoint) -> dict[GridPoint, GridPoint]:
    """Return for each point of a tree its predecessor on the way from the start."""
    before: dict[GridPoint, GridPoint] = {}
    waiting = [start]
    for point in waiting:
        for near in sorted(tree.get(point, ())):
            if near != before.get(point):
                before[near] = point
                waiting.append(near)
    return before


def corners(path: list[GridPoint], dots: set[GridPoint]) -> list[GridPoint]:
    """Return the path without points on straight lines, unless it branches there."""
    inner = (
        b
        for a, b, c in zip(path, path[1:], path[2:], strict=False)
        if b in dots or not (a[0] == b[0] == c[0] or a[1] == b[1] == c[1])
    )
    return [path[0], *inner, path[-1]]
