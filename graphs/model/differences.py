"""Differences of meaning between two graphs: blocks, parameters, wires, rates, values, and all else
a run depends on.

Order, comments, layout, nesting and the way a quantity is written make no difference. Blocks, wires
and rates are those of the flat graphs.
"""

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of, written
from proofmass.blocks.declaration.units import same_unit, short_unit
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.flatten import FlatGraph, flatten, parts, values_of
from proofmass.graphs.model.graph import Graph, Wire, split
from proofmass.graphs.model.keys import Integer, Text
from proofmass.graphs.model.loops import REQUIREMENTS
from proofmass.graphs.model.measures import Measure, as_table
from proofmass.graphs.model.rates import write_rate, write_seconds
from proofmass.graphs.model.targets import CLOCK_OFFSET, DURATION, RATE
from proofmass.graphs.model.top_keys import PLAIN_KEYS


@dataclasses.dataclass(frozen=True)
class GraphDifference:
    """One difference: a key as in a graph file, and its text in each graph, empty if the graph does not have it.

    `follows` names the values of which this is a consequence.
    """

    key: str
    before: str = ""
    after: str = ""
    follows: str = ""

    @property
    def what(self) -> str:
        """Return `added`, `removed`, `renamed` or `changed`."""
        if self.before and self.after:
            return "renamed" if self.key == "blocks" else "changed"
        return "removed" if self.before else "added"

    def as_data(self) -> dict[str, str]:
        """Return the difference as plain data."""
        data = {"key": self.key, "what": self.what, "before": self.before, "after": self.after}
        return data | ({"follows": self.follows} if self.follows else {})


def differences(first: Graph, second: Graph) -> list[GraphDifference]:
    """Return the differences of two graphs in the order of a graph file; none if alike."""
    before, after = flatten(first), flatten(second)
    names = _Names(_renamed(before, after))
    followed = _followed(first, second, names)
    formulas = {names.signal(target): text for target, text in _formulas(first).items()}, _formulas(second)
    times = _Times(
        formulas,
        ({names.signal(f"{n}.{RATE}") for n in _rated(first)}, {f"{n}.{RATE}" for n in _rated(second)}),
        followed,
    )
    changes = [*_top(before, after, times), *_values(first, second, names, followed)]
    changes += [GraphDifference("blocks", old, new) for old, new in names.blocks.items()]
    before = names.flat(before)
    measured = list(_measures((before, after), times))
    changes += [*_blocks(before, after, formulas, followed, times), *_other_formulas((before, after), formulas, times)]
    return [*changes, *_wires(before, after), *_probes(before, after), *measured, *_rest(before, after)]


class _Names:
    """Renamed blocks, and subgraphs all of whose blocks are renamed alike."""

    def __init__(self, blocks: Mapping[str, str]) -> None:
        self.blocks = blocks
        pairs = {(split(old)[0], split(new)[0]) for old, new in blocks.items() if split(old)[1] == split(new)[1]}
        self.parts = {old: new for old, new in pairs if old and new}

    def signal(self, text: str) -> str:
        """Return a port or parameter under its block's new name, a value under its subgraph's."""
        name, port = split(text)
        return f"{self.blocks.get(name, self.parts.get(name, name))}.{port}" if name else text

    def flat(self, flat: FlatGraph) -> FlatGraph:
        """Return a flat graph under the new names."""
        return dataclasses.replace(
            flat,
            blocks={self.blocks.get(name, name): block for name, block in flat.blocks.items()},
            rates={self.blocks.get(name, name): rate for name, rate in flat.rates.items()},
            offsets={self.blocks.get(name, name): offset for name, offset in flat.offsets.items()},
            wires=tuple(Wire(self.signal(wire.source), self.signal(wire.target)) for wire in flat.wires),
            probes=tuple(probe._replace(signal=self.signal(probe.signal)) for probe in flat.probes),
            measures={n: m._replace(signal=self.signal(m.signal)) for n, m in flat.measures.items()},
            loops={n: dataclasses.replace(loop, open_at=self.signal(loop.open_at)) for n, loop in flat.loops.items()},
            exports={name: self.signal(signal) for name, signal in flat.exports.items()},
        )


class _Times:
    """Rates, offsets, the length of a run and entries of measures, with the formulas that give them."""

    def __init__(
        self,
        formulas: tuple[dict[str, str], dict[str, str]],
        rated: tuple[set[str], set[str]],
        followed: Mapping[str, str],
    ) -> None:
        self._formulas, self._rated, self._followed = formulas, rated, followed
        self.told = set[str]()  # targets of formulas that stand beside their numbers

    def changed(self, key: str, name: str, entry: str, before: str, after: str) -> Iterator[GraphDifference]:
        """Yield the change of an entry of a block, or of the graph where the name is empty."""
        if before == after:
            return
        owners = [self._owner(name, entry, side) for side in (0, 1)]
        texts = [table.get(owner, "") for table, owner in zip(self._formulas, owners, strict=True)]
        if texts[0] != texts[1]:
            self.told.update(owners)
            pairs = zip((before, after), texts, strict=True)
            before, after = (f"{number} ({text})" if number and text else number or text for number, text in pairs)
        yield from _changed(key, before, after, self._followed.get(owners[1], ""))

    def beside(self, name: str, key: str, side: int) -> str:
        """Return the formula of an entry of a measure in brackets, empty where both graphs have the same."""
        target = f"measures.{name}.{key}"
        text, other = (self._formulas[at].get(target, "") for at in (side, 1 - side))
        self.told.add(target)
        return f" ({text})" if text and text != other else ""

    def followed(self, name: str, measure: Measure) -> str:
        """Return the names of the changed values from which entries of a measure follow."""
        causes = (self._followed.get(f"measures.{name}.{key}", "") for key in as_table(measure))
        return ", ".join(sorted({one for names in causes if names for one in names.split(", ")}))

    def _owner(self, name: str, entry: str, side: int) -> str:
        """Return the entry of a block, or of the innermost subgraph about it, that gives it; "" if none does."""
        if not name:
            return entry
        given = self._rated[side] if entry == RATE else self._formulas[side]
        while name and f"{name}.{entry}" not in given:
            name = name.rpartition(".")[0]
        return f"{name}.{entry}" if name else ""


def _rated(graph: Graph) -> Iterator[str]:
    """Yield the paths of blocks and subgraphs that have a rate of their own."""
    for path, part in parts(graph):
        yield from (path + name for name in part.rates)
        yield from [path[:-1]] if path and part.rate is not None else []


def _top(before: FlatGraph, after: FlatGraph, times: _Times) -> Iterator[GraphDifference]:
    texts = [key for key, form in PLAIN_KEYS.items() if isinstance(form, Text)]
    integers = [key for key, form in PLAIN_KEYS.items() if isinstance(form, Integer) and key != "samples"]
    for key in texts:
        yield from _changed(key, getattr(before.root, key), getattr(after.root, key))
    yield from times.changed(RATE, "", RATE, _rate(before.rate), _rate(after.rate))
    yield from times.changed(DURATION, "", DURATION, _length(before), _length(after))
    for key in integers:
        old, new = (getattr(flat.root, key) for flat in (before, after))
        yield from _changed(key, "" if old is None else str(old), "" if new is None else str(new))


def _values(first: Graph, second: Graph, names: _Names, followed: Mapping[str, str]) -> Iterator[GraphDifference]:
    before = {names.signal(name): value for name, value in values_of(first).items()}
    for name, (old, new) in _both(before, values_of(second)):
        same = old and new and old.number == new.number and old.dimension == new.dimension
        if not same or old.formula != new.formula:
            causes = followed.get(name, "").removeprefix(name)
            yield from _changed(f"values.{name}", old.written if old else "", new.written if new else "", causes)


def _formulas(graph: Graph) -> dict[str, str]:
    """Return formulas by targets; the formulas of the entries of a list belong to the list."""
    texts: dict[str, str] = {}
    for path, part in parts(graph):
        for target, formula in part.formulas.items():
            whole = (path + target).partition("[")[0]
            texts[whole] = f"{texts[whole]}, {formula.text}" if whole in texts else formula.text
    return texts


def _followed(first: Graph, second: Graph, names: _Names) -> dict[str, str]:
    """Return the names of the changed values from which each parameter follows."""
    dependence = Dependence(second)
    numbers = {names.signal(name): number for name, number in Dependence(first).numbers.items()}
    causes = {name: {name} for name, number in dependence.numbers.items() if numbers.get(name, number) != number}
    for step in dependence.steps:
        own = set().union(*(causes.get(path, set()) for path in step.names.values()))
        causes[step.target] = own or causes.get(step.target, set())
    return {target.partition("[")[0]: ", ".join(sorted(own)) for target, own in causes.items() if own}


def _renamed(before: FlatGraph, after: FlatGraph) -> dict[str, str]:
    """Return blocks that bear another name: the same kind, numbers and rate, wired to the same."""
    gone, new = before.blocks.keys() - after.blocks.keys(), after.blocks.keys() - before.blocks.keys()
    renamed: dict[str, str] = {}
    for old in sorted(gone):
        alike = [
            name
            for name in sorted(new - set(renamed.values()))
            if before.blocks[old] == after.blocks[name] and before.rates.get(old) == after.rates.get(name)
        ]
        if len(alike) > 1:
            alike = [name for name in alike if split(name)[1] == split(old)[1]] or alike
        if alike and (len(alike) == 1 or split(alike[0])[1] == split(old)[1]):
            renamed[old] = alike[0]
    return renamed


def _blocks(
    before: FlatGraph,
    after: FlatGraph,
    formulas: tuple[dict[str, str], dict[str, str]],
    followed: Mapping[str, str],
    times: _Times,
) -> Iterator[GraphDifference]:
    for name, (old, new) in _both(before.blocks, after.blocks):
        key = f"blocks.{name}"
        if old is None or new is None:
            yield GraphDifference(key, *("" if block is None else block_text(block) for block in (old, new)))
        elif type(old) is not type(new):
            yield GraphDifference(f"{key}.kind", type(old).__name__, type(new).__name__)
        else:
            for parameter in type(old).parameters:
                path = f"{name}.{parameter}"
                one, other = (table.get(path, "") for table in formulas)
                was, now = number_text(old, parameter), number_text(new, parameter)
                if was != now:
                    was, now = written(old, parameter) or was, written(new, parameter) or now
                if one != other:
                    was, now = (f"{f} ({text})" if f else text for f, text in ((one, was), (other, now)))
                yield from _changed(f"{key}.{parameter}", was, now, followed.get(path, ""))
        if old is not None and new is not None:
            rates, offsets = ([told(flat, name) for flat in (before, after)] for told in (_own_rate, _offset))
            yield from times.changed(f"{key}.{RATE}", name, RATE, rates[0], rates[1])
            yield from times.changed(f"{key}.{CLOCK_OFFSET}", name, CLOCK_OFFSET, offsets[0], offsets[1])


def _other_formulas(
    flats: tuple[FlatGraph, FlatGraph], formulas: tuple[dict[str, str], dict[str, str]], times: _Times
) -> Iterator[GraphDifference]:
    """Yield other formulas of rates, times and entries of measures: those of parameters stand at their blocks."""
    blocks = [(name, block) for flat in flats for name, block in flat.blocks.items()]
    parameters = {f"{name}.{parameter}" for name, block in blocks for parameter in type(block).parameters}
    parameters |= times.told
    yield from changed_entries(
        "formulas.", *({key: text for key, text in table.items() if key not in parameters} for table in formulas)
    )


def _wires(before: FlatGraph, after: FlatGraph) -> Iterator[GraphDifference]:
    sources = [{wire.target: wire.source for wire in flat.wires} for flat in (before, after)]
    yield from changed_entries("wires: ", *sources)


def _measures(flats: tuple[FlatGraph, FlatGraph], times: _Times) -> Iterator[GraphDifference]:
    """Yield the measures that differ, each in one line, with formulas that changed."""
    changed = {name for name, (old, new) in _both(flats[0].measures, flats[1].measures) if old != new}
    lines = [
        {name: _measure(name, flat.measures[name], side, times) for name in changed & flat.measures.keys()}
        | {name: f"{formula.text} {formula.unit}".rstrip() for name, formula in flat.root.derived.items()}
        for side, flat in enumerate(flats)
    ]
    for name, (old, new) in _both(*lines):
        follows = times.followed(name, flats[1].measures[name]) if name in flats[1].measures and old else ""
        yield from _changed(f"measures.{name}", old or "", new or "", follows)


def _probes(before: FlatGraph, after: FlatGraph) -> Iterator[GraphDifference]:
    flats = before, after
    probes = [{probe.signal: f"every {probe.every} {probe.unit}".rstrip() for probe in flat.probes} for flat in flats]
    yield from changed_entries("probes: ", *probes)


def _rest(before: FlatGraph, after: FlatGraph) -> Iterator[GraphDifference]:
    flats = before, after
    tables: dict[str, Sequence[Mapping[str, str]]] = {
        "requirements": list(map(_requirements, flats)),
        "loops": list(map(_loops, flats)),
        "integration": [{key: str(value) for key, value in flat.integration.changed().items()} for flat in flats],
        "exports": [flat.exports for flat in flats],
    }
    for table, entries in tables.items():
        yield from changed_entries(f"{table}.", *entries)


def _requirements(flat: FlatGraph) -> dict[str, str]:
    asked = {name: requirement.as_written() for name, requirement in flat.root.requirements.items()}
    return {name: ", ".join(f"{key} {value}" for key, value in table.items()) for name, table in asked.items()}


def _loops(flat: FlatGraph) -> dict[str, str]:
    entries = {}
    for name, loop in flat.loops.items():
        entries[f"{name}.open_at"] = loop.open_at
        entries |= {f"{name}.{key}": f"{value!r} {REQUIREMENTS[key]}" for key, value in loop.requirements.items()}
    return entries


def _measure(name: str, measure: Measure, side: int, times: _Times) -> str:
    """Return a measure in one line, as in a graph file."""
    entries = ((key, write_seconds(v) if isinstance(v, Fraction) else v) for key, v in as_table(measure).items())
    return ", ".join(f"{key} {value}{times.beside(name, key, side)}" for key, value in entries)


def block_text(block: Block) -> str:
    """Return kind and numbers of a block in one line."""
    changed = (name for name, p in type(block).parameters.items() if getattr(block, name) != p.default)
    numbers = ", ".join(f"{name} = {number_text(block, name)}" for name in changed)
    return type(block).__name__ + (f": {numbers}" if numbers else "")


def number_text(block: Block, name: str) -> str:
    """Return a parameter with its unit."""
    parameter, value = type(block).parameters[name], getattr(block, name)
    if parameter.kind is not float:
        value = list(value) if isinstance(value, tuple) else value
        return str(value).lower() if value in (True, False) else str(value)
    unit = short_unit(unit_of(block, parameter))
    return f"{value!r}" + (f" {unit}" if not same_unit(unit or "1", "1") else "")


def _own_rate(flat: FlatGraph, name: str) -> str:
    """The rate of a block if it differs from the graph's."""
    rate = flat.rates.get(name)
    return "" if rate == flat.rate else _rate(rate)


def _offset(flat: FlatGraph, name: str) -> str:
    return write_seconds(flat.offsets[name]) if name in flat.offsets else ""


def _rate(rate: Any) -> str:
    return "" if rate is None else write_rate(rate)


def _length(flat: FlatGraph) -> str:
    length = "" if flat.duration is None else write_seconds(flat.duration)
    return length if flat.samples is None else f"{flat.samples} ticks"


def changed_entries(place: str, before: Mapping[str, str], after: Mapping[str, str]) -> Iterator[GraphDifference]:
    """Yield what differs between two tables of texts at a place; a missing entry is empty."""
    for name, (old, new) in _both(before, after):
        yield from _changed(place + name, old or "", new or "")


def _changed(key: str, before: str, after: str, follows: str = "") -> Iterator[GraphDifference]:
    if before != after:
        yield GraphDifference(key, before, after, follows)


def _both(first: Mapping[str, Any], second: Mapping[str, Any]) -> Iterator[tuple[str, tuple[Any, Any]]]:
    """Yield the names of both tables with the entry of each, None if it has none."""
    return ((name, (first.get(name), second.get(name))) for name in sorted({*first, *second}))
