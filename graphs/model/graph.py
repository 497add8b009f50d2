"""A graph: blocks by name, wires, rates and probes. A frozen value, the same from Python and from TOML.

A block may be a graph of its own, a subgraph, with the ports and parameters that it exports.
"""

import dataclasses
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard, TypeVar

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.blocks.declaration.units import UnitError
from proofmass.graphs.model.hints import like
from proofmass.graphs.model.integration import Integration, read_integration
from proofmass.graphs.model.keys import BLOCK_KEYS, PART_KEYS
from proofmass.graphs.model.limits import BLOCKS, DEPTH, EXPECTED_NAME, NAME, WIRES
from proofmass.graphs.model.loops import Loop, read_loops
from proofmass.graphs.model.measures import Measure, read_measures
from proofmass.graphs.model.rates import Rate, read_rate
from proofmass.graphs.model.rates import read_duration as read_duration

if TYPE_CHECKING:
    import networkx

LARGEST_RUN = 10**12  # ticks
LARGEST_SEED = 2**62
LONGEST_TEXT = 10_000  # characters of name and description
DEFAULT_INTEGRATION = Integration()

Value = TypeVar("Value")


class Wire(NamedTuple):
    """A wire from an output port to an input port, or to a parameter that it drives."""

    source: str
    target: str

    def __str__(self) -> str:
        return f"{self.source} -> {self.target}"


class Size(NamedTuple):
    """What a graph holds, all that lies inside its subgraphs included."""

    blocks: int
    wires: int
    depth: int


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

    top: tuple[str, ...] = ()  # keys above a graph that is a table inside another

    def line(self, path: tuple[str, ...]) -> int:
        """Line of the key, or of the nearest key above it."""
        path = self.top + path
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path, 0)

    def find(self, path: tuple[str, ...]) -> tuple[str, int]:
        """File and line of the key, or of the nearest key above it."""
        return self.file, self.line(path)


NOWHERE = Place()


@dataclasses.dataclass(frozen=True, init=False)
class Graph:
    """Blocks wired by their ports, at stated rates, with the signals to record.

    A block may be a graph: `blocks={"x_axis": Graph(...)}`. Outside it has the ports and parameters of its `exports`,
    `{"code": "adc.code"}`; everything inside can be named by its path, `x_axis.adc.code`. A rate given to it is that
    of its blocks without a rate of their own. Its probes, measures, duration, samples, seed and integration count only
    where it runs alone.

    `wires` are texts like `"adc.code -> correlator.code"`; the target may be a parameter, which the wire then drives.
    `rates` gives blocks a rate of their own; all others run at `rate`. `duration` (or `samples`, in base ticks) and
    `seed` are what a run takes when nothing else is said; `integration` says how continuous blocks are integrated.
    `loops` names control loops for their margins, `{"main": {"open_at": "dac.voltage"}}`.
    `measures` are numbers that a run reduces signals to,
    `{"bias": {"signal": "dac.code", "statistic": "mean", "from": "0.5 s"}}`.

    Raises `ModelError` with every problem when a text, a name or a rate cannot be read; `check` looks at the wiring.
    """

    name: str
    description: str
    rate: Fraction | None  # in hertz
    duration: Fraction | None  # in seconds
    samples: int | None
    seed: int
    blocks: Mapping[str, Block]
    subgraphs: "Mapping[str, Graph]"  # the blocks that are graphs
    rates: Mapping[str, Fraction]
    wires: tuple[Wire, ...]
    probes: tuple[Probe, ...]
    measures: Mapping[str, Measure]
    exports: Mapping[str, str]
    integration: Integration
    loops: Mapping[str, Loop]
    place: Place = dataclasses.field(compare=False, repr=False)

    def __init__(
        self,
        *,
        name: str,
        blocks: "Mapping[str, Block | Graph]",
        wires: Iterable[Wire | str] = (),
        probes: Iterable[Probe | str | Mapping[str, Any]] = (),
        rate: Rate | None = None,
        rates: Mapping[str, Rate] = MappingProxyType({}),
        duration: Rate | None = None,
        samples: int | None = None,
        seed: int = 0,
        description: str = "",
        measures: Mapping[str, Measure | Mapping[str, Any]] = MappingProxyType({}),
        exports: Mapping[str, str] = MappingProxyType({}),
        loops: "Mapping[str, Loop | Mapping[str, Any]]" = MappingProxyType({}),
        subgraphs: "Mapping[str, Graph]" = MappingProxyType({}),
        integration: Integration | Mapping[str, Any] = DEFAULT_INTEGRATION,
        place: Place = NOWHERE,
    ) -> None:
        blocks = {**subgraphs, **blocks}
        problems = [*_bad_texts(name, description), *_bad_run(samples, duration, seed), *_bad_blocks(blocks, rates)]
        own_loops, wrong = read_loops(loops, _is_path)
        problems += [*_bad_exports(exports), *wrong]

        def read(reader: Callable[[object], Value], value: object, *path: str) -> Value | None:
            try:
                return reader(value)
            except UnitError as error:
                key = ".".join(path)
                problems.append(Problem(message=str(error), key=key, got=shown(value), hint=error.hint, path=path))
                return None

        def read_each(reader: Callable[[object], Value], values: Iterable[object], key: str) -> list[Value]:
            if isinstance(values, str):
                problems.append(Problem(message="must be a list", key=key, got=shown(values), path=(key,)))
                return []
            found = [read(reader, value, key, str(index)) for index, value in enumerate(values)]
            return [value for value in found if value is not None]

        own_rates = {block: read(read_rate, rates[block], "blocks", block, "rate") for block in sorted(rates)}
        parts = {n: b for n, b in sorted(blocks.items()) if isinstance(b, Graph)}
        problems += _too_many(blocks, parts, tuple(wires) if parts else ())
        if not problems:
            parts = {name: _inside(part, own_rates.pop(name, None), place) for name, part in parts.items()}
        values = {
            "name": name,
            "description": description,
            "rate": None if rate is None else read(read_rate, rate, "rate"),
            "duration": None if duration is None else read(read_duration, duration, "duration"),
            "samples": samples,
            "seed": seed,
            "blocks": MappingProxyType({n: b for n, b in sorted(blocks.items()) if not isinstance(b, Graph)}),
            "subgraphs": MappingProxyType(parts),
            "rates": MappingProxyType(own_rates),
            "wires": tuple(sorted(read_each(read_wire, wires, "wires"))),
            "probes": tuple(read_each(read_probe, probes, "probes")),
            "exports": MappingProxyType(dict(sorted(exports.items())) if isinstance(exports, Mapping) else {}),
            "measures": MappingProxyType({}),
            "integration": DEFAULT_INTEGRATION,
            "loops": MappingProxyType(own_loops),
            "place": place,
        }
        tables: dict[str, Callable[[], Any]] = {
            "measures": lambda: MappingProxyType(read_measures(measures)),
            "integration": lambda: read_integration(integration),
        }
        for table, made in tables.items():
            try:
                values[table] = made()
            except ModelError as error:
                problems += error.problems
        for field, value in values.items():
            object.__setattr__(self, field, value)
        if problems:
            raise ModelError([self.placed(problem) for problem in problems])

    def __reduce__(self) -> "tuple[Any, ...]":
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        tables = {key: dict(value) for key, value in values.items() if isinstance(value, MappingProxyType)}
        return _rebuilt, (values | tables,)

    @cached_property
    def size(self) -> "Size":
        """How many blocks and wires there are, and how deep graphs lie inside each other."""
        return _size(len(self.blocks), self.subgraphs.values(), len(self.wires))

    def placed(self, problem: Problem) -> Problem:
        """A problem with the file and line that its key has in this graph, unless it has them already."""
        return problem if problem.file else problem.at(*self.place.find(problem.path))

    def with_parameters(self, changes: Mapping[str, object]) -> "Graph":
        """The same graph with parameters changed, as in `{"adc.reference": "5 V"}`; raises `ModelError`.

        A parameter of a subgraph is named by its path, `"x_axis.adc.reference"`, or as it is exported,
        `"x_axis.reference"`.
        """
        from proofmass.graphs.model.changes import with_parameters

        return with_parameters(self, changes)  # pyright: ignore

    def to_networkx(self) -> "networkx.MultiDiGraph[str]":
        """The flat graph for networkx: a node per block with its declaration, an edge per wire with both ports."""
        import networkx

        from proofmass.graphs.model.flatten import flatten

        flat = flatten(self)  # pyright: ignore[reportArgumentType]
        out: networkx.MultiDiGraph[str] = networkx.MultiDiGraph(name=self.name)
        for name, block in flat.blocks.items():
            out.add_node(name, kind=type(block).__name__, **_parameters(block))
        for wire in flat.wires:
            source, target = split(wire.source), split(wire.target)
            out.add_edge(source[0], target[0], source=source[1], target=target[1])
        return out

    def _repr_svg_(self) -> str:
        from proofmass.graphs.drawing.diagram import svg

        return svg(self)  # pyright: ignore[reportArgumentType]  # it sees this file twice, by its folder and by its link


def split(signal: str) -> tuple[str, str]:
    """Block and port of `"block.port"`; the block may be a path, as in `"x_axis.adc.code"`.

    >>> split("x_axis.adc.code")
    ('x_axis.adc', 'code')
    """
    block, _, port = signal.rpartition(".")
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


def _parameters(block: Block) -> dict[str, Any]:
    return {name: getattr(block, name) for name in type(block).parameters}


def _is_signal(text: object) -> bool:
    return isinstance(text, str) and text.count(".") > 0 and _is_path(text)


def _is_path(text: str) -> bool:
    return text.count(".") <= DEPTH + 1 and all(NAME.fullmatch(part) for part in text.split("."))


def _rebuilt(values: dict[str, Any]) -> Graph:
    """A graph sent to another process, or copied."""
    return Graph(**values)


def _bad_texts(name: object, description: object) -> Iterator[Problem]:
    for key, text in (("name", name), ("description", description)):
        if not isinstance(text, str):
            yield Problem(message="must be a string", key=key, got=shown(text), path=(key,))
        elif len(text) > LONGEST_TEXT:
            yield Problem(message=f"longer than {LONGEST_TEXT} characters", key=key, got=shown(text), path=(key,))
        elif not text.isascii() and any("\ud800" <= letter <= "\udfff" for letter in text):
            yield Problem(message="holds half a character", key=key, got=shown(text), path=(key,))


def _bad_blocks(blocks: "Mapping[str, Block | Graph]", rates: Mapping[str, object]) -> Iterator[Problem]:
    for name, block in blocks.items():
        path = ("blocks", str(name))
        if not isinstance(name, str) or not _is_path(name) or (isinstance(block, Graph) and "." in name):
            yield Problem(message="not a name", key="blocks", got=shown(name), expected=EXPECTED_NAME, path=path)
        elif not isinstance(block, Block | Graph):
            hint = f"write {block.__name__}()" if isinstance(block, type) else 'write a block, such as Gain(gain="2")'
            yield Problem(message="not a block", key=f"blocks.{name}", got=shown(block), hint=hint, path=path)
        elif "." in name:
            above = next((upper for upper in _above(name) if upper in blocks), "")
            if above:
                hint = f'for a parameter write "{name.removeprefix(above + ".")}.NAME" = ... below [blocks.{above}]'
                message = f"there is a block {above}, and nothing can be added inside it"
                yield Problem(message=message, key=f"blocks.{name}", hint=hint, path=path)
    for name in rates:
        if name not in blocks:
            hint = like(name, blocks, "the blocks")
            where = ("blocks", name, "rate")
            yield Problem(message="there is no such block", key=f"rates.{name}", hint=hint, path=where)


def _above(path: str) -> Iterator[str]:
    """Every path above a path.

    >>> list(_above("a.b.c"))
    ['a', 'a.b']
    """
    parts = path.split(".")
    return (".".join(parts[:n]) for n in range(1, len(parts)))


def _bad_exports(exports: object) -> Iterator[Problem]:
    hint = 'write exports = { code = "adc.code" }: a name of its own, and the port or parameter inside'
    if not isinstance(exports, Mapping):
        yield Problem(message="must be a table", key="exports", got=shown(exports), hint=hint, path=("exports",))
        return
    for name, signal in exports.items():
        key, path = f"exports.{name}", ("exports", str(name))
        if not isinstance(name, str) or not NAME.fullmatch(name):
            yield Problem(message="not a name", key="exports", got=shown(name), expected=EXPECTED_NAME, path=path)
        elif name in {**PART_KEYS, **BLOCK_KEYS}:
            taken = ", ".join({**PART_KEYS, **BLOCK_KEYS})
            yield Problem(message="the name is taken", key=key, hint=f"taken are {taken}", path=path)
        elif not _is_signal(signal):
            yield Problem(message="not a port or parameter", key=key, got=shown(signal), hint=hint, path=path)


def _size(blocks: int, parts: "Collection[Graph]", wires: int) -> Size:
    sizes = [part.size for part in parts]
    return Size(
        blocks + sum(size.blocks for size in sizes),
        wires + sum(size.wires for size in sizes),
        max((size.depth + 1 for size in sizes), default=0),
    )


def _too_many(blocks: Collection[str], parts: "Mapping[str, Graph]", wires: Collection[object]) -> Iterator[Problem]:
    """Limits of what subgraphs hold, looked at before anything of it is made."""
    size = _size(len(blocks) - len(parts), parts.values(), len(wires)) if parts else Size(0, 0, 0)
    for count, largest, what in ((size.blocks, BLOCKS, "blocks"), (size.wires, WIRES, "wires")):
        if count > largest:
            message, expected = f"too many {what} with those inside the subgraphs", f"at most {largest}"
            yield Problem(message=message, key="blocks", got=str(count), expected=expected, path=("blocks",))
    if size.depth > DEPTH:
        message = f"subgraphs nested deeper than {DEPTH} levels"
        yield Problem(message=message, key="blocks", got=str(size.depth), path=("blocks",))


def _inside(part: Graph, rate: Fraction | None, place: Place) -> Graph:
    """A subgraph as it stands inside another: at the rate of its place, its files named from there."""
    from proofmass.graphs.model.changes import moved

    return moved(part if rate is None else dataclasses.replace(part, rate=rate), place.folder)  # pyright: ignore


def _bad_run(samples: object, duration: object, seed: object) -> Iterator[Problem]:
    for key, value, lowest, largest in (("samples", samples, 1, LARGEST_RUN), ("seed", seed, 0, LARGEST_SEED)):
        if value is None and key == "samples":
            continue
        expected = f"an integer from {lowest} to {largest:g}"
        if isinstance(value, bool) or not isinstance(value, int):
            hint = f"write it without a point or an exponent: {key} = {int(value)}" if _is_whole(value) else ""
            yield Problem(
                message="must be an integer", key=key, got=shown(value), expected=expected, hint=hint, path=(key,)
            )
        elif not lowest <= value <= largest:
            yield Problem(message="out of range", key=key, got=shown(value), expected=expected, path=(key,))
    if samples is not None and duration is not None:
        hint = "remove one of them"
        yield Problem(message="give samples or duration, not both", key="samples", hint=hint, path=("samples",))


def _is_whole(value: object) -> TypeGuard[float]:
    return isinstance(value, float) and value.is_integer() and 0 <= value <= LARGEST_SEED
