"""A graph as TOML text that reads back to the same graph."""

import re
from collections.abc import Callable, Collection, Iterator, Mapping
from fractions import Fraction
from functools import partial
from typing import Any, Protocol

from proofmass.blocks.arithmetic.fixed_point import Fixed
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of, written
from proofmass.blocks.declaration.units import same_unit, short_unit, split_quantity
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.model.graph import Graph, Probe, split
from proofmass.graphs.model.keys import FORMULA, Integer, Text
from proofmass.graphs.model.loops import REQUIREMENTS
from proofmass.graphs.model.measures import Measure
from proofmass.graphs.model.rates import write_rate, write_seconds
from proofmass.graphs.model.statistics import TIMES
from proofmass.graphs.model.targets import CLOCK_OFFSET, DURATION, OF_MEASURES, RATE, is_of_measure
from proofmass.graphs.model.top_keys import PLAIN_KEYS
from proofmass.graphs.model.values import NamedValue

_BARE = re.compile(r"[A-Za-z0-9_-]+")
SCHEMA_LINE = "#:schema proofmass-graph.json"


class WithTables(Protocol):
    """A graph with tables beside it, such as `[tune]`, which writes both."""

    def as_toml(self) -> str:
        """Return the text of a graph file with these tables."""
        ...


def write_graph(graph: Graph | WithTables, as_written: bool = False, kept: Collection[str] = ()) -> str:
    """Return the text of a graph file: only differences from the defaults, numbers with units,
    subgraphs as tables.

    `graph` is any graph: what `read_graph` makes of the text is equal to it. Of a `Tuning` the text
    has `[tune]` too, and `read_tuning` reads it back. `as_written` keeps quantities in the units in
    which they were given. Parameters that are `kept` are written where they are the default too,
    named by their paths.

    >>> from proofmass import Graph, write_graph
    >>> from proofmass.blocks import Step
    >>> print(write_graph(Graph(name="a step", rate="1 kHz", samples=3, blocks={"step": Step(amplitude=2.0)})), end="")
    #:schema proofmass-graph.json
    name = "a step"
    rate = "1 kHz"
    samples = 3
    <BLANKLINE>
    [blocks.step]
    kind = "Step"
    amplitude = 2.0
    """
    if not isinstance(graph, Graph):
        return graph.as_toml()
    return "\n".join([SCHEMA_LINE, f"name = {quoted(graph.name)}", *_graph(graph, "", as_written, kept)]) + "\n"


def _time(seconds: Fraction, as_written: bool) -> str:
    """A time for people, "50 ms", or in the one form by which graphs are compared."""
    return write_seconds(seconds) if as_written else f"{seconds} s"


def _graph(graph: Graph, path: str, as_written: bool, kept: Collection[str]) -> Iterator[str]:
    """Everything but the name of a graph; `path` stands before the names of its tables."""
    texts = ((key, getattr(graph, key)) for key, form in PLAIN_KEYS.items() if isinstance(form, Text))
    yield from (f"{key} = {_long_text(text)}" for key, text in texts if text and key != "name")
    if graph.rate is not None:
        yield f"rate = {quoted(_formula(graph, RATE) or write_rate(graph.rate))}"
    if graph.duration is not None:
        yield f"duration = {quoted(_formula(graph, DURATION) or _time(graph.duration, as_written))}"
    integers = ((key, form, getattr(graph, key)) for key, form in PLAIN_KEYS.items() if isinstance(form, Integer))
    yield from (f"{key} = {value}" for key, form, value in integers if value != form.default)
    yield from _list("wires", [quoted(str(wire)) for wire in graph.wires])
    yield from _list("probes", [_probe(p) for p in graph.probes])
    if path and not graph.blocks and not graph.subgraphs:
        yield "blocks = {}"
    yield from _table(f"{path}values", {n: _value(v) for n, v in graph.values.items()})
    inner = {of: f.text for of, f in graph.formulas.items() if "." in of and not is_of_measure(graph, of)}
    inner = {of: text for of, text in inner.items() if split(of.partition("[")[0])[0] not in graph.blocks}
    yield from _table(f"{path}formulas", {of: quoted(text) for of, text in inner.items()})
    signals = {
        name: _measure(m, partial(_formula, graph, f"{OF_MEASURES}{name}."), as_written)
        for name, m in graph.measures.items()
    }
    derived = {name: _derived(formula) for name, formula in graph.derived.items()}
    yield from _table(f"{path}measures", signals | derived)
    yield from _table(f"{path}requirements", {n: inline(r.as_written()) for n, r in graph.requirements.items()})
    yield from _table(f"{path}exports", {n: quoted(s) for n, s in graph.exports.items()})
    yield from _table(f"{path}integration", {k: inline(v) for k, v in graph.integration.changed().items()})
    for name, loop in graph.loops.items():
        requirements = {k: quoted(f"{v!r} {REQUIREMENTS[k]}") for k, v in loop.requirements.items()}
        yield from _table(f"{path}loops.{key_of(name)}", {"open_at": quoted(loop.open_at)} | requirements)
    for name, block in graph.blocks.items():
        yield from ("", f"[{path}blocks.{key_of(name)}]", f"kind = {quoted(type(block).__name__)}")
        if name in graph.rates:
            yield f"rate = {quoted(_formula(graph, f'{name}.{RATE}') or write_rate(graph.rates[name]))}"
        yield from _offset(graph, name, as_written)
        yield from _parameters(block, partial(_formula, graph, f"{name}."), as_written, _inside(kept, name))
    for name, part in graph.subgraphs.items():
        yield from ("", f"[{path}blocks.{name}]")
        yield from _offset(graph, name, as_written)
        if part.name:
            yield f"name = {quoted(part.name)}"
        yield from _graph(part, f"{path}blocks.{name}.", as_written, _inside(kept, name))


def _inside(kept: Collection[str], name: str) -> list[str]:
    """Return the paths that begin at a block, from there on."""
    return [path.removeprefix(f"{name}.") for path in kept if path.startswith(f"{name}.")]


def _formula(graph: Graph, target: str, entry: str = "") -> str:
    """The formula of a rate, a duration or a parameter as written; empty if it has none."""
    formula = graph.formulas.get(target + entry)
    return formula.text if formula else ""


def _offset(graph: Graph, name: str, as_written: bool) -> Iterator[str]:
    written = _formula(graph, f"{name}.{CLOCK_OFFSET}")
    if name in graph.subgraphs and written:
        return  # it is written with the formulas
    if written or name in graph.offsets:
        yield f"{CLOCK_OFFSET} = {quoted(written or _time(graph.offsets[name], as_written))}"


def _value(value: NamedValue) -> str:
    """A value as TOML: a plain number, or a text with a unit or a formula."""
    plain = value.formula is None and split_quantity(value.written)[1] == "" and "/" not in value.written
    return value.written if plain else quoted(value.written)


def _parameters(block: Block, formula: Callable[[str], str], as_written: bool, kept: Collection[str]) -> Iterator[str]:
    for name, parameter in type(block).parameters.items():
        value = getattr(block, name)
        entries = [formula(f"{name}[{place}]") for place in range(len(value))] if isinstance(value, tuple) else []
        entry = value
        if formula(name):
            entry = formula(name)
        elif any(entries):
            entry = [own or number for own, number in zip(entries, value, strict=True)]
        elif repr(value) == repr(parameter.default) and name not in kept:  # tells -0.0 from 0.0
            continue
        elif parameter.kind is float:
            unit = short_unit(unit_of(block, parameter))
            plain = not value or same_unit(unit or "1", "1") or len(f"{value!r} {unit}") > 200
            entry = (as_written and written(block, name)) or (value if plain else f"{value!r} {unit}")
        elif parameter.kind is Fixed:
            entry = str(value)
        yield f"{name} = {inline(entry)}"


def _probe(probe: Probe) -> str:
    more = {k: v for k, v in (("every", probe.every), ("unit", probe.unit)) if v not in (1, "")}
    return inline({"signal": probe.signal} | more if more else probe.signal)


def _derived(formula: Formula) -> str:
    """Return a measure that follows from others: its formula, or a table that says its unit of tables too."""
    return inline({FORMULA: formula.text, "unit": formula.unit}) if formula.unit else quoted(formula.text)


def _measure(measure: Measure, formula: Callable[[str], str], as_written: bool) -> str:
    times = {"from": measure.start or None, "until": measure.until}
    texts = {key: formula(key) or (_time(time, as_written) if time is not None else "") for key, time in times.items()}
    options = {key: formula(key) or (f"{v} s" if key in TIMES else v) for key, v in measure.options}
    head = {"signal": measure.signal, "statistic": measure.statistic}
    return inline(head | {k: v for k, v in (texts | options | {"unit": measure.unit}).items() if v != ""})


def inline(entry: Any) -> str:
    """A table, a list, a text, a truth value or a number as one line of TOML."""
    if isinstance(entry, Mapping):
        entries = ", ".join(f"{key_of(key)} = {inline(value)}" for key, value in entry.items())
        return f"{{ {entries} }}" if entries else "{}"
    if isinstance(entry, list | tuple):
        return f"[{', '.join(map(inline, entry))}]"
    if isinstance(entry, bool):
        return "true" if entry else "false"
    return quoted(entry) if isinstance(entry, str) else repr(entry)


def key_of(name: str) -> str:
    """A key of TOML, in quotes where it needs them."""
    return name if _BARE.fullmatch(name) else quoted(name)


def _table(name: str, entries: Mapping[str, str]) -> Iterator[str]:
    """The lines of a table; none of an empty one."""
    if entries:
        yield from ("", f"[{name}]", *(f"{key_of(key)} = {text}" for key, text in entries.items()))


def _list(key: str, entries: list[str]) -> list[str]:
    if not entries:
        return []
    return ["", f"{key} = [", *(f"    {entry}," for entry in entries), "]"]


def _long_text(text: str) -> str:
    """A TOML string that keeps its lines."""
    if "\n" not in text:
        return quoted(text)
    lines = [quoted(line)[1:-1] for line in text.split("\n")]
    return '"""\n' + "\n".join(lines) + '"""'


def quoted(text: str) -> str:
    """A TOML basic string."""
    escaped = text.replace("\\", "\\\\").replace('"', '\\"')
    return '"' + "".join(c if c.isprintable() else f"\\U{ord(c):08x}" for c in escaped) + '"'
