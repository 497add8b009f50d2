"""A graph with subgraphs as one flat graph, whose blocks are named by their paths: `x_axis.adc`."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import NamedTuple

from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.graph import NOWHERE, Graph, Place, Probe, Wire
from proofmass.graphs.model.loops import Loop


@dataclass(frozen=True)
class FlatPlace(Place):
    """Where the blocks and wires of a flat graph stand: in the files of the graphs that they come from."""

    root: Graph | None = None
    origins: Mapping[str, "Origin"] = field(default_factory=dict)  # by wire

    def line(self, path: tuple[str, ...]) -> int:
        """Line of the key in its own file."""
        return self.find(path)[1]

    def find(self, path: tuple[str, ...]) -> tuple[str, int]:
        """File and line of the key, or of the nearest key above it."""
        place, path = self._own(path)
        return place.find(path)

    def _own(self, path: tuple[str, ...]) -> tuple[Place, tuple[str, ...]]:
        if self.root is None:
            return NOWHERE, path
        table, name, *more = (*path[:2], "", "")[:2] + path[2:]
        if table == "wires" and name in self.origins:
            origin = self.origins[name]
            return origin.place, ("wires", origin.wire)
        graph = self.root
        while table == "blocks":
            head, _, tail = name.partition(".")
            if not tail or head not in graph.subgraphs:
                break
            graph, name = graph.subgraphs[head], tail
        return graph.place, (table, name, *more)[: len(path)]


class Origin(NamedTuple):
    """The wire that a wire of the flat graph comes from, as it is written in its graph."""

    place: Place
    path: str  # of the graph, with a dot behind it
    wire: str


def flatten(graph: Graph) -> Graph:
    """The graph without subgraphs: their blocks bear their paths as names, wires end at the blocks inside.

    What a wire, a probe or an export names and what is not there stays as it is written; `check` speaks about it.
    Exports are those of the graph itself; loops inside bear their paths.
    """
    if not graph.subgraphs:
        return graph
    blocks: dict[str, Block] = {}
    rates: dict[str, Fraction] = {}
    wires: list[Wire] = []
    origins: dict[str, Origin] = {}
    loops: dict[str, Loop] = {}
    for path, part, rate in _parts(graph, "", None):
        for name, block in part.blocks.items():
            blocks[path + name] = block
            own = part.rates.get(name, None if type(block).continuous() else rate)
            if own is not None:
                rates[path + name] = own
        for name, loop in part.loops.items():
            loops[path + name] = replace(loop, open_at=path + inside(part, loop.open_at))
        for wire in part.wires:
            flat = Wire(path + inside(part, wire.source), path + inside(part, wire.target))
            wires.append(flat)
            origins.setdefault(str(flat), Origin(part.place, path, str(wire)))
    return Graph(
        name=graph.name,
        description=graph.description,
        rate=graph.rate,
        duration=graph.duration,
        samples=graph.samples,
        seed=graph.seed,
        blocks=blocks,
        rates=rates,
        wires=wires,
        probes=[Probe(inside(graph, probe.signal), probe.every) for probe in graph.probes],
        measures={n: m._replace(signal=inside(graph, m.signal)) for n, m in graph.measures.items()},
        exports={name: inside(graph, signal) for name, signal in graph.exports.items()},
        integration=graph.integration,
        loops=loops,
        place=FlatPlace(graph.place.file, graph.place.lines, graph.place.folder, graph.place.top, graph, origins),
    )


def inside(graph: Graph, signal: str) -> str:
    """The signal of a block for a signal that may go through exports; as it is where there is none.

    `"x_axis.code"` is `"x_axis.adc.code"` where the subgraph `x_axis` exports `code` of its `adc`.
    """
    head, _, tail = signal.partition(".")
    part = graph.subgraphs.get(head)
    if part is None:
        return signal
    if "." in tail:
        return f"{head}.{inside(part, tail)}"
    return f"{head}.{inside(part, part.exports[tail])}" if tail in part.exports else signal


def has_own_rate(flat: Graph, name: str) -> bool:
    """Whether a rate is written at the block itself, not at the graph or a subgraph that it lies in."""
    graph = flat.place.root if isinstance(flat.place, FlatPlace) and flat.place.root is not None else flat
    head, _, tail = name.partition(".")
    while tail and head in graph.subgraphs:
        graph, name = graph.subgraphs[head], tail
        head, _, tail = name.partition(".")
    return name in graph.rates


def parts(graph: Graph) -> Iterator[tuple[str, Graph]]:
    """Every graph inside, itself first, with its path and a dot behind it."""
    return ((path, part) for path, part, _ in _parts(graph, "", None))


def _parts(graph: Graph, path: str, rate: Fraction | None) -> Iterator[tuple[str, Graph, Fraction | None]]:
    """Every graph inside with its path and the rate of its blocks, where that is not the outermost one's."""
    yield path, graph, rate
    for name, part in graph.subgraphs.items():
        yield from _parts(part, f"{path}{name}.", part.rate if part.rate is not None else rate)
