"""Parameters and named values that may vary: their nominal numbers, and all that follows from other numbers."""

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from proofmass.blocks.declaration.instance import unit_of
from proofmass.blocks.declaration.units import short_unit
from proofmass.graphs.formulas.tree import plainly
from proofmass.graphs.model.dependence import Dependence
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import split


class Adjustable:
    """The numbers of a graph by their names: `block.parameter`, or a value by its path."""

    def __init__(self, flat: FlatGraph, dependence: Dependence | None = None) -> None:
        self.flat, self.dependence = flat, dependence or Dependence(flat.root)

    def is_value(self, name: str) -> bool:
        """Return whether a name is that of a value."""
        return name in self.dependence.numbers

    def nominal(self, name: str) -> float:
        """Number of a parameter or value in the graph."""
        if self.is_value(name):
            return self.dependence.numbers[name]
        block, parameter = split(name)
        return float(getattr(self.flat.blocks[block], parameter))

    def unit_of(self, name: str) -> str:
        """Unit of a parameter or value."""
        if name in self.dependence.units:
            return self.dependence.units[name]
        block, parameter = split(name)
        return short_unit(unit_of(self.flat.blocks[block], type(self.flat.blocks[block]).parameters[parameter]))

    def takes(self, name: str, number: float) -> bool:
        """Return whether a parameter may have a number; values may have any."""
        if self.is_value(name):
            return True
        block, parameter = split(name)
        return type(self.flat.blocks[block]).parameters[parameter].inside(number)

    def settings(self, values: Mapping[str, Any], apply: Callable[[str, list[Any]], Any] = plainly) -> dict[str, Any]:
        """Parameters that follow from numbers of parameters and values; these may be arrays if `apply` takes them."""
        every = {**values, **self.dependence.followed(values, apply)}
        return {name: value for name, value in every.items() if not self.is_value(name)}

    def following(self, names: Iterable[str]) -> frozenset[str]:
        """Return the parameters that follow from some parameters and values."""
        return frozenset(self.settings({name: self.nominal(name) for name in names}))

    def moved_by(self, name: str, values: Mapping[str, float]) -> dict[str, float]:
        """Return the exact derivatives by one number of all parameters that move with it, at some numbers."""
        return self.dependence.slopes(name, values) if self.is_value(name) else {name: 1.0}
