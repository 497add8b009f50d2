"""A tuning: parameters that are free within bounds, and the goals that they are to meet."""

import dataclasses
import itertools
import math
from collections.abc import Mapping
from functools import cached_property
from typing import Any

from proofmass.graphs.files.toml_writer import inline, key_of, write_graph
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Graph, Placed
from proofmass.graphs.model.quantities import Quantity, quantity_table
from proofmass.graphs.studies.ages import age_text
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_writer import write_study

_STEP = 1e-6  # of a value, over which laws of drift are differentiated
MOST_POINTS = 256  # operating points times corners


@dataclasses.dataclass(frozen=True)
class Free:
    """A free parameter in its unit, on a logarithmic or a linear axis."""

    at_least: float
    at_most: float
    logarithmic: bool

    def value(self, part: float) -> float:
        """Return the value at a part of the way from the lower to the upper bound."""
        if self.logarithmic:
            return self.at_least * math.exp(part * math.log(self.at_most / self.at_least))
        return self.at_least + part * (self.at_most - self.at_least)

    def part(self, value: float) -> float:
        """Return the part of the way at which a value lies, from 0 to 1."""
        inside = self.inside(value)
        if self.logarithmic:
            return math.log(inside / self.at_least) / math.log(self.at_most / self.at_least)
        return (inside - self.at_least) / (self.at_most - self.at_least)

    def inside(self, value: float) -> float:
        """Return the nearest value within the bounds."""
        return min(max(value, self.at_least), self.at_most)

    def slope(self, value: float) -> float:
        """Return the derivative of the value by the part."""
        if self.logarithmic:
            return value * math.log(self.at_most / self.at_least)
        return self.at_most - self.at_least

    def as_table(self) -> dict[str, Any]:
        """Return the bounds and the axis as a graph file has them."""
        scale = "logarithmic" if self.logarithmic else "linear"
        return {"at_least": self.at_least, "at_most": self.at_most, "scale": scale}


@dataclasses.dataclass(frozen=True)
class Goal:
    """A quantity and what is wanted of it: limits, hard or soft, or the best that others allow."""

    quantity: Quantity
    at_least: float = -math.inf
    at_most: float = math.inf
    soft: bool = False
    minimise: bool = False
    maximise: bool = False

    @property
    def hard(self) -> bool:
        """True if it has limits that must be kept."""
        return not self.soft and not self.minimise and not self.maximise

    @property
    def wanted(self) -> str:
        """Return the goal in words."""
        if self.minimise or self.maximise:
            return "as low as possible" if self.minimise else "as high as possible"
        unit = f" {self.quantity.unit}" if self.quantity.unit != "1" else ""
        limits = [(self.at_least, "at least"), (self.at_most, "at most")]
        words = " and ".join(f"{word} {limit:g}{unit}" for limit, word in limits if math.isfinite(limit))
        return words + (" (soft)" if self.soft else "")

    @property
    def limits(self) -> tuple[tuple[float, float], ...]:
        """Limits, each with the sign that makes the distance into the allowed side positive."""
        return tuple((s, limit) for s, limit in ((1.0, self.at_least), (-1.0, self.at_most)) if math.isfinite(limit))

    def shortfall(self, value: float) -> float:
        """Return how far a value is beyond the limit it is farthest beyond; without limits how far it is from best."""
        wanted = self.limits or ((-1.0 if self.minimise else 1.0, 0.0),)
        return max(sign * (limit - value) for sign, limit in wanted)

    def as_table(self) -> dict[str, Any]:
        """Return the goal as a graph file has it, with limits in the unit of its quantity."""
        limits = {("at_least" if sign > 0.0 else "at_most"): limit for sign, limit in self.limits}
        flags = {name: True for name in ("soft", "minimise", "maximise") if getattr(self, name)}
        return {**quantity_table(self.quantity), **limits, **flags}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tuning(Placed):
    """A graph with free parameters, goals and the operating points at which all goals hold.

    Parameters are named as in the flat graph; `written` has the names that a person wrote.

    >>> from proofmass import read_tuning
    >>> tuning = read_tuning("library:closed_loop_accelerometer")
    >>> tuning.nominal["pid.integral"], tuning.unit_of("pid.integral")
    (6.0, '1/s')
    """

    graph: Graph  # with the values to start from
    flat: FlatGraph  # the same without subgraphs
    free: Mapping[str, Free]  # bounds by parameter
    goals: Mapping[str, Goal]  # by name
    points: Mapping[str, Mapping[str, float]]  # values of parameters by operating point
    tolerances: Mapping[str, float]  # relative
    at: str  # time at which the graph is linearised, or "settled"
    starts: int  # of the search
    samples: int  # of the bounds, before the search
    seed: int  # of the samples
    written: Mapping[str, str]  # names that a person wrote, by those of the flat graph
    ages: tuple[float, ...] = ()  # at which all goals hold, in seconds; new alone if there are none
    study: Study | None = None  # that has the yields among the goals, and the drift

    @property
    def nominal(self) -> dict[str, float]:
        """The values of the free parameters in the graph."""
        return {name: self.value(name) for name in self.free}

    @cached_property
    def adjustable(self) -> Adjustable:
        """Parameters and values that may vary."""
        return Adjustable(self.flat)

    def value(self, name: str) -> float:
        """Return a parameter or value of the graph."""
        return self.adjustable.nominal(name)

    def unit_of(self, name: str) -> str:
        """Return the unit of a parameter or value."""
        return self.adjustable.unit_of(name)

    def as_toml(self) -> str:
        """Return the text of a graph file with the table `[tune]`, and `[study]` if needed."""
        lines = [write_graph(self.graph) if self.study is None else write_study(self.study, self.graph)]
        for name, table in self.as_tables().items():
            entries = [f"{key_of(key)} = {inline(entry)}" for key, entry in table.items()]
            lines += ["", f"[tune{'.' * bool(name)}{name}]", *entries] if entries else []
        return "\n".join(lines).replace("\n\n\n", "\n\n") + "\n"

    def as_tables(self) -> dict[str, Mapping[str, Any]]:
        """Return the tables of `[tune]` by name, with the settings in one without a name."""
        names = {name: self.written.get(name, name) for name in (*self.free, *self.tolerances)}
        settings: dict[str, Any] = {"at": self.at} if self.at else {}
        settings |= {"ages": [f"{age!r} s" for age in self.ages]} if self.ages else {}
        settings |= {key: getattr(self, key) for key in ("starts", "samples", "seed")}
        tables: dict[str, Mapping[str, Any]] = {
            "free": {names[name]: free.as_table() for name, free in self.free.items()},
            "goals": {name: goal.as_table() for name, goal in self.goals.items()},
            "points": self.points,
            "tolerances": {names[name]: width for name, width in self.tolerances.items()},
        }
        return {"": settings, **tables}

    def aged(self, values: Mapping[str, float], age: float) -> tuple[dict[str, float], dict[str, float]]:
        """Return values as the drift of the study has them at an age, and what each moves by with what it was."""
        assert self.study is not None
        now, slopes = dict(values), dict[str, float]()
        for name in self.study.moved:
            if name in self.study.drift:
                followed = self.adjustable.dependence.followed(now)
                base = now[name] if name in now else followed[name] if name in followed else self.value(name)
                step = _STEP * (abs(base) or 1.0)
                low, now[name], high = (self._drifted(name, base + side * step, age) for side in (-1.0, 0.0, 1.0))
                slopes[name] = (high - low) / (2.0 * step)
        return now, slopes

    def _drifted(self, name: str, base: float, age: float) -> float:
        assert self.study is not None
        law = self.study.drift[name]
        return float(law.aged(base, (0.0, age), 0, 0, 0, normal=lambda *_: 0.0)[-1])

    def aged_cases(self) -> dict[str, tuple[Mapping[str, float], Mapping[str, float], float | None]]:
        """Return the cases at each age, by a name for people; the age is None if there are none."""
        if not self.ages:
            return {name: (*case, None) for name, case in self.cases().items()}
        pairs = itertools.product(self.ages, self.cases().items())
        return {", ".join(filter(None, (name, age_text(age)))): (*case, age) for age, (name, case) in pairs}

    def cases(self) -> dict[str, tuple[Mapping[str, float], Mapping[str, float]]]:
        """Return values and factors of parameters at each operating point and corner, by a name for people."""
        points = self.points or {"": {}}
        signs = list(itertools.product((-1.0, 1.0), repeat=len(self.tolerances)))
        cases: dict[str, tuple[Mapping[str, float], Mapping[str, float]]] = {}
        for point, values in points.items():
            for number, corner in enumerate(signs):
                factors = {n: 1.0 + s * t for s, (n, t) in zip(corner, self.tolerances.items(), strict=True)}
                cornered = f"corner {number + 1}" if self.tolerances else ""
                cases[", ".join(filter(None, (point, cornered)))] = (values, factors)
        return cases
