"""Layers of a block diagram: feedback wires, return paths, and the column of each block."""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

from proofmass.graphs.model.digraph import alphabetical, loops, turned

Edge = tuple[str, str]


class Link(NamedTuple):
    """A wire in a diagram: from an output to an input, or to a parameter that it drives."""

    source: str
    output: str
    target: str
    port: str
    driven: bool


class Layers(NamedTuple):
    """Layers of blocks, counted from the left, and blocks that face left, leading back."""

    of: Mapping[str, int]
    mirrored: frozenset[str]


def assign_layers(
    names: Iterable[str], links: Iterable[Link], exits: Iterable[str] = (), noises: Iterable[str] = ()
) -> Layers:
    """Return longest-path layers of the blocks without the feedback wires.

    `exits` are blocks with an output that somebody looks at, `noises` are sources that no loop is
    there for: a loop starts where another signal enters it. What comes in a loop after its last
    exit is a return path: it is drawn from right to left below the forward path, as long as it is
    no longer than that.
    """
    wiring = _Wiring(sorted(names), sorted(links), frozenset(noises))
    mirrored: frozenset[str] = frozenset()
    for core, head in sorted(wiring.cores.items(), key=lambda item: item[1]):
        steps = wiring.steps_to_the_end(core, head, set(exits))
        fits, too_long = 0, max(steps.values(), default=0) + 1
        while too_long - fits > 1:
            tried = (fits + too_long) // 2
            wanted = mirrored | wiring.with_sources({name for name, step in steps.items() if step <= tried})
            fits, too_long = (tried, too_long) if wiring.layers(wanted) else (fits, tried)
        if fits:
            mirrored |= wiring.with_sources({name for name, step in steps.items() if step <= fits})
    found = wiring.layers(mirrored) or {}
    first = min(found.values(), default=0)
    return Layers({name: layer - first for name, layer in found.items()}, mirrored)


def signal_order(names: Iterable[str], links: Iterable[Link]) -> list[str]:
    """Return blocks in the order a signal reaches them, each loop from where it is entered."""
    return _Wiring(sorted(names), sorted(links), frozenset()).order


class _Wiring:
    """Blocks and edges, with feedback edges separated."""

    def __init__(self, names: list[str], links: list[Link], noises: frozenset[str]) -> None:
        self.noises = noises
        self.edges = sorted({(link.source, link.target) for link in links})
        self.into: dict[str, list[Edge]] = {name: [] for name in names}
        for edge in self.edges:
            self.into[edge[1]].append(edge)
        self.signals = {(link.source, link.target) for link in links if not link.driven}
        self.back: set[Edge] = {edge for edge in self.edges if edge[0] == edge[1]}
        self.cores: dict[frozenset[str], str] = {}  # sets of connected loops, with the block at which each set starts
        self._cut(names)
        self.before = {name: sorted(edge[0] for edge in self.into[name] if edge not in self.back) for name in names}
        self.after = {name: sorted(after) for name, after in turned(self.before).items()}
        self.order: list[str] = list(alphabetical(self.before))

    def _cut(self, names: list[str]) -> None:
        """Separate feedback edges, those into the block where a signal enters a loop, until no loop is left."""
        stack = [frozenset(names)]
        while stack:
            nodes = stack.pop()
            before = {n: [e[0] for e in self.into[n] if e not in self.back and e[0] in nodes] for n in sorted(nodes)}
            for core in map(frozenset, loops(before)):
                head = min(core, key=lambda name: self._as_start(name, core))
                if len(nodes) == len(names):
                    self.cores[core] = head
                self.back |= {edge for edge in self.into[head] if edge[0] in core}
                stack.append(core)

    def _as_start(self, name: str, core: frozenset[str]) -> tuple[bool, int, str]:
        entries = self.into[name]
        entered = any(edge[0] not in core and edge[0] not in self.noises for edge in entries if edge in self.signals)
        cost = sum(2 if edge in self.signals else 1 for edge in entries if edge[0] in core and edge not in self.back)
        return not entered, cost, name

    def steps_to_the_end(self, core: frozenset[str], head: str, exits: set[str]) -> dict[str, int]:
        """Return the blocks of a loop after its last exit, counted from the end of the loop."""
        left = {edge[0] for edge in self.edges if edge[0] in core and edge[1] not in core} | (exits & core) | {head}
        steps: dict[str, int] = {}
        for name in reversed(self.order):
            following = [after for after in self.after[name] if after in core]
            if name in core and name not in left and all(after in steps for after in following):
                steps[name] = max((steps[after] for after in following), default=0) + 1
        return steps

    def with_sources(self, mirrored: set[str]) -> frozenset[str]:
        """Add the blocks without an input that feed return paths only."""
        return frozenset(mirrored).union(
            name
            for name in self.order
            if not self.before[name]
            and self.after[name]
            and all(after in mirrored and (name, after) in self.signals for after in self.after[name])
        )

    def layers(self, mirrored: frozenset[str]) -> dict[str, int] | None:
        """Return a layer for every block, or None if a return path is longer than its path."""
        layer: dict[str, int] = {}
        for name in self.order:
            if name not in mirrored:
                layer[name] = max((layer[u] + 1 for u in self.before[name] if u not in mirrored), default=0)
        self._pull(layer, mirrored)
        cores = {name: core for core in self.cores for name in core}
        for name in self.order:
            if name in mirrored and name in cores:
                known = [layer[u] - (u in mirrored) for u in self.before[name] if u in cores[name] and u in layer]
                if known:
                    layer[name] = min(known)
        for name in reversed(self.order):
            if name in mirrored and name not in layer:
                layer[name] = max((layer[v] for v in self.after[name] if v in layer), default=0) + 1
        self._pull(layer, mirrored)
        fits = all(layer[v] <= layer[u] for u, v in self.back if u in mirrored and v not in mirrored)
        return layer if fits else None

    def _pull(self, layer: dict[str, int], mirrored: frozenset[str]) -> None:
        """Move blocks with more outgoing wires towards their readers, for short wires."""
        for name in reversed(self.order):
            after = [v for v in self.after[name] if v in layer]
            if name not in mirrored and after and len(self.before[name]) < len(self.after[name]):
                nearest = min(layer[v] - (0 if v in mirrored and (name, v) in self.signals else 1) for v in after)
                layer[name] = max(layer[name], nearest)
