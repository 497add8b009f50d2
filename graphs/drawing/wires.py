"""Wires of a diagram as SVG paths: round corners, dots at branches, hops at crossings."""

from bisect import bisect_left, bisect_right
from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise

from proofmass.graphs.drawing.items import NetName
from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.routing import GridPoint

_CORNER, _HOP = 5, 4  # radii in pixels

Hops = Mapping[tuple[NetName, int], Sequence[int]]  # places of hops along the level lines of a net, by height


def hops_of(paths: Mapping[Link, Sequence[GridPoint]], leaders: Mapping[Link, Link]) -> Hops:
    """Return where level lines cross upright lines of other nets; those of a bundle count as the net of its leader."""
    level: set[tuple[int, int, int, NetName]] = set()  # height, from, to
    upright: dict[int, set[tuple[int, int, NetName]]] = {}  # by place
    for link, path in paths.items():
        net = net_of(link, leaders)
        for (x1, y1), (x2, y2) in pairwise(path):
            if y1 == y2:
                level.add((y1, min(x1, x2), max(x1, x2), net))
            else:
                upright.setdefault(x1, set()).add((min(y1, y2), max(y1, y2), net))
    places = sorted(upright)
    hops: dict[tuple[NetName, int], set[int]] = {}
    for y, low, high, net in level:
        for x in places[bisect_right(places, low + _HOP) : bisect_left(places, high - _HOP)]:
            if any(top < y < bottom and other != net for top, bottom, other in upright[x]):
                hops.setdefault((net, y), set()).add(x)
    return {key: sorted(found) for key, found in hops.items()}


def net_of(link: Link, leaders: Mapping[Link, Link]) -> NetName:
    """Return the net that a wire is drawn with."""
    drawn_as = leaders.get(link, link)
    return drawn_as.source, drawn_as.output


def shared(first: Sequence[GridPoint], second: Sequence[GridPoint]) -> int:
    """Return the last point that two wires from one output share, counted from their start."""
    return next((i for i, (a, b) in enumerate(zip(first[1:], second[1:], strict=False)) if a != b), 0)


def drawn_path(
    path: Sequence[tuple[float, float]], dots: Iterable[GridPoint], hops: Mapping[int, Sequence[int]]
) -> str:
    """Return a path with small arcs at its corners, except where wires branch, and over the wires that it crosses."""
    at = path[0]
    out = [f"M{_point(at)}"]
    branching = frozenset(dots)
    for number, ((x, y), after) in enumerate(pairwise([*path[1:], path[-1]])):
        before = path[number]
        near = min(abs(x - before[0]) + abs(y - before[1]), abs(after[0] - x) + abs(after[1] - y))
        radius = 0 if (x, y) in branching else min(_CORNER, near // 2)
        start, end = (
            (x + radius * ((px > x) - (px < x)), y + radius * ((py > y) - (py < y))) for px, py in (before, after)
        )
        out.append(_line(at, start if radius else (x, y), hops))
        if radius:
            out.append(f"Q{_point((x, y))} {_point(end)}")
        at = end if radius else (x, y)
    return "".join(out)


def _line(start: tuple[float, float], end: tuple[float, float], hops: Mapping[int, Sequence[int]]) -> str:
    """Return a straight line, with a bow over each wire that it crosses."""
    (x1, y), (x2, y2) = start, end
    out = []
    if y == y2:
        way = 1 if x2 > x1 else -1
        low, high = min(x1, x2) + _HOP, max(x1, x2) - _HOP
        for x in sorted((x for x in hops.get(int(y), ()) if low <= x <= high), reverse=way < 0):
            out.append(f"L{x - way * _HOP:g} {y:g}a{_HOP} {_HOP} 0 0 {int(way > 0)} {2 * way * _HOP} 0")
    return "".join([*out, f"L{_point(end)}"])


def _point(point: tuple[float, float]) -> str:
    return f"{point[0]:g} {point[1]:g}"
