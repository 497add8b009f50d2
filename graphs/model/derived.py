"""Measures of measures: `scale_factor = "= (plus - minus) / 2"`, with units as in all formulas."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.problem import Problem, Refusal, problems_of_table, shown
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.graphs.formulas.formula import Formula
from proofmass.graphs.formulas.operations import KNOWN, Dimension
from proofmass.graphs.formulas.tree import dimension_of, evaluated, plainly
from proofmass.graphs.formulas.turning import counted_unit, turning_of, turning_of_quantity
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.measures import MEASURES, bad_display_unit
from proofmass.graphs.model.names import Missing, find_output
from proofmass.graphs.model.statistics import STATISTICS
from proofmass.graphs.model.values import circles_and_order

_problem = problems_of_table(MEASURES)


@dataclass(frozen=True)
class Derived:
    """A measure that follows from others: its unit, and factors to coherent units."""

    name: str
    formula: Formula
    unit: str
    factors: Mapping[str, float]

    @property
    def shown_in(self) -> str:
        """The unit of tables, such as "deg/h", where the graph says one."""
        return self.formula.unit

    def value(self, measures: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly) -> Any:
        """Return its value from those of the others: numbers, or arrays if `apply` takes them.

        It is NaN where one of them or the value itself is infinite or NaN.
        """
        numbers = {name: measures[name] * factor for name, factor in self.factors.items()}
        value = evaluated(self.formula.tree, numbers, apply)
        for number in (value, *numbers.values()):
            value = apply(KNOWN, [value, number])
        return value


def measure_units(flat: FlatGraph) -> dict[str, str]:
    """Return the unit of each measure that is right, those of formulas too."""
    units = _units(flat)
    return units | {derived.name: derived.unit for derived in _derived(flat, units) if isinstance(derived, Derived)}


def derived_measures(flat: FlatGraph) -> tuple[Derived, ...]:
    """Return the measures given by formulas of a correct graph, each after those that it needs."""
    return tuple(derived for derived in _derived(flat, _units(flat)) if isinstance(derived, Derived))


def bad_derived(flat: FlatGraph) -> Iterator[Problem]:
    """Yield the problems of measures given by formulas."""
    return (derived for derived in _derived(flat, _units(flat)) if isinstance(derived, Problem))


def _units(flat: FlatGraph) -> dict[str, str]:
    units = {}
    for name, measure in flat.measures.items():
        found = find_output(flat, measure.signal)
        if not isinstance(found, Missing):
            units[name] = STATISTICS[measure.statistic].unit_for(unit_of(*found))
    return units


def _derived(flat: FlatGraph, units: Mapping[str, str]) -> Iterator[Derived | Problem]:
    formulas = flat.root.derived
    dimensions = {name: unit(text).exponents for name, text in units.items()}
    factors = {name: float(unit(text).factor) for name, text in units.items()}
    turnings = {name: turning_of_quantity(math.nan, dimensions[name], text) for name, text in units.items()}
    unknown = (flat.measures.keys() | formulas.keys()) - dimensions.keys()
    circles, order = circles_and_order(formulas)
    for chain in circles:
        message = f"the measure depends on itself: {' -> '.join(chain)}"
        yield _problem(message, chain[0], got=shown(formulas[chain[0]].text), hint="measure a signal in one of them")
    for name in order:
        formula = formulas[name]
        if formula.names & unknown:
            continue  # the problem is reported at the measure
        try:
            dimension = _dimension(flat, formula, dimensions)
            turnings[name] = turning_of(formula.tree, turnings.__getitem__)
        except Refusal as error:
            yield _problem(str(error), name, got=shown(formula.text), hint=error.hint)
            continue
        own = counted_unit(turnings[name], dimension)
        yield from bad_display_unit(formula.unit, own, f"{MEASURES}.{name}.unit", (MEASURES, name, "unit"))
        yield Derived(name, formula, own, {n: factors[n] for n in formula.names if n in factors})
        unknown = unknown - {name}
        dimensions[name], factors[name] = dimension, 1.0


def _dimension(flat: FlatGraph, formula: Formula, dimensions: Mapping[str, Dimension]) -> Dimension:
    values = formula.names & flat.root.values.keys() - dimensions.keys()
    if values:
        name = min(values)
        hint = f"measure a signal that has it, or write {name} as a number"
        raise Refusal(f"{name} is a value: a measure follows from measures alone", hint)
    return dimension_of(formula.tree, dimensions)
