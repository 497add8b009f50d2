"""A graph with subgraphs as one flat graph, whose blocks are named by their paths: `x_axis.adc`."""

import dataclasses
from collections.abc import Iterator, Mapping
from fractions import Fraction
from functools import partial
from typing import Any, NamedTuple

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Graph, Place, Probe, Wire, put_in_order, thawed
from proofmass.graphs.model.integration import Integration
from proofmass.graphs.model.loops import Loop
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.values import NamedValue


class Origin(NamedTuple):
    """Origin of a wire of the flat graph: the wire as written in its graph."""

    place: Place
    path: str  # of the graph, with a dot behind it
    wire: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class FlatGraph:
    """A graph without subgraphs: those fields of its `root` that hold names, with the names of the flat graph.

    Everything else is the root's: a field that is added to `Graph` and holds no name needs nothing
    here.
    """

    root: Graph
    blocks: Mapping[str, Block]
    rates: Mapping[str, Fraction]
    offsets: Mapping[str, Fraction]  # of clocks, in seconds
    wires: tuple[Wire, ...]
    probes: tuple[Probe, ...]
    measures: Mapping[str, Measure]
    exports: Mapping[str, str]
    loops: Mapping[str, Loop]
    origins: Mapping[str, Origin] = dataclasses.field(compare=False, repr=False)  # by wire

    def __post_init__(self) -> None:
        put_in_order(self)

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(FlatGraph, **thawed(self)), ()

    @property
    def rate(self) -> Fraction | None:
        """Rate of the blocks without one of their own, in hertz."""
        return self.root.rate

    @property
    def duration(self) -> Fraction | None:
        """Seconds of a run when nothing else is said."""
        return self.root.duration

    @property
    def samples(self) -> int | None:
        """Base ticks of a run when nothing else is said."""
        return self.root.samples

    @property
    def seed(self) -> int:
        """Seed of a run when nothing else is said."""
        return self.root.seed

    @property
    def integration(self) -> Integration:
        """Integration of continuous blocks."""
        return self.root.integration

    def find(self, path: tuple[str, ...]) -> tuple[str, int]:
        """Return file and line of a key of the flat graph, or of the nearest key above it."""
        table, name, *more = (*path[:2], "", "")[:2] + path[2:]
        if table == "wires" and name in self.origins:
            origin = self.origins[name]
            return origin.place.find(("wires", origin.wire))
        graph = self.root
        while table == "blocks":
            head, _, tail = name.partition(".")
            if not tail or head not in graph.subgraphs:
                break
            graph, name = graph.subgraphs[head], tail
        return graph.place.find((table, name, *more)[: len(path)])

    def placed(self, problem: Problem) -> Problem:
        """Return a problem with the file and line its key has in the file of its block or wire."""
        return problem if problem.file else problem.at(*self.find(problem.path))

    def as_graph(self) -> Graph:
        """Return the same as a graph that has no subgraphs."""
        names = {field.name for field in dataclasses.fields(Graph)} & {field.name for field in dataclasses.fields(self)}
        return self.root.changed(subgraphs={}, values={}, formulas={}, **{name: getattr(self, name) for name in names})


def flatten(graph: Graph) -> FlatGraph:
    """Return the graph without subgraphs: blocks inside are named by their paths, and wires end at them.

    Names of missing blocks or ports stay as written; `check` reports them. Exports are those of the
    graph itself; loops inside are named by their paths.
    """
    blocks: dict[str, Block] = {}
    rates: dict[str, Fraction] = {}
    offsets: dict[str, Fraction] = {}
    wires: list[Wire] = []
    origins: dict[str, Origin] = {}
    loops: dict[str, Loop] = {}
    for path, part, rate, later in _parts(graph):
        for name, block in part.blocks.items():
            offset = part.offsets.get(name, Fraction(0))
            if not type(block).continuous():
                offset += later
            if offset:
                offsets[path + name] = offset
            blocks[path + name] = block
            own = part.rates.get(name, None if type(block).continuous() else rate)
            if own is not None:
                rates[path + name] = own
        for name, loop in part.loops.items():
            loops[path + name] = dataclasses.replace(loop, open_at=path + inside(part, loop.open_at))
        for wire in part.wires:
            flat = Wire(path + inside(part, wire.source), path + inside(part, wire.target))
            wires.append(flat)
            origins.setdefault(str(flat), Origin(part.place, path, str(wire)))
    return FlatGraph(
        root=graph,
        blocks=blocks,
        rates=rates,
        offsets=offsets,
        wires=tuple(wires),
        probes=tuple(probe._replace(signal=inside(graph, probe.signal)) for probe in graph.probes),
        measures={n: m._replace(signal=inside(graph, m.signal)) for n, m in graph.measures.items()},
        exports={name: inside(graph, signal) for name, signal in graph.exports.items()},
        loops=loops,
        origins=origins,
    )


def inside(graph: Graph, signal: str) -> str:
    """Return the signal of a block for a signal that may go through exports; unchanged if it does not exist.

    `"x_axis.code"` is `"x_axis.adc.code"` where the subgraph `x_axis` exports `code` of its `adc`.
    """
    head, _, tail = signal.partition(".")
    part = graph.subgraphs.get(head)
    if part is None:
        return signal
    if "." in tail:
        return f"{head}.{inside(part, tail)}"
    return f"{head}.{inside(part, part.exports[tail])}" if tail in part.exports else signal


def has_own_rate(flat: FlatGraph, name: str) -> bool:
    """Return whether a block has a clock offset, or a rate of its own instead of that of the graph around it."""
    if name in flat.offsets:
        return True
    graph = flat.root
    head, _, tail = name.partition(".")
    while tail and head in graph.subgraphs:
        graph, name = graph.subgraphs[head], tail
        head, _, tail = name.partition(".")
    return name in graph.rates


def parts(graph: Graph) -> Iterator[tuple[str, Graph]]:
    """Return all graphs inside, itself first, each with its path and a dot."""
    return ((path, part) for path, part, _, _ in _parts(graph))


def values_of(graph: Graph) -> dict[str, NamedValue]:
    """Return the values of a graph and of all graphs inside, by their paths."""
    return {path + name: value for path, part in parts(graph) for name, value in part.values.items()}


def _parts(
    graph: Graph, path: str = "", rate: Fraction | None = None, later: Fraction = Fraction(0)
) -> Iterator[tuple[str, Graph, Fraction | None, Fraction]]:
    """Yield every graph inside with its path, the rate of its blocks, if it differs from the root's, and offset."""
    yield path, graph, rate, later
    for name, part in graph.subgraphs.items():
        own = part.rate if part.rate is not None else rate
        yield from _parts(part, f"{path}{name}.", own, later + graph.offsets.get(name, Fraction(0)))
