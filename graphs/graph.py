"""A graph: blocks by name, wires, rates and probes. A frozen value, the same from Python and from TOML."""

import dataclasses
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, TypeGuard, TypeVar

from proofmass.blocks.declare import Block
from proofmass.blocks.problem import ModelError, Problem, shown
from proofmass.blocks.units import UnitError
from proofmass.graphs.hints import like
from proofmass.graphs.rates import Rate, read_rate
from proofmass.graphs.rates import read_duration as read_duration

if TYPE_CHECKING:
    import networkx

NAME = re.compile(r"(?=.{1,64}$)[a-z][a-z0-9]*(_[a-z0-9]+)*")
EXPECTED_NAME = "at most 64 lower-case letters and digits, words joined by single underscores"
LARGEST_RUN = 10**12  # ticks
LARGEST_SEED = 2**62
LONGEST_TEXT = 10_000  # characters of name and description

Value = TypeVar("Value")


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


NOWHERE = Place()


@dataclasses.dataclass(frozen=True, init=False)
class Graph:
    """Blocks wired by their ports, at stated rates, with the signals to record.

    `wires` are texts like `"adc.code -> correlator.code"`; the target may be a parameter, which the wire then drives.
    `rates` gives blocks a rate of their own; all others run at `rate`. `duration` (or `samples`, in base ticks) and
    `seed` are what a run takes when nothing else is said.

    Raises `ModelError` with every problem when a text, a name or a rate cannot be read; `check` looks at the wiring.
    """

    name: str
    description: str
    rate: Fraction | None  # in hertz
    duration: Fraction | None  # in seconds
    samples: int | None
    seed: int
    blocks: Mapping[str, Block]
    rates: Mapping[str, Fraction]
    wires: tuple[Wire, ...]
    probes: tuple[Probe, ...]
    place: Place = dataclasses.field(compare=False, repr=False)

    def __init__(
        self,
        *,
        name: str,
        blocks: Mapping[str, Block],
        wires: Iterable[Wire | str] = (),
        probes: Iterable[Probe | str | Mapping[str, Any]] = (),
        rate: Rate | None = None,
        rates: Mapping[str, Rate] = MappingProxyType({}),
        duration: Rate | None = None,
        samples: int | None = None,
        seed: int = 0,
        description: str = "",
        place: Place = NOWHERE,
    ) -> None:
        problems = [*_bad_texts(name, description), *_bad_run(samples, duration, seed), *_bad_blocks(blocks, rates)]

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
        values = {
            "name": name,
            "description": description,
            "rate": None if rate is None else read(read_rate, rate, "rate"),
            "duration": None if duration is None else read(read_duration, duration, "duration"),
            "samples": samples,
            "seed": seed,
            "blocks": MappingProxyType(dict(sorted(blocks.items()))),
            "rates": MappingProxyType(own_rates),
            "wires": tuple(sorted(read_each(read_wire, wires, "wires"))),
            "probes": tuple(read_each(read_probe, probes, "probes")),
            "place": place,
        }
        for field, value in values.items():
            object.__setattr__(self, field, value)
        if problems:
            raise ModelError([self.placed(problem) for problem in problems])

    def __reduce__(self) -> "tuple[Any, ...]":
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return _rebuilt, (values | {"blocks": dict(self.blocks), "rates": dict(self.rates)},)

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
                hint = like(block, blocks, "the blocks")
                problems.append(Problem(message="there is no such block", key=key, got=shown(block), hint=hint))
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
            source, target = split(wire.source), split(wire.target)
            out.add_edge(source[0], target[0], source=source[1], target=target[1])
        return out

    def _repr_svg_(self) -> str:
        from proofmass.graphs.diagram import svg

        return svg(self)  # pyright: ignore[reportArgumentType]  # it sees this file twice, by its folder and by its link


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


def _parameters(block: Block) -> dict[str, Any]:
    return {name: getattr(block, name) for name in block.parameters}


def _is_signal(text: object) -> bool:
    return isinstance(text, str) and text.count(".") == 1 and all(NAME.fullmatch(part) for part in text.split("."))


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


def _bad_blocks(blocks: Mapping[str, Block], rates: Mapping[str, object]) -> Iterator[Problem]:
    for name, block in blocks.items():
        path = ("blocks", str(name))
        if not isinstance(name, str) or not NAME.fullmatch(name):
            yield Problem(message="not a name", key="blocks", got=shown(name), expected=EXPECTED_NAME, path=path)
        elif not isinstance(block, Block):
            hint = f"write {block.__name__}()" if isinstance(block, type) else 'write a block, such as Gain(gain="2")'
            yield Problem(message="not a block", key=f"blocks.{name}", got=shown(block), hint=hint, path=path)
    for name in rates:
        if name not in blocks:
            hint = like(name, blocks, "the blocks")
            where = ("blocks", name, "rate")
            yield Problem(message="there is no such block", key=f"rates.{name}", hint=hint, path=where)


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
