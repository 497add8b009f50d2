"""A Monte Carlo study of a graph: many sensors, drawn, swept and aged from epoch to epoch."""

import dataclasses
import math
from collections.abc import Callable, Iterator, Mapping
from functools import cached_property
from typing import Any, Self

from proofmass.blocks.arithmetic.counter_random import normal_quantile
from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.formulas.tree import plainly
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.changes import changed_blocks
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.flatten import FlatGraph, flatten
from proofmass.graphs.model.graph import Graph, Placed
from proofmass.graphs.model.keys import STUDY_INTEGERS
from proofmass.graphs.model.limits import LARGEST_STUDY
from proofmass.graphs.studies.ageing import Drift
from proofmass.graphs.studies.changes import Change
from proofmass.graphs.studies.correlation import Correlation
from proofmass.graphs.studies.designs import Design, stream_of
from proofmass.graphs.studies.distributions import Spread
from proofmass.graphs.studies.epochs import Recalibration
from proofmass.graphs.studies.study_tables import Limit

RUN, EPOCH, AGE, RECALIBRATION, FAULT = COLUMNS = "run", "epoch", "age", "recalibration", "fault"  # of its tables
AFTER_CALIBRATION = 2**31  # added to it for the runs that follow calibrations


@dataclasses.dataclass(frozen=True, kw_only=True)
class Study(Placed):
    """A graph with the spread, sweep and drift of its parameters; run k is a pure function of it, seed and k.

    Run k is sensor k // n at point k % n of the sweep's n: every point is tried with the same
    sensors. Each run is repeated at each epoch, an age at which its drifting parameters have moved
    on, with what calibrations before it have left. Parameters are named as in the flat graph.
    """

    graph: Graph  # that runs
    runs: int  # sensors
    seed: int  # of all that is drawn
    design: str  # how sensors are drawn
    spread: Mapping[str, Spread]  # distributions by parameter
    correlation: Correlation  # between parameters
    sweep: Mapping[str, tuple[float, ...]]  # values by parameter, in its unit
    epochs: tuple[float, ...]  # ages in seconds
    drift: Mapping[str, Drift]  # laws by parameter
    recalibration: Recalibration  # when, and which parameters store the result
    margins: str  # time of the operating point at which margins are measures too; "" measures none
    changes: Mapping[str, Change]  # measures of their own, by name
    limits: Mapping[str, Limit]  # by measure
    stop: Mapping[str, float]  # half a mean's confidence interval, small enough, by measure
    written: Mapping[str, str] = dataclasses.field(compare=False, repr=False)  # parameters, by names in the flat graph

    def changed(self, *, runs: int, seed: int) -> Self:
        """Return the study with other numbers; raises `ModelError`."""
        study = self._with(runs=runs, seed=seed)
        problems = list(bad_numbers(study))
        if problems:
            raise ModelError(problems)
        return study

    def with_limits(self, limits: Mapping[str, Limit]) -> Self:
        """Return the study with other limits of its measures."""
        return self._with(limits=limits)

    def asked_as(self, other: "Study") -> Self:
        """Return the study with what another asks of the same runs: its limits, and when the means are known."""
        return self._with(limits=other.limits, stop=other.stop)

    def at(self, values: Mapping[str, float]) -> Self:
        """Return the study about other values of parameters: a sweep with one point in each."""
        return self._with(sweep={**self.sweep, **{name: (value,) for name, value in values.items()}})

    def _with(self, **values: Any) -> Self:
        study = type(self).__new__(type(self))
        fields: dict[str, Any] = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        Study.__init__(study, **{**fields, **values})
        return study

    @cached_property
    def points(self) -> int:
        """Points of the sweep, and intervals between calibrations, multiplied."""
        return math.prod(len(values) for values in self.sweep.values()) * len(self.recalibration.every)

    def unit_of(self, name: str) -> str:
        """Unit of a parameter or value, by its name in the flat graph."""
        return self.adjustable.unit_of(name)

    def name_of(self, name: str) -> str:
        """Parameter as the study writes it, by its name in the flat graph: exported names stay."""
        return self.written.get(name, name)

    @cached_property
    def flat(self) -> FlatGraph:
        """The graph without subgraphs."""
        return flatten(self.graph)

    @cached_property
    def dependence(self) -> Dependence:
        """Quantities that follow from the values of the graph."""
        return Dependence(self.graph)

    def nominal(self, name: str) -> float:
        """Return a parameter or value of the graph."""
        return self.adjustable.nominal(name)

    @cached_property
    def adjustable(self) -> Adjustable:
        """Its parameters and values that may vary."""
        return Adjustable(self.flat, self.dependence)

    @cached_property
    def moved(self) -> list[str]:
        """Parameters and values that are spread or drift, each after those that it follows from."""
        places = self.dependence.places
        return sorted(dict.fromkeys([*self.spread, *self.drift]), key=lambda name: places.get(name, -1))

    @cached_property
    def ageing(self) -> frozenset[str]:
        """Parameters and values that differ from epoch to epoch: those that drift, and what follows from them."""
        ageing = set(self.drift)
        for step in self.dependence.steps:
            if step.target not in self.sweep and not ageing.isdisjoint(step.names.values()):
                ageing.add(step.target)
        return frozenset(ageing)

    def settings(self, values: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly) -> dict[str, Any]:
        """The parameters that belong to parameters and values; the numbers may be arrays, of which `apply` knows."""
        return self.adjustable.settings(values, apply)

    def point(self, run: int) -> dict[str, float]:
        """Return the parameters of the sweep in a run; the last one moves fastest."""
        number, chosen = run % self.points // len(self.recalibration.every), dict[str, float]()
        for name, values in reversed(list(self.sweep.items())):
            number, place = divmod(number, len(values))
            chosen[name] = values[place]
        return dict(reversed(chosen.items()))

    def recalibrated_every(self, run: int) -> float:
        """Seconds between the calibrations of a run; of all that a study tries it moves fastest."""
        return self.recalibration.every[run % len(self.recalibration.every)]

    def calibrated(self, run: int) -> tuple[bool, ...]:
        """Per epoch, whether a run calibrates there."""
        return self.recalibration.at(self.epochs, self.recalibrated_every(run))

    @property
    def followed(self) -> bool:
        """True if a run follows each calibration, to compare later ones with it."""
        return any(change.since_calibration for change in self.changes.values())

    @cached_property
    def designed(self) -> Design:
        """The deviates of the sensors."""
        return Design(self.design, tuple(sorted(self.spread)), self.runs, self.seed)

    def draw(self, run: Any) -> Any:
        """The independent draw of a run, or of an array of them: its sensor, or its group in Saltelli's design."""
        return run // self.points // self.designed.group

    def peer(self, run: int) -> int:
        """The run whose noise and drift a run shares: its own number, but for the groups of Saltelli's design."""
        peer: int = self.draw(run) * self.points + run % self.points
        return peer

    def drawn(self, run: int, *, apart: bool = False) -> list[dict[str, float]]:
        """Parameters of a run by `block.parameter` of the flat graph, at each epoch, but for what
        calibrations left.

        With `apart` each of them is what it would be if nothing that it follows from were spread or
        drifted.
        """
        sensor, swept = run // self.points, self.point(run)
        at = [dict(swept) for _ in self.epochs]
        deviates = {name: self.designed.deviate(sensor, name) for name in self.spread}
        normals = self.correlation.applied({n: normal_quantile(deviates[n]) for n in self.correlation.names})
        for name in self.moved:
            known = [swept] * len(at) if apart else at
            if name in swept:
                bases = [swept[name]] * len(at)
            else:  # what it is before it is spread, where others have moved
                bases = [self.dependence.followed(values).get(name, self.nominal(name)) for values in known]
            for values, now in zip(at, self._aged(name, bases, run, deviates, normals), strict=True):
                values[name] = now
        return at

    def _aged(
        self, name: str, bases: list[float], run: int, deviates: Mapping[str, float], normals: Mapping[str, float]
    ) -> list[float]:
        """One parameter of a run at each epoch, spread and aged from its base there."""

        def spread(base: float) -> float:
            if name in normals:
                return self.spread[name].of_normal(base, normals[name])
            return self.spread[name].at(base, deviates[name]) if name in self.spread else base

        values = {base: spread(base) for base in bases}
        if name not in self.drift:
            return [values[base] for base in bases]
        drifting, stream = self.peer(run) // self.points, stream_of("drift", name)
        aged = {b: self.drift[name].aged(v, self.epochs, self.seed, drifting, stream) for b, v in values.items()}
        return [aged[base][epoch] for epoch, base in enumerate(bases)]

    @cached_property
    def varying(self) -> frozenset[str]:
        """Parameters that differ between runs, by `block.parameter` of the flat graph."""
        return self.adjustable.following([*self.drawn(0)[0], *self.recalibration.carried])

    def blocks(self, values: Mapping[str, float]) -> dict[str, Block]:
        """The blocks that have these parameters and values; raises `ModelError` for a number out of bounds."""
        return changed_blocks(self.flat.blocks, self.settings(values))

    def text(self) -> str:
        """Everything that decides over the bits of a run, a line each: what a ledger compares."""
        lines = [f"seed = {self.seed}", f"epochs = {list(self.epochs)}", f"design = {self.design}"]
        if self.design == "latin_hypercube":
            lines.append(f"runs = {self.runs}")  # the strata depend on it
        lines += [f"correlation.{first}.{second} = {value}" for first, second, value in self.correlation.pairs]
        lines += [f"sweep.{name} = {entry}" for name, entry in self.sweep.items()]  # the last one moves fastest
        for table in ("spread", "drift"):
            lines += [f"{table}.{name} = {entry}" for name, entry in sorted(getattr(self, table).items())]
        lines += [f"changes.{name} = {change}" for name, change in self.changes.items()]
        lines += [*self.recalibration.text(), *([f"margins = {self.margins}"] if self.margins else [])]
        return "\n".join(lines) + "\n"


def bad_numbers(study: Study) -> Iterator[Problem]:
    """Problems of how many runs a study has, and of what a run leaves."""
    for key, form in STUDY_INTEGERS.items():
        value = getattr(study, key)
        if not form.holds(value):
            message = "out of range" if form.whole(value) else "must be an integer"
            expected = f"an integer from {form.lowest:,} to {form.highest:,}"
            yield Problem(message=message, got=shown(value), expected=expected, path=(key,))
            return
    size = study.runs * study.points * len(study.epochs)
    largest = AFTER_CALIBRATION if study.followed else LARGEST_STUDY
    if size > largest:
        expected = f"at most {largest:g} runs, points and epochs multiplied"
        yield Problem(message="too large", got=f"{size:g}", expected=expected, path=("runs",))
    if study.drift and not any(study.epochs):
        hint = 'add [epochs] and below it ages = ["0 s", "10 years"]'
        yield Problem(message="nothing drifts without epochs: the age of all sensors is 0", hint=hint, path=("drift",))
    if not study.graph.measures and not study.margins:
        hint = 'add [measures] to the graph: bias = { signal = "adc.code", statistic = "mean" }'
        hint += ', or margins = "0 s" to the study of a graph with loops'
        file, key = study.graph.place.file, "measures"
        yield Problem(message="the graph has no measures: a study would keep nothing", file=file, key=key, hint=hint)
    for owner, table, names in ((study.graph, "measures", study.graph.measures), (study, "changes", study.changes)):
        for name in sorted(set(COLUMNS).intersection(names)):
            message, hint = "the name is taken: tables of a study have a column of it", "name it by its signal"
            yield owner.placed(Problem(message=message, key=f"{table}.{name}", hint=hint, path=(table, name)))
