"""Wires of a large diagram that are named instead of drawn, and parallel wires that run as one.

A diagram that fits a page, whose width and height add up to no more than `PAGE`, does not change.
In a larger one, a wire whose route is longer than `LONGEST`, more than a page is wide, is named: it
ends in a tab at its source and in one at its reader, as a net label does in a schematic. Of two
wires or more from one block to one block, each the only wire of its output, the routes become one
if they are longer than `APART`. Those that are longer than twice `LONGEST`, and the longest of the
others, are named first; then the diagram is laid out anew, until no route is too long.
"""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from math import ceil
from typing import NamedTuple

from proofmass.graphs.drawing.items import Layout, NetName, Spot
from proofmass.graphs.drawing.layers import Link
from proofmass.graphs.drawing.looks import Look
from proofmass.graphs.drawing.routing import GRID, GridPoint

PAGE = 2400  # pixels: 1,400 across and 1,000 down
LONGEST = 1600  # pixels
SHARE = 1 / 16  # of the wires that are drawn: the others may be shorter in the next layout
APART = 300  # pixels: shorter ones are told apart at a glance

Path = tuple[GridPoint, ...]


class Eased(NamedTuple):
    """Wires that are named instead of drawn, and those that run in a bundle, each with the one that leads it."""

    named: frozenset[Link] = frozenset()
    leaders: Mapping[Link, Link] = {}

    @property
    def followers(self) -> frozenset[Link]:
        """Wires of bundles that the route of another stands for."""
        return frozenset(link for link, leader in self.leaders.items() if link != leader)


def eased_of(layout: Layout, paths: Mapping[Link, Path], before: Eased) -> Eased:
    """Return what becomes of the wires of a layout: what was named before stays so."""
    if before == Eased() and layout.width + layout.height <= PAGE:
        return before
    lengths = {link: length(path) for link, path in paths.items()}
    long = sorted((link for link in paths if lengths[link] > LONGEST), key=lambda link: (-lengths[link], link))
    hopeless = sum(lengths[link] > 2 * LONGEST for link in long)
    named = before.named.union(long[: max(hopeless, ceil(len(paths) * SHARE))])
    leaders = dict[Link, Link]()
    for links in _parallel(paths, named):
        if lengths[links[0]] > APART or links[0] in before.leaders:
            leaders |= dict.fromkeys(links, links[len(links) // 2])
    return Eased(named, leaders)


def _parallel(paths: Mapping[Link, Path], named: frozenset[Link]) -> Iterator[list[Link]]:
    """Yield the wires from one block to one block that lead nowhere else, from the upper port to the lower."""
    readers: dict[NetName, list[Link]] = {}
    for link in [*sorted(paths, key=lambda link: (paths[link][0][1], link)), *named.difference(paths)]:
        readers.setdefault((link.source, link.output), []).append(link)
    parallel: dict[tuple[str, str], list[Link]] = {}
    for link, *others in readers.values():
        if not others and not link.driven and link not in named:
            parallel.setdefault((link.source, link.target), []).append(link)
    yield from (links for links in parallel.values() if len(links) > 1)


def length(path: Path) -> int:
    """Return the length of a wire in pixels."""
    return sum(abs(x2 - x1) + abs(y2 - y1) for (x1, y1), (x2, y2) in pairwise(path))


class NamedEnds(NamedTuple):
    """A wire that is named: from its source to the tab there, and from a tab to its reader."""

    source: tuple[GridPoint, GridPoint]
    reader: tuple[GridPoint, GridPoint]


def named_ends(link: Link, spots: Mapping[str, Spot], looks: Mapping[str, Look]) -> NamedEnds:
    """Return the pieces of a wire; a tab as a source has none: its piece is a point."""
    start, way = _pin(spots[link.source], looks[link.source], link.output, is_output=True)
    near, wide = looks[link.source].tabs.get(link.output, (0, 0))
    first = start, (start[0] + way * (near + wide), start[1])
    if link.driven:
        spot, shape = spots[link.target], looks[link.target].shape
        x, bottom = spot.x + shape.driven[link.port], spot.y + shape.height
        return NamedEnds(first, ((x, bottom + looks[link.target].tabs[link.port][0]), (x, bottom)))
    (x, y), way = _pin(spots[link.target], looks[link.target], link.port, is_output=False)
    return NamedEnds(first, ((x - way * looks[link.target].tabs[link.port][0], y), (x, y)))


class Fan(NamedTuple):
    """A bundled wire: out of its port, along the line that stands for all, and into its port."""

    source: Path
    trunk: Path
    reader: Path

    @property
    def whole(self) -> Path:
        """The wire from end to end."""
        return (*self.source, *self.trunk[1:-1], *self.reader)


def fan_of(link: Link, leader: Path, spots: Mapping[str, Spot], looks: Mapping[str, Look]) -> Fan:
    """Return a wire of a bundle; `leader` is the route of the one that leads it."""
    start, way = _pin(spots[link.source], looks[link.source], link.output, is_output=True)
    end, to_way = _pin(spots[link.target], looks[link.target], link.port, is_output=False)
    leave = start[0] + way * (looks[link.source].shape.label // GRID * GRID), leader[0][1]
    enter = end[0] - to_way * 2 * GRID, leader[-1][1]
    source, reader = (start, (leave[0], start[1]), leave), (enter, (enter[0], end[1]), end)
    return Fan(tuple(dict.fromkeys(source)), (leave, *leader[1:-1], enter), tuple(dict.fromkeys(reader)))


def _pin(spot: Spot, look: Look, port: str, is_output: bool) -> tuple[GridPoint, int]:
    """Return where a wire meets a block, and the way signals go there: right or left."""
    shape, way = look.shape, -1 if spot.mirrored else 1
    below = shape.outputs[port] if is_output else shape.inputs[port]
    return (spot.x + shape.width * (is_output != spot.mirrored), spot.y + below), way
