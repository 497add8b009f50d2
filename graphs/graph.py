"""A graph: blocks by name, wires, rates and probes. A frozen value, the same from Python and from TOML."""

import dataclasses
import re
from collections.abc import Iterable, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

from proofmass.blocks.declare import Block
from proofmass.blocks.problem import ModelError, Problem, did_you_mean, shown
from proofmass.blocks.units import UnitError
from proofmass.graphs.rates import Rate, read_rate

if TYPE_CHECKING:
    import networkx

NAME = re.compile(r"(?=.{1,64}$)[a-z][a-z0-9]*(_[a-z0-9]+)*")
LARGEST_RUN = 10**12  # ticks


class Wire(NamedTuple):
    """A wire from an output port to an input port, or to a parameter that it drives."""

    source: str
    target: str

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


class Probe(NamedTuple):
    """An output port whose values are recorded: all, or one in `every` of its ticks."""

    signal: str
    every: int = 1


@dataclasses.dataclass(frozen=True)
class Place:
    """Where a graph was read from: the file, the line of each key, and the folder its file names start from."""

    file: str = ""
    lines: Mapping[tuple[str, ...], int] = dataclasses.field(default_factory=dict)
    folder: str = "."

    def line(self, path: tuple[str, ...]) -> int:
        """Line of the key, or of the nearest key above it."""
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path, 0)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Graph:
    """Blocks wired by their ports, at stated rates, with the signals to record.

    `wires` are texts like `"adc.code -> correlator.code"`; the target may be a parameter, which the wire then drives.
    `rates` gives blocks a rate of their own; all others run at `rate`. `duration` (or `samples`, in base ticks) and
    `seed` are what a run takes when nothing else is said.

    Raises `ModelError` with every problem when a text, a name or a rate cannot be read; `check` looks at the wiring.
    """

    name: str
    description: str = ""
    rate: Rate | None = None
    duration: Fraction | str | float | None = None
    samples: int | None = None
    seed: int = 0
    blocks: Mapping[str, Block]
    rates: Mapping[str, Rate] = dataclasses.field(default_factory=dict)
    wires: Iterable[Wire | str] = ()
    probes: Iterable[Probe | str] = ()
    place: Place = dataclasses.field(default_factory=Place, compare=False, repr=False)

    def __post_init__(self) -> None:
        problems: list[Problem] = []
        put = object.__setattr__
        put(self, "blocks", MappingProxyType(dict(sorted(self.blocks.items()))))
        put(self, "wires", tuple(sorted(_each(read_wire, self.wires, "wires", problems))))
        put(self, "probes", tuple(_each(read_probe, self.probes, "probes", problems)))
        rates = {}
        for name, rate in self.rates.items():
            path = ("blocks", name, "rate")
            rates[name] = _read(read_rate, rate, path, problems)
            if name not in self.blocks:
                problems.append(
                    Problem(
                        message="there is no such block",
                        key=f"rates.{name}",
                        hint=did_you_mean(name, self.blocks, "block"),
                        path=path,
                    )
                )
        put(self, "rates", MappingProxyType(dict(sorted(rates.items()))))
        if self.rate is not None:
            put(self, "rate", _read(read_rate, self.rate, ("rate",), problems))
        if self.duration is not None:
            put(self, "duration", _read(read_duration, self.duration, ("duration",), problems))
        problems += [*_bad_names(self), *_bad_run(self)]
        if problems:
            raise ModelError([self.placed(problem) for problem in problems])

    def placed(self, problem: Problem) -> Problem:
        """A problem with the file and line that its key has in this graph."""
        return problem.at(self.place.file, self.place.line(problem.path))

    def with_parameters(self, changes: Mapping[str, object]) -> "Graph":
        """The same graph with parameters changed, as in `{"adc.reference": "5 V"}`; raises `ModelError`."""
        blocks, problems = dict(self.blocks), []
        by_block: dict[str, dict[str, object]] = {}
        for key, value in changes.items():
            block, _, parameter = key.partition(".")
            if block not in blocks:
                hint = did_you_mean(block, blocks, "block")
                problems.append(Problem(message="there is no such block", key=key, got=block, hint=hint))
            else:
                by_block.setdefault(block, {})[parameter] = value
        for name, values in by_block.items():
            try:
                blocks[name] = type(blocks[name])(**(_parameters(blocks[name]) | values))
            except ModelError as error:
                problems += [dataclasses.replace(p, key=f"{name}.{p.path[0]}", path=()) for p in error.problems]
        if problems:
            raise ModelError(problems)
        return dataclasses.replace(self, blocks=blocks)

    def to_networkx(self) -> "networkx.MultiDiGraph[str]":
        """The graph for networkx: a node per block with its declaration, an edge per wire with both ports."""
        import networkx

        out: networkx.MultiDiGraph[str] = networkx.MultiDiGraph(name=self.name)
        for name, block in self.blocks.items():
            out.add_node(name, kind=type(block).__name__, **_parameters(block))
        for wire in self.wires:
            source, target = split(wire.source), split(wire.target)  # type: ignore[union-attr]
            out.add_edge(source[0], target[0], source=source[1], target=target[1])
        return out

    def _repr_svg_(self) -> str:
        from proofmass.graphs.diagram import svg

        return svg(self)


def split(signal: str) -> tuple[str, str]:
    """Block and port of `"block.port"`."""
    block, _, port = signal.partition(".")
    return block, port


def read_wire(text: object) -> Wire:
    """A wire from `"block.port -> block.port"`."""
    if isinstance(text, Wire):
        return text
    ends = [end.strip() for end in text.split("->")] if isinstance(text, str) else []
    if len(ends) != 2 or not all(_is_signal(end) for end in ends):
        raise UnitError("not a wire", 'write "block.output -> block.input"')
    return Wire(*ends)


def read_probe(value: object) -> Probe:
    """A probe from `"block.port"`, or from a table with `signal` and `every`."""
    if isinstance(value, str):
        value = {"signal": value}
    if isinstance(value, Probe):
        value = value._asdict()
    if not isinstance(value, Mapping) or not set(value) <= {"signal", "every"} or not _is_signal(value.get("signal")):
        raise UnitError("not a probe", 'write "block.output" or { signal = "block.output", every = 10 }')
    every = value.get("every", 1)
    if isinstance(every, bool) or not isinstance(every, int) or not 1 <= every <= LARGEST_RUN:
        raise UnitError("every must be an integer of at least 1")
    return Probe(value["signal"], every)


def read_duration(value: object) -> Fraction:
    """A duration in seconds, exactly."""
    from proofmass.blocks.units import convert_exactly

    if isinstance(value, str):
        seconds = convert_exactly(value, "s")
    elif isinstance(value, bool) or not isinstance(value, int | float | Fraction) or value != value or value > 1e300:
        raise UnitError("must be a duration", 'write it as "20 s"')
    else:
        seconds = Fraction(repr(value)) if isinstance(value, float) else Fraction(value)
    if seconds < 0:
        raise UnitError("must not be negative")
    return seconds


def _parameters(block: Block) -> dict[str, Any]:
    return {name: getattr(block, name) for name in block.parameters}


def _is_signal(text: object) -> bool:
    return isinstance(text, str) and all(NAME.fullmatch(part) for part in text.split(".")) and text.count(".") == 1


def _read(reader: Any, value: object, path: tuple[str, ...], problems: list[Problem]) -> Any:
    try:
        return reader(value)
    except UnitError as error:
        key = ".".join(path)
        problems.append(Problem(message=str(error), key=key, got=shown(value), hint=error.hint, path=path))
        return None


def _each(reader: Any, values: Iterable[Any], key: str, problems: list[Problem]) -> list[Any]:
    read = [_read(reader, value, (key, str(i)), problems) for i, value in enumerate(values)]
    return [value for value in read if value is not None]


def _bad_names(graph: Graph) -> list[Problem]:
    expected = "at most 64 lower-case letters and digits, words joined by single underscores"
    return [
        Problem(message="not a name", key="blocks", got=shown(name), expected=expected, path=("blocks", name))
        for name in graph.blocks
        if not NAME.fullmatch(name)
    ]


def _bad_run(graph: Graph) -> list[Problem]:
    problems = []
    for name, largest in (("samples", LARGEST_RUN), ("seed", 2**62)):
        value = getattr(graph, name)
        lowest = 1 if name == "samples" else 0
        if value is not None and (isinstance(value, bool) or not isinstance(value, int) or not lowest <= value <= largest):
            expected = f"an integer from {lowest} to {largest:g}"
            problems.append(
                Problem(message="out of range", key=name, got=shown(value), expected=expected, path=(name,))
            )
    if graph.samples is not None and graph.duration is not None:
        problems.append(Problem(message="give samples or duration, not both", key="samples", path=("samples",)))
    return problems
