"""Ranges of what varies in a worst case, and tolerances as they are written."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Refusal, shown
from proofmass.blocks.declaration.units import convert, part_of, short_unit
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.call_numbers import real
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.study_tables import StudyTables

SIGMAS = 3.0  # of a normal distribution that is not truncated
_TRIED = 9  # choices of a list
MIDDLE = 1e-9  # a place in the middle of a list; 0 is the nominal value


@dataclass(frozen=True)
class Range:
    """Coordinate of a worst case, as a parameter, and its values while all others are nominal."""

    name: str  # in the flat graph
    written: str
    unit: str
    nominal: float
    low: float
    high: float
    choices: tuple[float, ...] = ()  # in ascending order; none where all values between the ends are possible

    def at(self, place: float) -> float:
        """Return the value at a place: -1 lowest, 0 nominal, 1 highest."""
        if self.choices and place != 0.0:
            return self.choices[round(0.5 * (place + 1.0) * (len(self.choices) - 1))]
        end = self.high if place > 0.0 else self.low
        return self.nominal + abs(place) * (end - self.nominal)

    def others(self, place: float) -> list[float]:
        """Return the places to try instead: the other end, or up to nine choices."""
        if not self.choices:
            return [-place]
        many = min(len(self.choices), _TRIED)
        every = [2.0 * number / (many - 1) - 1.0 for number in range(many)]
        return [other or MIDDLE for other in every if self.at(other or MIDDLE) != self.at(place)]


@dataclass(frozen=True)
class Tolerance:
    """Tolerance of a parameter: a part of what the graph says, a width in its unit, or two ends."""

    written: str
    unit: str
    part: float = 0.0
    width: float = 0.0
    ends: tuple[float, float] | None = None

    def about(self, base: float, nominal: float, place: float) -> float:
        """Return the value at a place, about what a formula says; between two ends formulas do not matter."""
        if self.ends is not None:
            return nominal + abs(place) * (self.ends[place > 0.0] - nominal)
        return base + place * (self.part * abs(base) + self.width)


_DOCS = {"tolerances": 'write { "torquer.gain" = "5 %" }'}


def read_tolerances(graph: Graph, tolerances: Mapping[str, Any]) -> dict[str, Tolerance]:
    """Return tolerances by names in the flat graph; raises `ModelError` with every problem.

    A tolerance is "5 %" of the value, "0.1 V" in the parameter's unit, or a list of two values,
    lowest and highest.
    """
    read = StudyTables(checked(graph), docs=_DOCS)
    adjustable, known = Adjustable(read.flat), dict[str, Tolerance]()
    for name, (given, unit) in read.parameters("tolerances", tolerances, lambda entry, unit: (entry, unit)).items():
        with read.noting("tolerances", read.written[name]):
            known[name] = _tolerance(read.written[name], given, adjustable.nominal(name), unit)
    if read.problems:
        raise ModelError([graph.placed(problem) for problem in read.problems])
    return known


def _tolerance(name: str, written: object, nominal: float, unit: str) -> Tolerance:
    if isinstance(written, list | tuple) and len(written) == 2:
        try:
            low, high = (convert(end, unit) if isinstance(end, str) else real(end) for end in written)
        except TypeError:
            raise Refusal("must be two numbers", got=shown(written)) from None
        if not (math.isfinite(low) and math.isfinite(high)):
            raise Refusal("must be finite", got=f"{low:g} to {high:g}")
        if not low <= nominal <= high:
            raise Refusal("does not hold the value of the graph", got=f"{low:g} to {high:g}", expected=f"{nominal:g}")
        return Tolerance(name, short_unit(unit), ends=(low, high))
    try:
        part = part_of(written) if isinstance(written, str) else real(written)
    except TypeError:
        raise Refusal("is not a tolerance", 'write "5 %", or a width with a unit', got=shown(written)) from None
    if part is None:
        width = convert(str(written), unit)
        tolerance = Tolerance(name, short_unit(unit), width=width)
    else:
        width = abs(nominal) * part
        tolerance = Tolerance(name, short_unit(unit), part=part)
    if not (math.isfinite(width) and width > 0.0):
        hint = "give its width in its unit" if nominal == 0.0 else 'write "5 %"'
        raise Refusal("leaves no room", hint, got=shown(written))
    return tolerance
