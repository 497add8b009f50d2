"""Build a graph from texts, tables or values, and report all their problems at once."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import FrozenInstanceError, replace
from fractions import Fraction
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Self, TypeVar

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.named_arguments import named_arguments
from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, collecting, did_you_mean, shown
from proofmass.graphs.formulas.formula import Formula, is_formula
from proofmass.graphs.model.call_numbers import plain_tables
from proofmass.graphs.model.changes import moved, settled, with_parameters
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.formula_tables import bad_targets, read_formulas, read_measured, split_measures
from proofmass.graphs.model.graph import (
    DEFAULT_INTEGRATION,
    NOWHERE,
    GraphSize,
    Place,
    Probe,
    Wire,
    size_of,
    split,
    thawed,
)
from proofmass.graphs.model.graph import Graph as Value
from proofmass.graphs.model.in_python import CAPITALS, asked, assigned, refuse_unnamed
from proofmass.graphs.model.integration import Integration, read_integration
from proofmass.graphs.model.keys import BLOCK_KEYS, PART_KEYS
from proofmass.graphs.model.limits import BLOCKS, DEPTH, EXPECTED_NAME, LARGEST_RUN, NAME, WIRES
from proofmass.graphs.model.loops import Loop, read_loops
from proofmass.graphs.model.measures import MEASURES, Measure, read_display_unit
from proofmass.graphs.model.near_names import ends_of, with_nearest
from proofmass.graphs.model.rates import Rate, read_duration, read_rate
from proofmass.graphs.model.requirements import Requirement, read_requirements
from proofmass.graphs.model.targets import CLOCK_OFFSET, DURATION, RATE
from proofmass.graphs.model.top_keys import TOP_KEYS, wrong_values
from proofmass.graphs.model.values import NamedValue as NamedValue
from proofmass.graphs.model.values import read_values

if TYPE_CHECKING:
    import networkx

_Entry = TypeVar("_Entry")


class Graph(Value):
    """Blocks wired by their ports, at stated rates, with the signals to record.

    A block may be a graph: `blocks={"x_axis": Graph(...)}`. Outside it has the ports and parameters
    of its `exports`, `{"code": "adc.code"}`; everything inside can be named by its path,
    `x_axis.adc.code`. A rate given to it is that of its blocks without a rate of their own. Its
    probes, measures, duration, samples, seed and integration count only where it runs alone.

    `wires` are texts like `"adc.code -> correlator.code"`; the target may be a parameter, which the
    wire then drives. `rates` gives blocks a rate of their own; all others run at `rate`. `offsets`
    are how much later than tick 0 blocks tick first, {"controller": "25 us"}. `duration` (or
    `samples`, in base ticks) and
    `seed` are the defaults of a run; `integration` says how continuous blocks are integrated.
    `loops` names control loops for their margins, `{"main": {"open_at": "dac.voltage"}}`.
    `values` are named quantities, `{"mass": "50 ug", "weight": "= mass * 9.81 m/s^2"}`, and
    `formulas` give them to parameters, `{"sensor.mass": "= mass"}`; rates and the duration may be
    formulas too.
    `requirements` are what `verify` looks at, `{"bias": {"quantity": "bias", "at_most": "1 mV"}}`.
    `measures` are numbers that a run reduces signals to,
    `{"bias": {"signal": "dac.code", "statistic": "mean", "from": "0.5 s"}}`, or formulas of other
    measures, `{"scale_factor": "= (plus - minus) / 2"}`.

    Raises `ModelError` with every problem when a text, a name or a rate cannot be read; `check`
    looks at the wiring.

    `name` and `description` are for people. `blocks` are by name. `probes` are the signals to
    record, "block.output". `place` is the file that a graph comes from. `subgraphs` and `derived`
    come from readers of files: in Python graphs stand among the blocks, and formulas among the
    measures.

    >>> from proofmass import Graph, simulate
    >>> from proofmass.blocks import LowPass, Step
    >>> graph = Graph(
    ...     name="a lag",
    ...     rate="1 kHz",
    ...     blocks={"step": Step(), "lag": LowPass(corner_frequency="10 Hz")},
    ...     wires=["step.output -> lag.input"],
    ...     probes=["lag.output"],
    ... )
    >>> round(float(simulate(graph, duration="1 s")["lag.output"].values[-1]), 9)
    1.0
    >>> graph.with_parameters({"lag.corner_frequency": "20 Hz"}).blocks["lag"].corner_frequency
    20.0
    """

    drawn: ClassVar[Callable[[Value], str] | None] = None  # draws a graph in a notebook; the root package sets it

    @named_arguments
    def __init__(
        self,
        *,
        name: str,
        blocks: Mapping[str, Block | Value],
        wires: Iterable[Wire | str] = (),
        probes: Iterable[Probe | str | Mapping[str, Any]] = (),
        rate: Rate | None = None,
        rates: Mapping[str, Rate] = MappingProxyType({}),
        offsets: Mapping[str, Rate] = MappingProxyType({}),
        duration: Rate | None = None,
        samples: int | None = None,
        seed: int = 0,
        description: str = "",
        measures: Mapping[str, Measure | Mapping[str, Any] | str] = MappingProxyType({}),
        derived: Mapping[str, Formula] = MappingProxyType({}),
        exports: Mapping[str, str] = MappingProxyType({}),
        loops: Mapping[str, Loop | Mapping[str, Any]] = MappingProxyType({}),
        requirements: Mapping[str, Requirement | Mapping[str, Any]] = MappingProxyType({}),
        values: Mapping[str, NamedValue | str | float] = MappingProxyType({}),
        formulas: Mapping[str, Formula | str] = MappingProxyType({}),
        subgraphs: Mapping[str, Value] = MappingProxyType({}),
        integration: Integration | Mapping[str, Any] = DEFAULT_INTEGRATION,
        place: Place = NOWHERE,
    ) -> None:
        reader, wires = _Reader(), wires if isinstance(wires, str) else _entries(wires)
        refuse_unnamed(blocks)
        blocks = {**subgraphs, **blocks}
        parts = {part: block for part, block in sorted(blocks.items()) if isinstance(block, Value)}
        keys: dict[str, Any] = {"name": name, "description": description, "samples": samples, "seed": seed}
        keys = {key: plain(value) for key, value in keys.items()}
        reader.problems += wrong_values(keys)
        if samples is not None and duration is not None:
            message, hint = "give samples or duration, not both", "remove one of them"
            reader.problems.append(Problem(message=message, hint=hint, path=("samples",)))
        reader.problems += _bad_blocks(blocks, rates, offsets)
        own_requirements, wrong = read_requirements(plain_tables(requirements))
        reader.problems += wrong
        own_values, wrong = read_values(values, _taken(exports))
        reader.problems += wrong
        of_rates = {f"{name}.{RATE}": rate for name, rate in rates.items() if is_formula(rate)}
        of_rates |= {f"{name}.{CLOCK_OFFSET}": offset for name, offset in offsets.items() if is_formula(offset)}
        of_rates |= {key: of for key, of in ((RATE, rate), (DURATION, duration)) if is_formula(of)}
        own_formulas, wrong = read_formulas(formulas)
        rate_formulas, more = read_formulas(of_rates, at_blocks=True)
        own_formulas |= rate_formulas
        reader.problems += wrong + more
        rate, duration = (None if is_formula(of) else of for of in (rate, duration))
        rates = {name: of for name, of in rates.items() if not is_formula(of)}
        offsets = {name: of for name, of in offsets.items() if not is_formula(of)}
        own_loops, wrong = read_loops(plain_tables(loops), _is_path)
        reader.problems += [*_bad_exports(exports, own_values), *wrong]
        own_offsets = {
            block: reader.value(read_duration, offsets[block], "blocks", block, CLOCK_OFFSET)
            for block in sorted(offsets)
        }
        own_rates = {block: reader.value(read_rate, rates[block], "blocks", block, "rate") for block in sorted(rates)}
        reader.problems += _too_many(blocks, parts, wires if parts else ())
        if not reader.problems:
            parts = {part: _inside(block, own_rates.pop(part, None), place) for part, block in parts.items()}
        own_rate = None if rate is None else reader.value(read_rate, rate, "rate")
        own_duration = None if duration is None else reader.value(read_duration, duration, "duration")
        own_wires, own_probes = reader.list(read_wire, wires, "wires"), reader.list(read_probe, probes, "probes")
        given_measures, own_derived, wrong = split_measures(measures, derived)
        own_measures, of_measures, bad = read_measured(given_measures, own_values, values)
        own_formulas |= of_measures
        reader.problems += [*wrong, *bad]
        reader.problems += () if reader.problems or MEASURES in blocks else bad_targets(own_formulas, own_measures)
        own_integration = DEFAULT_INTEGRATION
        with collecting(reader.problems):
            own_integration = read_integration(plain_tables(integration))
        if reader.problems:
            told = with_nearest(reader.problems, blocks, wires)
            raise ModelError(list(map(place.placed, told)))
        super().__init__(
            **keys,
            rate=own_rate,
            duration=own_duration,
            blocks={block: made for block, made in blocks.items() if isinstance(made, Block)},
            subgraphs=parts,
            rates={block: made for block, made in own_rates.items() if made is not None},
            offsets={block: made for block, made in own_offsets.items() if made},
            wires=own_wires,
            probes=own_probes,
            measures=own_measures,
            derived=own_derived,
            exports=exports,
            integration=own_integration,
            loops=own_loops,
            requirements=own_requirements,
            values=own_values,
            formulas=own_formulas,
            place=place,
        )
        if own_formulas:
            super().__init__(**thawed(_settled(self)))

    def with_parameters(self, changes: Mapping[str, object]) -> Self:
        """Return the graph with values and parameters changed, `{"mass": "60 ug", "adc.reference": "5 V"}`.

        Whatever follows from a value by formulas moves with it. A parameter of a subgraph is named
        by its path, `"x_axis.adc.reference"`, or as it is exported, `"x_axis.reference"`. A text
        that begins with an equals sign is a new formula; a number takes one away.
        Raises `ModelError`.
        """
        return with_parameters(self, changes)

    if not TYPE_CHECKING:  # type checkers know the fields without it

        def __setattr__(self, name: str, value: object) -> None:
            raise FrozenInstanceError(assigned(name))

        def __getattr__(self, name: str) -> Any:
            raise AttributeError(asked(name))

    def to_networkx(self) -> "networkx.MultiDiGraph[str]":
        """The flat graph for networkx: a node per block with its declaration, an edge per wire with both ports."""
        import networkx  # start-up time: importing it takes longer than building a graph

        flat = flatten(self)
        out: networkx.MultiDiGraph[str] = networkx.MultiDiGraph(name=self.name)
        for name, block in flat.blocks.items():
            numbers = {parameter: getattr(block, parameter) for parameter in type(block).parameters}
            out.add_node(name, kind=type(block).__name__, **numbers)
        for wire in flat.wires:
            source, target = split(wire.source), split(wire.target)
            out.add_edge(source[0], target[0], source=source[1], target=target[1])
        return out

    def _repr_svg_(self) -> str | None:
        return None if Graph.drawn is None else Graph.drawn(self)


class _Reader:
    """Reads values one by one and collects their problems."""

    def __init__(self) -> None:
        self.problems: list[Problem] = []

    def value(self, read: Callable[[object], _Entry], value: object, *path: str) -> _Entry | None:
        with collecting(self.problems, value, path):
            return read(value)
        return None

    def list(self, read: Callable[[object], _Entry], values: Iterable[object], key: str) -> tuple[_Entry, ...]:
        if isinstance(values, str):
            self.problems.append(Problem(message="must be a list", got=shown(values), path=(key,)))
            return ()
        entries = [self.value(read, value, key, str(index)) for index, value in enumerate(values)]
        return tuple(entry for entry in entries if entry is not None)


def read_wire(text: object) -> Wire:
    """A wire from `"block.port -> block.port"`."""
    if isinstance(text, Wire):
        return text
    ends = ends_of(text)
    if isinstance(text, str) and len(ends) == 2 and all(map(_is_signal, ends)):
        return Wire(*ends)
    if not isinstance(text, str) and all(map(_is_signal, ends)) and ends:
        raise Refusal("not a wire", f'write "{" -> ".join(ends)}"')
    raise Refusal("not a wire", _lower_case(ends) or 'write "block.output -> block.input"')


def _entries(wires: Iterable[Any]) -> tuple[Any, ...]:
    """Return wires one by one; of tables as pairs, which `read_wire` refuses with its cure."""
    return tuple(wires.items() if isinstance(wires, Mapping) else wires)


def read_probe(value: object) -> Probe:
    """A probe from `"block.port"`, or from a table with `signal`, `every` and `unit`."""
    if isinstance(value, str):
        value = {"signal": value}
    if isinstance(value, Probe):
        value = value._asdict()
    if not isinstance(value, Mapping) or not set(value) <= {*Probe._fields} or not _is_signal(value.get("signal")):
        raise Refusal("not a probe", 'write "block.output" or { signal = "block.output", every = 10 }')
    every = plain(value.get("every", 1))
    if isinstance(every, bool) or not isinstance(every, int) or not 1 <= every <= LARGEST_RUN:
        raise Refusal("every must be an integer of at least 1")
    return Probe(value["signal"], every, read_display_unit(value.get("unit", "")))


def _lower_case(ends: Sequence[str]) -> str:
    """A hint where only capital letters keep ends from being names."""
    meant = [CAPITALS.sub("_", end).lower() for end in ends] if len(ends) == 2 else []
    fits = meant and meant != list(ends) and all(_is_signal(end) for end in meant)
    return f'names are lower case: write "{" -> ".join(meant)}"' if fits else ""


def _is_signal(text: object) -> bool:
    return isinstance(text, str) and text.count(".") > 0 and _is_path(text)


def _is_path(text: str) -> bool:
    return text.count(".") <= DEPTH + 1 and all(NAME.fullmatch(part) for part in text.split("."))


def _bad_blocks(
    blocks: Mapping[str, Block | Value], rates: Mapping[str, object], offsets: Mapping[str, object]
) -> Iterator[Problem]:
    for name, block in blocks.items():
        path = ("blocks", str(name))
        if not isinstance(name, str) or not _is_path(name) or (isinstance(block, Value) and "." in name):
            small = CAPITALS.sub("_", name).lower() if isinstance(name, str) else ""
            got, hint = shown(name), f"call it {small}" if NAME.fullmatch(small) else ""
            yield Problem(message="not a name", key="blocks", got=got, expected=EXPECTED_NAME, hint=hint, path=path)
        elif not isinstance(block, Block | Value):
            hint = f"write {block.__name__}()" if isinstance(block, type) else 'write a block, such as Gain(gain="2")'
            yield Problem(message="not a block", got=shown(block), hint=hint, path=path)
        elif "." in name:
            above = next((upper for upper in above_of(name) if upper in blocks), "")
            if above:
                hint = f'for a parameter write "{name.removeprefix(above + ".")}.NAME" = ... below [blocks.{above}]'
                message = f"there is a block {above}, and nothing can be added inside it"
                yield Problem(message=message, hint=hint, path=path)
    for table, key, names in (("rates", RATE, rates), ("offsets", CLOCK_OFFSET, offsets)):
        for name in names:
            if name not in blocks:
                hint = did_you_mean(name, blocks, "the blocks")
                where = ("blocks", name, key)
                yield Problem(message="there is no such block", key=f"{table}.{name}", hint=hint, path=where)


def above_of(path: str) -> Iterator[str]:
    """Every path above a path.

    >>> list(above_of("a.b.c"))
    ['a', 'a.b']
    """
    parts = path.split(".")
    return (".".join(parts[:n]) for n in range(1, len(parts)))


def _bad_exports(exports: object, values: Collection[str]) -> Iterator[Problem]:
    hint = 'write exports = { code = "adc.code" }: a name of its own, and the port or parameter inside'
    if not isinstance(exports, Mapping):
        yield Problem(message="must be a table", got=shown(exports), hint=hint, path=("exports",))
        return
    for name, signal in exports.items():
        path = ("exports", str(name))
        if not isinstance(name, str) or not NAME.fullmatch(name):
            yield Problem(message="not a name", key="exports", got=shown(name), expected=EXPECTED_NAME, path=path)
        elif name in {**PART_KEYS, **BLOCK_KEYS}:
            taken = ", ".join({**PART_KEYS, **BLOCK_KEYS})
            yield Problem(message="the name is taken", hint=f"taken are {taken}", path=path)
        elif not _is_signal(signal) and not (isinstance(signal, str) and signal in values):
            yield Problem(message="not a port or parameter", got=shown(signal), hint=hint, path=path)


def _taken(exports: object) -> dict[str, str]:
    """Names that values cannot have, with their present meaning."""
    taken = dict.fromkeys({**TOP_KEYS, **PART_KEYS, **BLOCK_KEYS}, "a key of graph files")
    names = exports.items() if isinstance(exports, Mapping) else ()
    return taken | {name: f"exported for {signal}" for name, signal in names if name != signal}


def _settled(graph: Graph) -> Graph:
    """Return the graph with the numbers of its formulas in their places; raises `ModelError`."""
    paths = {of: inside(graph, graph.exports.get(of, of)) for of in graph.formulas}
    try:
        return settled(graph.changed(formulas={paths[of]: formula for of, formula in graph.formulas.items()}), {})
    except ModelError as error:
        written: dict[tuple[str, ...], tuple[str, ...]]
        written = {("formulas", path): ("formulas", of) for of, path in paths.items()}
        own = [replace(problem, path=written.get(problem.path, problem.path)) for problem in error.problems]
        raise ModelError([graph.placed(problem) for problem in own]) from None


def _too_many(blocks: Collection[str], parts: Mapping[str, Value], wires: Collection[object]) -> Iterator[Problem]:
    """Check the size of all subgraphs together, before any of them is built."""
    size = size_of(len(blocks) - len(parts), parts, len(wires)) if parts else GraphSize(0, 0, 0)
    for count, largest, what in ((size.blocks, BLOCKS, "blocks"), (size.wires, WIRES, "wires")):
        if count > largest:
            message, expected = f"too many {what} with those inside the subgraphs", f"at most {largest}"
            yield Problem(message=message, got=str(count), expected=expected, path=("blocks",))
    if size.depth > DEPTH:
        yield Problem(message=f"subgraphs nested deeper than {DEPTH} levels", got=str(size.depth), path=("blocks",))


def _inside(part: Value, rate: Fraction | None, place: Place) -> Value:
    """Return a subgraph as a part of another graph: at the rate there, files named from there."""
    return moved(part if rate is None else part.changed(rate=rate), place.folder)
