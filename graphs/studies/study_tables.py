"""The tables of a study, read into values; everything that is wrong with them is collected."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeVar

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Problem, Refusal, did_you_mean, shown, under
from proofmass.blocks.declaration.units import same_unit
from proofmass.graphs.model.call_numbers import plain_tables
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.flatten import flatten, inside
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.keys import LIMIT_KEYS, RECALIBRATION_KEYS, STUDY_KEYS
from proofmass.graphs.model.limits import EXPECTED_NAME, NAME
from proofmass.graphs.model.loops import MARGIN_MEASURES, VERDICTS, read_moment, read_requirement
from proofmass.graphs.model.names import Missing, find_any, output_of_a_loop
from proofmass.graphs.model.rates import read_duration
from proofmass.graphs.studies.changes import Change, read_change
from proofmass.graphs.studies.correlation import Correlation, correlation_of, read_coefficient
from proofmass.graphs.studies.designs import DESIGNS
from proofmass.graphs.studies.distributions import Spread
from proofmass.graphs.studies.epochs import (
    AGES_EXAMPLE,
    RECALIBRATION_EXAMPLE,
    Recalibration,
    read_intervals,
    regular_ages,
)
from proofmass.graphs.studies.table_entries import checked_table, read_quantity, read_time

_Entry = TypeVar("_Entry")


@dataclasses.dataclass(frozen=True)
class Limit:
    """Limits of a measure of a good sensor from an age on, in its unit; `change` is relative to the value there."""

    at_least: float = -math.inf
    at_most: float = math.inf
    change: float = math.inf
    start: float = 0.0  # age in seconds

    def counted(self, ages: Sequence[float]) -> int:
        """The first epoch that counts."""
        return next((epoch for epoch, age in enumerate(ages) if age >= self.start), len(ages))


def read_decibels(table: Mapping[str, Any], key: str) -> float:
    """A limit of a gain margin."""
    with under(key, table[key]):
        return read_requirement(table[key], "dB")


def _fixed(key: str, parameter: Parameter) -> Refusal:
    """Return the refusal of a parameter that cannot vary, as it is not a floating-point number."""
    kind = {int: "an integer", bool: "true or false", str: "a text", tuple: "a list"}[parameter.kind]
    hint = "sweep it: each of its values is compiled anew, a variant of the study"
    return Refusal(f"is {kind}, not a number that may vary", got=shown(key), hint=hint)


def _ascending(ages: Sequence[Any]) -> str:
    """Return the ages that can be read, as they were written, each once and in order."""
    known: dict[Any, Any] = {}
    for age in reversed(ages):
        with suppress(Refusal):
            known[read_duration(age)] = f'"{age}"' if isinstance(age, str) else str(age)
    return f"write ages = [{', '.join(age for _, age in sorted(known.items()))}]"


def _start(table: Mapping[str, Any], ages: Sequence[float]) -> float:
    """The age from which on a limit counts."""
    start = float(read_time(table.get("from", 0), "from"))
    if start > ages[-1]:
        raise Refusal("no epoch is so old", key="from", got=shown(table["from"]), expected=f"at most {ages[-1]:g} s")
    return start


def _verdict(table: Mapping[str, Any], key: str) -> Any:
    """A limit of the verdict on a loop: the number of a word."""
    if isinstance(table[key], str) and table[key] not in VERDICTS:
        expected = ", ".join(map(shown, VERDICTS))
        raise Refusal("there is no such verdict", key=key, got=shown(table[key]), expected=expected)
    return VERDICTS.get(table[key], table[key]) if isinstance(table[key], str) else table[key]


class StudyTables:
    """Reads the tables of a study and collects what is wrong with them."""

    def __init__(self, graph: Graph, margins: object = "", docs: Mapping[str, str] = STUDY_KEYS) -> None:
        self.graph, self.flat, self.dependence = graph, flatten(graph), Dependence(graph)
        self.docs = docs  # of the tables
        self.problems: list[Problem] = []
        self.written: dict[str, str] = {}  # parameters as written, by names in the flat graph
        self.margins = self.moment("margins", margins)  # when they are wanted; "" where none are
        if self.margins and not self.flat.loops:
            hint = f'add [loops.main] to it with open_at = "{output_of_a_loop(self.flat)}"'
            self.refuse(Refusal("the graph names no loops", hint), "margins")

    def moment(self, key: str, at: object) -> str:
        """Read an operating point."""
        with self.noting(key):
            return read_moment(at)
        return ""

    def parameters(self, table: str, given: object, read: Callable[[object, str], _Entry]) -> Mapping[str, _Entry]:
        """A table, or one in another, whose keys are parameters' names in the flat graph."""
        entries: dict[str, _Entry] = {}
        for key, entry in self.entries(table, given):
            name = self._flat_name(key)
            with self.noting(table, key):
                unit = self._unit_of(key, name)
                if name in entries:
                    raise Refusal("the parameter is named twice")
                entries[name] = read(entry, unit)
                self.written.setdefault(name, key)
        return MappingProxyType(entries)

    def ages(self, epochs: object) -> tuple[float, ...]:
        """Ages in seconds; a study without epochs looks at new sensors."""
        epochs = plain_tables(epochs)
        if epochs == {}:
            return (0.0,)
        table = epochs if isinstance(epochs, Mapping) else {}
        ages = table["ages"] if set(table) == {"ages"} else None
        if set(table) == {"every", "until"}:
            with self.noting("epochs"):
                return regular_ages(table)
            return (0.0,)
        if not isinstance(ages, list | tuple) or not ages:
            self.refuse(Refusal("must hold a list of ages", got=shown(epochs), hint=AGES_EXAMPLE), "epochs")
            return (0.0,)
        read = []
        for number, age in enumerate(ages):
            with self.noting("epochs", "ages"), under(str(number), age):
                read.append(float(read_duration(age)))
        if sorted(set(read)) != read:
            self.refuse(Refusal("must ascend", got=shown(ages), hint=_ascending(ages)), "epochs", "ages")
        return tuple(read) or (0.0,)

    def recalibration(self, entry: object) -> Recalibration:
        """Return times of calibrations, and the parameters that store measures of their runs."""
        if entry == {}:
            return Recalibration()
        with self.noting("recalibration"):
            table = checked_table(plain_tables(entry), RECALIBRATION_KEYS, RECALIBRATION_EXAMPLE)
            every = read_intervals(table)
            carried = self.parameters("recalibration.carried", table.get("carried", {}), self._carried)
            if not carried and not self.problems:
                raise Refusal("a calibration that leaves nothing", hint=RECALIBRATION_EXAMPLE)
            return Recalibration(every, carried)
        return Recalibration()

    def _carried(self, measure: object, unit: str) -> str:
        if not isinstance(measure, str):
            raise Refusal("must be the name of a measure", got=shown(measure))
        if not same_unit(self.unit(measure), unit):
            raise Refusal("has another unit than the parameter", got=self.unit(measure), expected=unit)
        return measure

    def changes(self, given: object, ages: Sequence[float], calibrated: bool) -> Mapping[str, Change]:
        """Changes of measures, which limits may name."""

        def read(name: str, entry: object) -> Change:
            if not NAME.fullmatch(name):
                raise Refusal("not a name", got=shown(name), expected=EXPECTED_NAME)
            if name in self._units:
                raise Refusal("there is a measure of that name", got=shown(name))
            return read_change(entry, self._units, ages, calibrated)

        changes = self.read("changes", given, read)
        self._units |= {n: "1" if c.relative else self._units[c.measure] for n, c in changes.items()}
        return changes

    def limit(self, name: str, entry: object, ages: Sequence[float]) -> Limit:
        """Return the limits of a measure; raises `Refusal`."""
        unit = self.unit(name)
        table = checked_table(entry, LIMIT_KEYS, "write { at_least = -1, at_most = 1 }")
        start = _start(table, ages)
        table = {key: value for key, value in table.items() if key != "from"}
        if self.margins and name in {f"{loop}.stable" for loop in self.flat.loops}:
            table = {key: _verdict(table, key) for key in table}
        units = {key: "1" if key == "change" else unit for key in table}
        table = {key: read_decibels(table, key) if units[key] == "dB" else table[key] for key in table}
        least = {key: 0.0 if key == "change" else -math.inf for key in table}
        limit = Limit(**{key: read_quantity(table, key, units[key], least[key]) for key in table}, start=start)
        if limit.at_least > limit.at_most:
            raise Refusal("no sensor can keep it", got=shown(entry), expected="at_least below at_most")
        return limit

    def design(self, name: object, spread: Mapping[str, Spread]) -> str:
        """Return the design by which sensors are drawn."""
        if name not in DESIGNS:
            hint = did_you_mean(str(name), DESIGNS, "the designs")
            self.refuse(Refusal("there is no such design", got=shown(name), hint=hint), "design")
        elif name != "random" and not spread:
            self.refuse(Refusal("there is nothing to draw", got=shown(name), hint=STUDY_KEYS["spread"]), "design")
        return str(name)

    def correlation(self, given: object, spread: Mapping[str, Spread], design: object) -> Correlation:
        """Coefficients between parameters that are spread normally."""
        pairs = []
        for key, others in self.entries("correlation", given):
            with self.noting("correlation", key):
                if not isinstance(others, Mapping):
                    raise Refusal("must be a table", got=shown(others), hint='write { "adc.reference" = 0.5 }')
                for other in others:
                    coefficient = read_coefficient(others, other)
                    pairs.append((self._flat_name(key), self._flat_name(other), coefficient))
        if pairs and design == "saltelli":
            self.refuse(Refusal("its indices are those of independent parameters", got=shown(design)), "design")
        with self.noting("correlation"):
            return correlation_of(pairs, spread)
        return Correlation()

    def _flat_name(self, key: str) -> str:
        return inside(self.graph, self.graph.exports.get(key, key))

    def unit(self, name: str) -> str:
        """Unit of a measure; raises `Refusal`."""
        if name not in self._units:
            hint = f"{did_you_mean(name, self._units, 'the measures')} Otherwise add {name} to [measures]"
            raise Refusal("there is no such measure", got=shown(name), hint=hint)
        return self._units[name]

    @cached_property
    def _units(self) -> dict[str, str]:
        """Unit of each measure, the margins of loops included where they are measured."""
        units = measure_units(self.flat)
        if self.margins:
            units |= {f"{loop}.{name}": unit for loop in self.flat.loops for name, unit in MARGIN_MEASURES.items()}
        return units

    def read(self, table: str, given: object, read: Callable[[str, Any], _Entry]) -> Mapping[str, _Entry]:
        """Read the entries of a table by name, and note those that are refused."""
        entries: dict[str, _Entry] = {}
        for name, entry in self.entries(table, given):
            with self.noting(table, name):
                entries[name] = read(name, entry)
        return MappingProxyType(entries)

    def entries(self, table: str, entries: object) -> Iterator[tuple[str, Any]]:
        """Yield the entries of a table, as Python has them; refuse anything else."""
        entries = plain_tables(entries)
        if not isinstance(entries, Mapping):
            hint = self.docs[table.partition(".")[0]]
            self.refuse(Refusal("must be a table", got=shown(entries), hint=hint), table)
            return
        yield from ((str(key), entry) for key, entry in entries.items())

    def _unit_of(self, key: str, name: str) -> str:
        """Unit of a parameter or value that may vary; raises `Refusal`."""
        if name not in self.dependence.units:
            return self._varied(key, name)
        followers = self.dependence.followers([name])
        if not any(step.target not in self.dependence.units for step in followers):
            raise Refusal("nothing follows from the value", got=shown(key), hint=f'use it: a parameter = "= {key}"')
        for step in followers:
            if step.fixed:
                hint = "rates, durations and measures are the same in all runs: make a study of each"
                raise Refusal(f"{step.target} follows from it, and cannot vary", got=step.formula.text, hint=hint)
            if step.target not in self.dependence.units:
                try:
                    self._varied(step.target, step.target)
                except Refusal as error:
                    message = f"{step.target} follows from it, and {error}"
                    raise Refusal(message, error.hint, got=step.formula.text) from None
        return self.dependence.units[name]

    def _varied(self, key: str, name: str) -> str:
        """Unit of a number among the parameters that no wire drives; raises `Refusal`."""
        target = find_any(self.flat, name.partition("[")[0])
        if name in self.flat.blocks:
            hint = f'quote the parameter\'s name, "{key}.PARAMETER": without quotes TOML makes tables of its parts'
            raise Refusal("is a block, not a parameter", hint, got=shown(key))
        driver = next((wire.source for wire in self.flat.wires if wire.target == name), "")
        if isinstance(target, Missing) and "." not in name and self.graph.values:
            raise Refusal("there is no such value", did_you_mean(name, self.graph.values, "the values"), got=shown(key))
        if isinstance(target, Missing):
            raise Refusal(target.message, target.hint, got=shown(key))
        if not isinstance(target[1], Parameter):
            numbers = [n for n, p in type(target[0]).parameters.items() if p.kind is float]
            hint = did_you_mean(split(name)[1], numbers, f"parameters of {split(name)[0]}")
            raise Refusal("is a port, not a parameter", got=shown(key), hint=hint)
        if target[1].kind is not float:
            raise _fixed(key, target[1])
        if type(target[0]).has_formats():
            hint = "its numbers are part of its circuit: make a study of each"
            raise Refusal("the block works in fixed point", got=shown(key), hint=hint)
        if driver:
            message, hint = f"is driven by {driver}: a value would change nothing", f"vary {split(driver)[0]} instead"
            raise Refusal(message, got=shown(key), hint=hint)
        return unit_of(target[0], target[1])

    @contextmanager
    def noting(self, *path: str) -> Iterator[None]:
        """Note what is refused inside under a path of keys, and go on."""
        try:
            yield
        except Refusal as error:
            self.refuse(error, *path)

    def refuse(self, error: Refusal, *path: str) -> None:
        """Note a refusal under a path of keys."""
        path = (*path[0].split("."), *path[1:], *([error.key] if error.key not in ("", path[-1]) else []))
        key = ".".join(f'"{part}"' if "." in part else part for part in path)
        self.problems.append(
            Problem(message=str(error), key=key, got=error.got, expected=error.expected, hint=error.hint, path=path)
        )
