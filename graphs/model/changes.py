"""Changes of a graph: values and parameters anywhere inside it, and files named from elsewhere."""

import dataclasses
from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from pathlib import Path
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import keep_written
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.blocks.declaration.units import convert_exactly
from proofmass.graphs.formulas.formula import Formula, is_formula
from proofmass.graphs.model.exports import not_settable
from proofmass.graphs.model.flatten import inside
from proofmass.graphs.model.formula_tables import as_written
from proofmass.graphs.model.graph import AnyGraph, Graph, split
from proofmass.graphs.model.measures import with_entries
from proofmass.graphs.model.rates import read_duration, read_rate
from proofmass.graphs.model.targets import (
    CLOCK_OFFSET,
    DURATION,
    RATE,
    Target,
    entry_of,
    is_of_measure,
    number_of,
    offset_of,
    rate_of,
    target_at,
)
from proofmass.graphs.model.values import NamedValue, read_values, with_number


def with_parameters(graph: AnyGraph, changes: Mapping[str, object]) -> AnyGraph:
    """Return the graph with values and parameters changed, each named by its path or its exported name.

    Whatever follows from a value moves with it. A number removes the formula of its parameter, and
    a text with an equals sign is a new formula: `{"sensor.mass": "= 2 * mass"}`. A rate is "rate",
    or "adc.rate" of a block or subgraph of the graph itself, as a clock offset is
    "adc.clock_offset"; a run may have another "duration".
    """
    values, formulas = dict[str, object](graph.values), dict(graph.formulas)
    numbers: dict[str, object] = {}
    rates: dict[str, Any] = {}
    offsets: dict[str, Fraction] = {}
    problems: list[Problem] = []
    for key, change in changes.items():
        target = graph.exports.get(key, key)
        if target in graph.values:
            problems += _other_dimension(key, graph.values[target], change)
            values[target] = change if isinstance(change, str) else _in_coherent_units(change, graph.values[target])
            continue
        target = inside(graph, target)
        formulas = {of: formula for of, formula in formulas.items() if of.partition("[")[0] != target}
        entries, own, wrong = read_formulas(target, change)
        formulas |= own
        problems += wrong
        if is_formula(change):
            continue
        if is_rate(graph, target):
            try:
                if split(target)[1] == CLOCK_OFFSET:
                    offsets[split(target)[0]] = read_duration(entries)
                else:
                    rates[target] = (read_duration if target == DURATION else read_rate)(entries)
            except Refusal as error:
                problems.append(error.problem(key, change))
        else:
            numbers[key] = entries
    read, wrong = read_values(values, {})
    problems += wrong
    if problems:
        raise ModelError(problems)
    changed = graph.changed(values=read, formulas=formulas)
    return settled(_with_offsets(_with_rates(changed, rates), offsets), numbers)


def is_rate(graph: Graph, target: str) -> bool:
    """Return whether a name is a rate or clock offset of the graph or a part of it, or the duration of a run."""
    owner, _, entry = target.rpartition(".")
    known = owner in graph.blocks or owner in graph.subgraphs
    return target in (RATE, DURATION) or (entry in (RATE, CLOCK_OFFSET) and known)


def settled(graph: AnyGraph, numbers: Mapping[str, object]) -> AnyGraph:
    """Return the graph with these parameters, and those of its formulas; raises `ModelError`."""
    problems: list[Problem] = []
    rates: dict[str, Any] = {}
    offsets: dict[str, Fraction] = {}
    parameters = dict(numbers)
    entries: dict[str, dict[str, Any]] = {}  # of measures, by their names
    for target, formula in graph.formulas.items():
        name, entry = split(target)
        path: tuple[str, ...] = ("formulas", target)
        if not graph.place.has(path):  # it stands where the number would
            path = ("blocks", name, entry) if name in graph.blocks else path if name else (target,)
        try:
            if is_of_measure(graph, target):
                path = (*name.split("."), entry)
                entries.setdefault(path[1], {})[entry] = entry_of(formula, graph.values, entry)
            elif entry == RATE and (not name or name in graph.blocks or name in graph.subgraphs):
                rates[target] = read_rate(rate_of(formula, graph.values))
            elif entry == CLOCK_OFFSET and (name in graph.blocks or name in graph.subgraphs):
                offsets[name] = read_duration(offset_of(formula, graph.values))
            elif target == DURATION:
                rates[target] = read_duration(Fraction(repr(number_of(formula, graph.values, Target("s")))))
            else:
                parameters[target] = number_of(formula, graph.values, target_at(graph, target))
        except Refusal as error:
            problems.append(error.problem(target, formula.text, path=path))
    if problems:
        raise ModelError(problems)
    try:
        measured = graph.changed(measures=with_entries(graph.measures, entries)) if entries else graph
    except ModelError as error:
        raise ModelError([as_written(problem, graph.formulas) for problem in error.problems]) from None
    return _with_numbers(_with_offsets(_with_rates(measured, rates), offsets), parameters)


def _with_rates(graph: AnyGraph, rates: Mapping[str, Any]) -> AnyGraph:
    """Return the graph with rates and duration by their targets: "rate", "duration", "adc.rate"."""
    if not rates:
        return graph
    alone = {target: rate for target, rate in rates.items() if target in (RATE, DURATION)}
    named = {split(target)[0]: rate for target, rate in rates.items() if target not in alone}
    own = {name: rate for name, rate in named.items() if name in graph.blocks}
    parts = {name: part.changed(rate=named[name]) for name, part in graph.subgraphs.items() if name in named}
    return graph.changed(rates={**graph.rates, **own}, subgraphs={**graph.subgraphs, **parts}, **alone)


def _with_offsets(graph: AnyGraph, offsets: Mapping[str, Fraction]) -> AnyGraph:
    if not offsets:
        return graph
    return graph.changed(offsets={name: made for name, made in {**graph.offsets, **offsets}.items() if made})


def _with_numbers(graph: AnyGraph, changes: Mapping[str, object]) -> AnyGraph:
    """Return the graph with parameters and values of subgraphs changed; its own formulas are not evaluated."""
    blocks, parts = dict(graph.blocks), dict(graph.subgraphs)
    problems: list[Problem] = []
    by_block: dict[str, dict[str, object]] = {}
    for key, value in changes.items():
        signal = graph.exports.get(key, key)
        block, parameter = split(signal)
        if block not in blocks:
            block, _, parameter = signal.partition(".")
        if block not in blocks and block not in parts:
            dotted = "." in signal
            hint = did_you_mean(block, [*blocks, *parts], "the blocks") if dotted else not_settable(graph, signal)
            message = "there is no such block" if dotted else "there is no such value"
            problems.append(Problem(message=message, key=key, got=shown(block), hint=hint))
        else:
            by_block.setdefault(block, {})[parameter] = value
    for name, values in by_block.items():
        try:
            if name in parts:
                parts[name] = change_part(parts[name], values)
            else:
                blocks[name] = _changed(blocks[name], values)
        except ModelError as error:
            problems += [dataclasses.replace(p, key=f"{name}.{(*p.path, p.key)[0]}", path=()) for p in error.problems]
    if problems:
        raise ModelError(problems)
    return graph.changed(blocks=blocks, subgraphs=parts)


def changed_blocks(blocks: Mapping[str, Block], values: Mapping[str, object]) -> dict[str, Block]:
    """Blocks of a flat graph with these parameters, by `block.parameter`; raises `ModelError`."""
    changes: dict[str, dict[str, object]] = {}
    for signal, value in values.items():
        name, parameter = split(signal)
        changes.setdefault(name, {})[parameter] = value
    return {name: _changed(blocks[name], changed) for name, changed in changes.items()}


def change_part(part: AnyGraph, values: Mapping[str, object]) -> AnyGraph:
    """Change values of a subgraph. A name without a dot is a value of it, or one it exports."""
    unknown = [name for name in values if "." not in name and name not in part.exports and name not in part.values]
    if unknown:
        message = "the subgraph exports no such parameter"
        raise ModelError([Problem(message=message, key=n, got=n, hint=not_settable(part, n)) for n in unknown])
    return with_parameters(part, values)


def read_formulas(target: str, value: object) -> tuple[object, dict[str, Formula], list[Problem]]:
    """Return the numbers and formulas in a parameter's value; None if one formula gives all of it.

    Entries of a list that are formulas are 0 among the numbers, until they are resolved.
    """
    formulas: dict[str, Formula] = {}
    problems: list[Problem] = []
    listed = isinstance(value, list | tuple)
    entries: list[object] = list(value) if isinstance(value, list | tuple) else [value]
    for index, entry in enumerate(entries):
        if is_formula(entry):
            key = f"{target}[{index}]" if listed else target
            try:
                formulas[key] = Formula(entry)
            except Refusal as error:
                problems.append(error.problem(key, entry))
            entries[index] = 0.0
    if not formulas:
        return value, {}, problems
    return (entries if listed else None), formulas, problems


def _other_dimension(key: str, value: NamedValue, change: object) -> Iterator[Problem]:
    """A quantity in place of a value of another dimension."""
    if isinstance(change, str) and not is_formula(change):
        try:
            convert_exactly(change, value.coherent_unit)
        except Refusal as error:
            yield error.problem(key, change, expected=f"a quantity in {value.coherent_unit}")


def _in_coherent_units(change: object, value: NamedValue) -> object:
    """A number in place of a value, which is in coherent units."""
    if isinstance(change, bool) or not isinstance(change, int | float):
        return change
    return with_number(value, change)


def _changed(block: Block, values: dict[str, object]) -> Block:
    now = {name: getattr(block, name) for name in type(block).parameters}
    for name, value in values.items():
        whole, bracket, index = name.partition("[")
        if bracket and isinstance(now.get(whole), tuple):
            entries = list(now[whole])
            entries[int(index[:-1])] = value
            now[whole] = tuple(entries)
        else:
            now[name] = value
    return keep_written(type(block)(**now), block, {name.partition("[")[0] for name in values})


def moved(graph: AnyGraph, folder: str) -> AnyGraph:
    """The graph with the recordings that it plays named from another folder."""
    return with_recordings(
        graph, folder, lambda here, file: file if here == folder else _from(Path(folder), Path(here) / file)
    )


def recording_of(block: Block) -> str:
    """Return the file of the recording that a block plays; "" for any other block."""
    recorded = any(buffer.recorded for buffer in type(block).buffers.values())
    return getattr(block, "file", "") if recorded else ""


def recordings_of(graph: Graph) -> list[str]:
    """Return the recordings that a graph and its subgraphs play, as they are named there."""
    inside = [file for part in graph.subgraphs.values() for file in recordings_of(part)]
    return [*filter(None, map(recording_of, graph.blocks.values())), *inside]


def with_recordings(graph: AnyGraph, folder: str, named: Callable[[str, str], str]) -> AnyGraph:
    """The graph with other names, from a folder, of the recordings that it plays: `named` gets folder and name."""
    parts = {name: with_recordings(part, folder, named) for name, part in graph.subgraphs.items()}
    played: dict[str, Block] = {}
    for name, block in graph.blocks.items():
        if file := recording_of(block):
            other = named(graph.place.folder, file)
            if other != file:
                played[name] = _changed(block, {"file": other})
    if not played and all(part is graph.subgraphs[name] for name, part in parts.items()):
        return graph
    place = dataclasses.replace(graph.place, folder=folder)
    return graph.changed(blocks={**graph.blocks, **played}, subgraphs=parts, place=place)


def _from(folder: Path, file: Path) -> str:
    """The file as named from the folder: relative where it lies inside."""
    absolute, inside = file.resolve(), folder.resolve()
    if file.is_absolute() and not absolute.is_relative_to(inside):
        return str(file)
    return str(absolute.relative_to(inside) if absolute.is_relative_to(inside) else absolute)
