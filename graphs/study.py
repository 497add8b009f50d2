"""A Monte Carlo study of a graph: many sensors, drawn, swept over a grid and aged from epoch to epoch."""

import dataclasses
import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from types import MappingProxyType
from typing import Any, TypeVar

from proofmass.blocks.declare import Block
from proofmass.blocks.parameter import Parameter
from proofmass.blocks.problem import ModelError, Problem, shown
from proofmass.blocks.units import UnitError
from proofmass.graphs.ageing import Drift, read_drift
from proofmass.graphs.check import checked
from proofmass.graphs.distributions import (
    Spread,
    TableError,
    checked_table,
    read_quantity,
    read_spread,
    read_values,
)
from proofmass.graphs.flatten import flatten, inside
from proofmass.graphs.graph import LARGEST_SEED, NOWHERE, Graph, Place, split
from proofmass.graphs.hints import like
from proofmass.graphs.keys import LIMIT_KEYS, STUDY_KEYS
from proofmass.graphs.measures import measure_unit
from proofmass.graphs.names import Missing, find_any
from proofmass.graphs.rates import read_duration

LARGEST_STUDY = 2**32  # runs times epochs: a word of the counter of the noise
Entry = TypeVar("Entry")
Tables = Mapping[str, Any]
NOTHING: Tables = MappingProxyType({})


@dataclasses.dataclass(frozen=True)
class Limit:
    """What a measure of a good sensor keeps, in its unit; `change` is relative to the value at the first epoch."""

    at_least: float = -math.inf
    at_most: float = math.inf
    change: float = math.inf

    def kept(self, values: Sequence[float]) -> bool:
        """Whether the values of one sensor, epoch by epoch, stay within; a run that failed does not."""
        inside = all(self.at_least <= value <= self.at_most for value in values)
        largest = self.change * abs(values[0]) if math.isfinite(self.change) else math.inf
        return inside and all(abs(value - values[0]) <= largest for value in values)


@dataclasses.dataclass(frozen=True, init=False)
class Study:
    """A graph with the spread, sweep and drift of its parameters; run k is a pure function of it, seed and k.

    The tables are those of a study file: `spread={"adc.reference": {"normal": "200 ppm", "relative": True}}`. Run k is
    sensor k // n at point k % n of the sweep's n: every point is tried with the same sensors. Each run is repeated at
    each epoch, an age at which its drifting parameters have moved on.

    Raises `ModelError` with every problem.
    """

    graph: Graph
    runs: int  # sensors
    seed: int
    spread: Mapping[str, Spread]
    sweep: Mapping[str, tuple[float, ...]]
    epochs: tuple[float, ...]  # ages in seconds
    drift: Mapping[str, Drift]
    limits: Mapping[str, Limit]
    place: Place = dataclasses.field(compare=False, repr=False)

    def __init__(
        self,
        graph: Graph,
        *,
        runs: int = 100,
        seed: int = 0,
        spread: Tables = NOTHING,
        sweep: Tables = NOTHING,
        epochs: Tables = NOTHING,
        drift: Tables = NOTHING,
        limits: Tables = NOTHING,
        place: Place = NOWHERE,
    ) -> None:
        read = _Reader(checked(graph))
        values = {
            "graph": graph,
            "runs": runs,
            "seed": seed,
            "spread": read.parameters("spread", spread, read_spread),
            "sweep": read.parameters("sweep", sweep, lambda values, unit: read_values(values, "", unit)),
            "epochs": read.ages(epochs),
            "drift": read.parameters("drift", drift, read_drift),
            "limits": read.limits(limits),
            "place": place,
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        read.problems += self._bad_numbers()
        if read.problems:
            raise ModelError([self.placed(problem) for problem in read.problems])

    def changed(self, *, runs: int, seed: int) -> "Study":
        """The study with other numbers; raises `ModelError`."""
        made = object.__new__(Study)
        for field in dataclasses.fields(self):
            object.__setattr__(
                made, field.name, {"runs": runs, "seed": seed}.get(field.name, getattr(self, field.name))
            )
        problems = list(made._bad_numbers())
        if problems:
            raise ModelError(problems)
        return made

    def placed(self, problem: Problem) -> Problem:
        """A problem with the file and line that its key has in this study."""
        return problem if problem.file else problem.at(*self.place.find(problem.path))

    def _bad_numbers(self) -> Iterator[Problem]:
        for key, value, least, most in (("runs", self.runs, 1, LARGEST_STUDY), ("seed", self.seed, 0, LARGEST_SEED)):
            if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= most:
                expected = f"an integer from {least} to {most:g}"
                yield Problem(message="out of range", key=key, got=shown(value), expected=expected, path=(key,))
                return
        size = self.runs * self.points * len(self.epochs)
        if size > LARGEST_STUDY:
            expected = f"at most {LARGEST_STUDY:g} runs, points and epochs multiplied"
            yield Problem(message="too large", key="runs", got=f"{size:g}", expected=expected, path=("runs",))
        if not self.graph.measures:
            hint = 'add [measures] to the graph: bias = { signal = "adc.code", statistic = "mean" }'
            file, key = self.graph.place.file, "measures"
            yield Problem(
                message="the graph has no measures: a study would keep nothing", file=file, key=key, hint=hint
            )

    @cached_property
    def points(self) -> int:
        """Points of the sweep."""
        return math.prod(len(values) for values in self.sweep.values())

    @cached_property
    def flat(self) -> Graph:
        """The graph without subgraphs."""
        return flatten(self.graph)

    def point(self, run: int) -> dict[str, float]:
        """What the parameters of the sweep are in a run; the last one moves fastest."""
        number, chosen = run % self.points, dict[str, float]()
        for name, values in reversed(list(self.sweep.items())):
            number, place = divmod(number, len(values))
            chosen[name] = values[place]
        return dict(reversed(chosen.items()))

    def drawn(self, run: int) -> list[dict[str, float]]:
        """Parameters of a run by `block.parameter` of the flat graph, at each epoch."""
        sensor, swept = run // self.points, self.point(run)
        at = [dict(swept) for _ in self.epochs]
        for name in dict.fromkeys([*self.spread, *self.drift]):
            block, parameter = split(name)
            value: float = swept[name] if name in swept else getattr(self.flat.blocks[block], parameter)
            if name in self.spread:
                value = self.spread[name].drawn(value, self.seed, sensor, _stream("spread", name))
            aged = [value] * len(self.epochs)
            if name in self.drift:
                aged = self.drift[name].aged(value, self.epochs, self.seed, sensor, _stream("drift", name))
            for epoch, now in zip(at, aged, strict=True):
                epoch[name] = now
        return at

    def blocks(self, values: Mapping[str, float]) -> dict[str, Block]:
        """The blocks that have these parameters; raises `ModelError` for a value out of bounds."""
        changes: dict[str, dict[str, float]] = {}
        for signal, value in values.items():
            name, parameter = split(signal)
            changes.setdefault(name, {})[parameter] = value
        made = {}
        for name, changed in changes.items():
            block = self.flat.blocks[name]
            made[name] = type(block)(**({p: getattr(block, p) for p in block.parameters} | changed))
        return made

    def text(self) -> str:
        """Everything that decides over the bits of a run, a line each: what a ledger compares."""
        lines = [f"seed = {self.seed}", f"epochs = {list(self.epochs)}"]
        for table in ("spread", "sweep", "drift"):
            lines += [f"{table}.{name} = {entry}" for name, entry in sorted(getattr(self, table).items())]
        return "\n".join(lines) + "\n"


def _stream(what: str, name: str) -> int:
    """Number of a parameter's random stream: from its name alone; no block has a name with a space."""
    return zlib.crc32(f"{what} {name}".encode())


class _Reader:
    """Reads the tables of a study and collects what is wrong with them."""

    def __init__(self, graph: Graph) -> None:
        self.graph, self.flat = graph, flatten(graph)
        self.problems: list[Problem] = []

    def parameters(self, table: str, given: object, read: Callable[[object, str], Entry]) -> Mapping[str, Entry]:
        """A table whose keys are parameters, by their names in the flat graph."""
        made: dict[str, Entry] = {}
        for key, entry in self._entries(table, given):
            name = inside(self.graph, self.graph.exports.get(key, key))
            found = self._parameter(table, key, name)
            if found is None:
                continue
            block, parameter = found
            with_unit = block.unit_of(parameter)
            try:
                if name in made:
                    raise TableError("the parameter is named twice")
                made[name] = read(entry, with_unit)
            except TableError as error:
                self._refuse(error, table, key)
        return MappingProxyType(made)

    def ages(self, given: object) -> tuple[float, ...]:
        """Ages in seconds; a study without epochs looks at new sensors."""
        if given == {}:
            return (0.0,)
        ages = given.get("ages") if isinstance(given, Mapping) and set(given) == {"ages"} else None
        example = 'write ages = ["0 h", "1 year", "10 year"]'
        if not isinstance(ages, list | tuple) or not ages:
            self._refuse(TableError("must hold a list of ages", got=shown(given), hint=example), "epochs")
            return (0.0,)
        read = []
        for number, age in enumerate(ages):
            try:
                read.append(float(read_duration(age)))
            except UnitError as error:
                self._refuse(TableError(str(error), got=shown(age), hint=error.hint), "epochs", "ages", str(number))
        if sorted(set(read)) != read:
            self._refuse(TableError("must ascend", got=shown(ages), hint=example), "epochs", "ages")
        return tuple(read) or (0.0,)

    def limits(self, given: object) -> Mapping[str, Limit]:
        """Limits of measures."""
        made: dict[str, Limit] = {}
        for name, entry in self._entries("limits", given):
            measure = self.flat.measures.get(name)
            try:
                if measure is None:
                    raise TableError("there is no such measure", hint=like(name, self.flat.measures, "the measures"))
                block, port = split(measure.signal)
                unit = self.flat.blocks[block].unit_of(self.flat.blocks[block].outputs[port])
                unit = measure_unit(measure.statistic, unit)
                table = checked_table(entry, LIMIT_KEYS, "write { at_least = -1, at_most = 1 }")
                units = {key: "1" if key == "change" else unit for key in table}
                made[name] = Limit(**{key: read_quantity(table, key, units[key]) for key in table})
            except TableError as error:
                self._refuse(error, "limits", name)
        return MappingProxyType(made)

    def _entries(self, table: str, given: object) -> Iterator[tuple[str, Any]]:
        if not isinstance(given, Mapping):
            self._refuse(TableError("must be a table", got=shown(given), hint=STUDY_KEYS[table]), table)
            return
        yield from ((str(key), entry) for key, entry in given.items())

    def _parameter(self, table: str, key: str, name: str) -> tuple[Block, Parameter] | None:
        """Block and parameter of a name, where it is a number that no wire drives."""
        found = find_any(self.flat, name, self.graph)
        driver = next((wire.source for wire in self.flat.wires if wire.target == name), "")
        if isinstance(found, Missing):
            self._refuse(TableError(found.message, got=shown(key), hint=found.hint), table, key)
        elif not isinstance(found[1], Parameter):
            numbers = [n for n, p in found[0].parameters.items() if p.kind is float]
            hint = like(split(name)[1], numbers, f"parameters of {split(name)[0]}")
            self._refuse(TableError("is a port, not a parameter", got=shown(key), hint=hint), table, key)
        elif found[1].kind is not float:
            self._refuse(TableError("is not a number that may vary", got=shown(key)), table, key)
        elif found[0].digital():
            hint = "its numbers are part of its circuit: make a study of each"
            self._refuse(TableError("the block works in fixed point", got=shown(key), hint=hint), table, key)
        elif driver:
            message, hint = f"is driven by {driver}: a value would change nothing", f"vary {split(driver)[0]} instead"
            self._refuse(TableError(message, got=shown(key), hint=hint), table, key)
        else:
            return found[0], found[1]
        return None

    def _refuse(self, error: TableError, *path: str) -> None:
        path += (error.key,) if error.key else ()
        key = ".".join(f'"{part}"' if "." in part else part for part in path)
        self.problems.append(
            Problem(message=str(error), key=key, got=error.got, expected=error.expected, hint=error.hint, path=path)
        )
