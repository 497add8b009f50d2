"""Ranges of parameters: tolerances that are written down, or the spread of a study."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Refusal, shown
from proofmass.blocks.declaration.units import UnitError, convert, short_unit
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.studies.distributions import Spread
from proofmass.graphs.studies.study import Study
from proofmass.graphs.studies.study_tables import StudyTables

SIGMAS = 3.0  # of a normal distribution that is not truncated
MOST = 40  # parameters


@dataclass(frozen=True)
class Range:
    """A parameter and the values that it may have."""

    name: str  # in the flat graph
    written: str
    unit: str
    nominal: float
    low: float
    high: float

    def at(self, place: float) -> float:
        """Return the value at a place: -1 lowest, 0 nominal, 1 highest."""
        end = self.high if place > 0.0 else self.low
        return self.nominal + abs(place) * (end - self.nominal)

    def slope(self, place: float) -> float:
        """Return the derivative of the value by the place."""
        return self.high - self.nominal if place > 0.0 else self.nominal - self.low


def ranges_of(source: Graph | Study, tolerances: Mapping[str, Any]) -> list[Range]:
    """Return the ranges of tolerances, or those of a study's spread; raises `ModelError` with every problem.

    A tolerance is "5 %" of the value, "0.1 V" in the parameter's unit, or a list of two values, lowest and highest.
    """
    graph = source.graph if isinstance(source, Study) else source
    read = _Tables(checked(graph), "")
    adjustable = Adjustable(read.flat)
    ranges: dict[str, Range] = {}
    if isinstance(source, Study):
        for name, spread in source.spread.items():
            nominal = source.nominal(name)
            low, high = _ends(spread, nominal)
            ranges[name] = Range(name, source.name_of(name), source.unit_of(name), nominal, low, high)
    for name, entry in read.parameters("tolerances", tolerances, lambda entry, unit: (entry, unit)).items():
        nominal, (given, unit) = adjustable.nominal(name), entry
        try:
            low, high = _tolerance(given, nominal, unit)
        except Refusal as error:
            read.refuse(error, "tolerances", read.written[name])
            continue
        ranges[name] = Range(name, read.written[name], short_unit(unit), nominal, low, high)
    for wanted in ranges.values():
        if not (adjustable.takes(wanted.name, wanted.low) and adjustable.takes(wanted.name, wanted.high)):
            got = f"{wanted.low:g} to {wanted.high:g}"
            read.refuse(Refusal("the block does not take all of its range", got=got), "tolerances", wanted.written)
    if not ranges and not read.problems:
        hint = 'say --tolerance "torquer.gain=5 %", or name a study with [spread]'
        read.refuse(Refusal("nothing varies", hint), "tolerances")
    if len(ranges) > MOST:
        read.refuse(Refusal("too many parameters vary", got=str(len(ranges)), expected=f"at most {MOST}"), "tolerances")
    if read.problems:
        raise ModelError([graph.placed(problem) for problem in read.problems])
    return [ranges[name] for name in sorted(ranges) if ranges[name].high > ranges[name].low]


class _Tables(StudyTables):
    docs: Mapping[str, str] = MappingProxyType({"tolerances": 'write { "torquer.gain" = "5 %" }'})

    def refuse(self, error: Refusal, *path: str) -> None:
        """Note a refusal under a path of keys."""
        self._refuse(error, *path)


def _tolerance(written: object, nominal: float, unit: str) -> tuple[float, float]:
    if isinstance(written, list | tuple) and len(written) == 2:
        low, high = (convert(end, unit) if isinstance(end, str) else float(end) for end in written)
        if not low <= nominal <= high:
            raise Refusal("does not hold the value of the graph", got=f"{low:g} to {high:g}", expected=f"{nominal:g}")
        return low, high
    try:
        part = convert(written, "1") if isinstance(written, str) else float(written)  # type: ignore[arg-type]
        width = abs(nominal) * part
    except UnitError:
        width = convert(str(written), unit)
    except (TypeError, ValueError):
        raise Refusal("is no tolerance", 'write "5 %", or a width with a unit', got=shown(written)) from None
    if not (math.isfinite(width) and width > 0.0):
        hint = "give its width in its unit" if nominal == 0.0 else 'write "5 %"'
        raise Refusal("leaves no room", hint, got=shown(written))
    return nominal - width, nominal + width


def _ends(spread: Spread, nominal: float) -> tuple[float, float]:
    """Return the lowest and highest value of a distribution; of a normal one those at three standard deviations."""
    if spread.shape == "values":
        return min(*spread.values, nominal), max(*spread.values, nominal)
    if spread.shape in ("normal", "lognormal"):
        sigmas = min(spread.truncated, SIGMAS)
        return spread.of_normal(nominal, -sigmas), spread.of_normal(nominal, sigmas)
    width = spread.width * (abs(nominal) if spread.relative else 1.0)
    return nominal - width, nominal + width
