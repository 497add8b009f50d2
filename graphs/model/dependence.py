"""Dependence on the values of a graph and its subgraphs: all formulas, in an order in which each
can be computed.

Numbers are in coherent SI units for values, and in their own units for parameters; all may be
arrays.
"""

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from graphlib import TopologicalSorter
from types import MappingProxyType
from typing import Any

from proofmass.graphs.formulas.formula import Formula, in_unit
from proofmass.graphs.formulas.tree import evaluated, plainly, slopes
from proofmass.graphs.model.flatten import parts, values_of
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.model.targets import CLOCK_OFFSET, DURATION, RATE, is_of_measure, target_at


@dataclass(frozen=True)
class FormulaStep:
    """A formula and its target, by paths of the flat graph."""

    target: str
    formula: Formula
    names: Mapping[str, str]  # values in the formula, by their paths
    unit: str  # of the target
    fixed: bool = False  # sets a rate, a clock offset, the duration or a measure, no run varies it

    def number(self, numbers: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly) -> Any:
        """Return the number of the formula, from the values by their paths."""
        own = {name: numbers[path] for name, path in self.names.items()}
        return in_unit(evaluated(self.formula.tree, own, apply), self.unit)

    def slopes(self, numbers: Mapping[str, float]) -> dict[str, float]:
        """Return its exact derivatives by values, by their paths."""
        own = {name: numbers[path] for name, path in self.names.items()}
        found = slopes(self.formula.tree, own)
        return {self.names[name]: in_unit(slope, self.unit) for name, slope in found.items()}


class Dependence:
    """Values and formulas of a graph with all that lies inside it."""

    def __init__(self, root: Graph) -> None:
        self.root = root
        self.numbers = {name: value.number for name, value in values_of(root).items()}
        self.units = {name: value.coherent_unit for name, value in values_of(root).items()}

    @cached_property
    def steps(self) -> tuple[FormulaStep, ...]:
        """The formulas in order; also those of rates and of the duration, which no run can vary."""
        steps = {step.target: step for path, part in parts(self.root) for step in self._steps(path, part)}
        needs = {step.target: {path for path in step.names.values() if path in steps} for step in steps.values()}
        return tuple(steps[target] for target in TopologicalSorter(needs).static_order())

    @cached_property
    def places(self) -> Mapping[str, int]:
        """The place of each target in the order of the formulas."""
        return {step.target: place for place, step in enumerate(self.steps)}

    def followers(self, names: Collection[str]) -> list[FormulaStep]:
        """Return the formulas that move with one of some values, in order."""
        moved, followers = set(names), list[FormulaStep]()
        for step in self.steps:
            if not moved.isdisjoint(step.names.values()):
                moved.add(step.target)
                followers.append(step)
        return followers

    def followed(self, numbers: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly) -> dict[str, Any]:
        """Return the values and parameters that follow from some numbers; without those given."""
        all_numbers: dict[str, Any] = {**self.numbers, **numbers}
        moved, follow = set(numbers), dict[str, Any]()
        for step in self.steps:
            if step.target not in numbers and not moved.isdisjoint(step.names.values()):
                follow[step.target] = all_numbers[step.target] = step.number(all_numbers, apply)
                moved.add(step.target)
        return follow

    def slopes(self, value: str, numbers: Mapping[str, float] = MappingProxyType({})) -> dict[str, float]:
        """Return the exact derivatives by one value of all parameters that follow from it, at some numbers."""
        slopes, at = {value: 1.0}, {**self.numbers, **numbers, **self.followed(numbers)}
        for step in self.followers([value]):
            if step.target not in numbers:
                by_name = step.slopes(at)
                slopes[step.target] = sum(slope * slopes[name] for name, slope in by_name.items() if name in slopes)
        return {target: slope for target, slope in slopes.items() if target not in self.numbers}

    def _steps(self, path: str, part: Graph) -> Iterator[FormulaStep]:
        paths = {name: path + name for name in part.values}
        for name, value in part.values.items():
            if value.formula is not None:
                yield self._step(path + name, value.formula, paths, value.coherent_unit)
        for target, formula in part.formulas.items():
            of_measure = is_of_measure(part, target)
            if of_measure and path:
                continue  # measures of a part are not those of the whole
            whole, of_value = path + target, path + target in self.numbers
            unit = self.units[whole] if of_value else _unit(part, target)
            yield self._step(whole, formula, paths, unit, fixed=of_measure or _is_clock(target))

    def _step(
        self, target: str, formula: Formula, own: Mapping[str, str], unit: str, *, fixed: bool = False
    ) -> FormulaStep:
        names = {name: own[name] for name in sorted(formula.names) if name in own}
        return FormulaStep(target, formula, names, unit, fixed)


def _is_clock(target: str) -> bool:
    return split(target)[1] in (RATE, CLOCK_OFFSET) or target == DURATION


def _unit(part: Graph, target: str) -> str:
    if is_of_measure(part, target):
        return "1"  # in coherent units
    if _is_clock(target):
        return "Hz" if split(target)[1] == RATE else "s"
    return target_at(part, target).unit
