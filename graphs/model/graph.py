"""A graph: blocks by name, wires, rates and probes. A plain frozen value, the same from Python and from TOML.

A block may be a graph of its own, a subgraph, with the ports and parameters that it exports.
`build` reads texts and tables into such a value; nothing is read here.
"""

import copyreg
import dataclasses
from collections.abc import Iterable, Mapping
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import Any, NamedTuple, Self, TypeVar

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.model.integration import Integration
from proofmass.graphs.model.keys import Integer, Text, key
from proofmass.graphs.model.limits import LARGEST_RUN, LARGEST_SEED
from proofmass.graphs.model.loops import Loop
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.requirements import Requirement
from proofmass.graphs.model.values import NamedValue

DEFAULT_INTEGRATION = Integration()

_ASKING = ("measures", "derived", "loops", "requirements")  # that name signals, loops and others

Endpoint = tuple[str, str]  # of a wire: block and port
AnyGraph = TypeVar("AnyGraph", bound="Graph")


class Wire(NamedTuple):
    """A wire from an output port to an input port, or to a parameter that it drives.

    >>> from proofmass import Wire
    >>> str(Wire("adc.code", "correlator.code"))
    'adc.code -> correlator.code'
    """

    source: str  # "block.output"
    target: str  # "block.input", or a parameter, "block.parameter"

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


class GraphSize(NamedTuple):
    """Size of a graph, with everything inside its subgraphs."""

    blocks: int
    wires: int
    depth: int


class Probe(NamedTuple):
    """An output port whose values are recorded: all, or one in `every` of its ticks.

    >>> from proofmass import Probe, read_graph
    >>> read_graph("library:template").probes[0] == Probe("sensor.displacement", every=1)
    True
    """

    signal: str  # "block.output"
    every: int = 1  # ticks of the block from row to row
    unit: str = ""  # in which tables and pictures show it, such as "deg/h"; the values are in that of the port


@dataclasses.dataclass(frozen=True)
class Place:
    """The place from which a graph was read: file, line of each key, and the folder that file names start from."""

    file: str = ""
    lines: dict[tuple[str, ...], int] = dataclasses.field(default_factory=dict)
    folder: str = "."

    top: tuple[str, ...] = ()  # keys above a graph that is a table inside another

    def line(self, path: tuple[str, ...]) -> int:
        """Line of the key, or of the nearest key above it."""
        path = self.top + path
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path, 0)

    def has(self, path: tuple[str, ...]) -> bool:
        """Return whether the key itself stands in the file."""
        return self.top + path in self.lines

    def find(self, path: tuple[str, ...]) -> tuple[str, int]:
        """File and line of the key, or of the nearest key above it."""
        return self.file, self.line(path)

    def placed(self, problem: Problem) -> Problem:
        """Return a problem with the file and line that its key has, unless it has them already."""
        return problem if problem.file else problem.at(*self.find(problem.path))

    def in_order(self, problems: Iterable[Problem]) -> list[Problem]:
        """Return problems with their files and lines, in their order; those of the file itself come first."""
        placed = map(self.placed, problems)
        return sorted(placed, key=lambda problem: (problem.file != self.file, problem.file, problem.line))


NOWHERE = Place()


_NAMED = 5  # probes in a line


@dataclasses.dataclass(frozen=True, kw_only=True)
class Placed:
    """Something that stands in a file; its problems have the lines of their keys there."""

    place: Place = dataclasses.field(compare=False, repr=False)  # file and lines that it comes from

    def placed(self, problem: Problem) -> Problem:
        """Return a problem with the file and line that its key has, unless it has them already."""
        return self.place.placed(problem)


@dataclasses.dataclass(frozen=True, kw_only=True, repr=False)
class Graph(Placed):
    """Blocks wired by their ports, at stated rates, with the signals to record: typed values, already checked.

    A field by `key` is a key of graph files: reader, schema, writer and hints take it from here.
    Tables and wires are in alphabetical order: the order of declaration makes no difference.
    """

    name: str = key("Name of the graph, in plots and reports.", Text())
    description: str = key("What the graph is, in a few lines.", Text())
    rate: Fraction | None = key(
        'Rate of every block that has none of its own: "50 kHz", or the period "20 us", or a number in hertz.'
    )
    duration: Fraction | None = key('How long a run lasts when nothing else is said: "20 s", or a number in seconds.')
    samples: int | None = key(
        "How many ticks of the base rate a run lasts, instead of a duration.", Integer(1, LARGEST_RUN, None)
    )
    seed: int = key("Seed of the noise when nothing else is said.", Integer(0, LARGEST_SEED, 0))
    values: Mapping[str, NamedValue] = key(
        'Named values, mass = "50 ug"; parameters take them by formulas, "= mass" or "= 2 * pi * f0 / q".'
    )
    formulas: Mapping[str, Formula] = key(
        'Formulas of parameters inside subgraphs, "x_axis.mass" = "= mass"; others stand at their blocks.'
    )
    wires: tuple[Wire, ...] = key('Wires, "block.output -> block.input"; a wire to a parameter drives the parameter.')
    probes: tuple[Probe, ...] = key(
        'Outputs to record, "block.output"; { signal = "block.output", every = 10 } keeps one value in ten.'
    )
    measures: Mapping[str, Measure] = key(
        'Numbers that a run reduces signals to: { signal = "block.output", statistic = "mean", from = "1 s" }.'
    )
    derived: Mapping[str, Formula]  # measures of measures
    exports: Mapping[str, str] = key(
        'Ports and parameters that the graph has as a part of others: a name for each, as in code = "adc.code".'
    )
    integration: Integration = key("How continuous blocks are integrated between ticks: method, accuracy, events.")
    loops: Mapping[str, Loop] = key("Control loops: [loops.NAME] with open_at, and the margins that it must have.")
    requirements: Mapping[str, Requirement] = key(
        "What measures, margins, noise or yields must keep, by ids; `proofmass verify` looks at them."
    )
    blocks: Mapping[str, Block] = key(
        "The blocks: [blocks.NAME] with a kind and the parameters of that kind, or with a graph."
    )
    subgraphs: "Mapping[str, Graph]"  # the blocks that are graphs
    rates: Mapping[str, Fraction]  # Hz, of blocks that have one of their own
    offsets: Mapping[str, Fraction]  # s, of clocks; those of subgraphs count for all that is inside

    def __post_init__(self) -> None:
        put_in_order(self)

    def __repr__(self) -> str:
        """Name, size and probes, in a line."""
        size = f"{len(self.blocks) + len(self.subgraphs)} blocks, {len(self.wires)} wires"
        probes = ", ".join(probe.signal for probe in self.probes[:_NAMED])
        more = ", ..." if len(self.probes) > _NAMED else ""
        return f"<Graph {self.name!r}: {size}; {probes + more or 'no probes'}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (type(self), thawed(self))

    def changed(self, **values: Any) -> Self:
        """Return the graph with other values of these fields, neither read nor checked."""
        return _restored(type(self), thawed(self) | values)

    def bare(self, **values: Any) -> Self:
        """Return the graph with nothing that asks of a run but what `values` say: probes, measures, loops."""
        return self.changed(**{**{key: {} for key in _ASKING}, "probes": (), **values})

    @cached_property
    def size(self) -> GraphSize:
        """Number of blocks and wires, and depth of nested graphs."""
        return size_of(len(self.blocks), self.subgraphs, len(self.wires))


def _frozen(table: dict[str, Any]) -> MappingProxyType[str, Any]:
    return MappingProxyType(table)


# frozen tables stand in studies at any depth, and Python copies and pickles none
copyreg.pickle(MappingProxyType, lambda table: (_frozen, (dict(table),)))


def put_in_order(value: Any) -> None:
    """Freeze the tables of a new value, and put them and its wires in order."""
    for field in dataclasses.fields(value):
        entry = getattr(value, field.name)
        if isinstance(entry, Mapping):
            object.__setattr__(value, field.name, MappingProxyType(dict(sorted(entry.items()))))
    object.__setattr__(value, "wires", tuple(sorted(value.wires)))


def thawed(value: Any) -> dict[str, Any]:
    """Return the fields of a frozen value by name, its tables as dictionaries: what can be sent to another process."""
    fields = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    return {key: dict(entry) if isinstance(entry, MappingProxyType) else entry for key, entry in fields.items()}


def size_of(blocks: int, parts: Mapping[str, Graph], wires: int) -> GraphSize:
    """Return the size of a graph with so many blocks and wires of its own, and these subgraphs."""
    sizes = [part.size for part in parts.values()]
    return GraphSize(
        blocks + sum(size.blocks for size in sizes),
        wires + sum(size.wires for size in sizes),
        max((size.depth + 1 for size in sizes), default=0),
    )


def _restored(kind: type[AnyGraph], values: dict[str, Any]) -> AnyGraph:
    """Return a graph of checked values, whatever the constructor of its class."""
    graph = kind.__new__(kind)
    Graph.__init__(graph, **values)
    return graph


def split(signal: str) -> tuple[str, str]:
    """Block and port of `"block.port"`; the block may be a path, as in `"x_axis.adc.code"`.

    >>> split("x_axis.adc.code")
    ('x_axis.adc', 'code')
    """
    block, _, port = signal.rpartition(".")
    return block, port
