"""Unknowns of a fit: parameters of blocks, a constant offset and a delay of each output."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from proofmass.blocks.declaration.problem import ModelError, Refusal, shown
from proofmass.graphs.checks.check import checked
from proofmass.graphs.model.adjustable import Adjustable
from proofmass.graphs.model.graph import Graph, split
from proofmass.graphs.studies.study_tables import StudyTables
from proofmass.graphs.studies.table_entries import checked_table, read_quantity

OFFSET, DELAY = "offset of", "delay of"  # before the name of an output
UNKNOWN_KEYS = {
    "at_least": "Lower bound.",
    "at_most": "Upper bound.",
    "expected": "What is known of it beforehand: the most likely value.",
    "uncertainty": "Standard deviation of the value known beforehand.",
}
_SPREAD = 2.0  # factor up and down from which starts are taken if there are no bounds


@dataclass(frozen=True)
class Unknown:
    """One number to find: its name, where it starts, its unit, and prior knowledge."""

    name: str  # in the flat graph, or OFFSET or DELAY and an output
    written: str
    unit: str
    start: float
    at_least: float = -math.inf
    at_most: float = math.inf
    expected: float = math.nan
    uncertainty: float = math.inf

    @property
    def scale(self) -> float:
        """Its size, by which it is divided; 1 for what has none."""
        width = self.at_most - self.at_least
        return abs(self.start) or (width if math.isfinite(width) else 0.0) or 1.0

    @property
    def sizeless(self) -> bool:
        """True if it begins at zero within no bounds, which tell no size."""
        return self.start == 0.0 and not math.isfinite(self.at_most - self.at_least)

    @property
    def of_block(self) -> bool:
        """True if it is a parameter of a block."""
        return not self.name.startswith((OFFSET, DELAY))

    def sampled(self, part: float, size: float) -> float:
        """Return another start, for a number between 0 and 1; `size` is that of what begins at zero."""
        low, high = self.at_least, self.at_most
        if self.name.startswith(OFFSET):
            return self.start  # an output moves with it on a straight line: no search ends elsewhere
        if self.sizeless:
            low, high = max(low, -_SPREAD * size), min(high, _SPREAD * size)
        elif not math.isfinite(low) or not math.isfinite(high):
            low, high = max(low, self.start / _SPREAD), min(high, self.start * _SPREAD)
            if self.start < 0.0:
                low, high = max(self.at_least, self.start * _SPREAD), min(self.at_most, self.start / _SPREAD)
        if low > 0.0:
            return float(low * (high / low) ** part)
        return low + part * (high - low)


_DOCS = {"free": 'name parameters: ["sensor.stiffness", "sensor.damping"], or with bounds in a table'}


def parameters_of(graph: Graph, free: Mapping[str, object] | Sequence[str]) -> list[Unknown]:
    """Return the free parameters of blocks; raises `ModelError` with every problem."""
    table = free if isinstance(free, Mapping) else {name: {} for name in free}
    read = StudyTables(checked(graph), docs=_DOCS)
    entries = read.parameters("free", table, _read_entry)
    unknowns = []
    adjustable = Adjustable(read.flat)
    for name, entry in entries.items():
        value, unit = adjustable.nominal(name), adjustable.unit_of(name)
        bounds, limits = list[float](), list[float]()
        if not adjustable.is_value(name):
            block, parameter = split(name)
            declared = type(read.flat.blocks[block]).parameters[parameter]
            bounds = [bound for bound in (declared.above, declared.at_least) if bound is not None]
            limits = [bound for bound in (declared.below, declared.at_most) if bound is not None]
        low = max([entry.get("at_least", -math.inf), *bounds])
        high = min([entry.get("at_most", math.inf), *limits])
        if not low <= value <= high:
            message, expected = "its value in the graph is out of its bounds", f"{low:g} to {high:g}"
            read.refuse(Refusal(message, got=f"{value:g}", expected=expected), "free", read.written[name])
        beforehand = {key: entry[key] for key in ("expected", "uncertainty") if key in entry}
        unknowns.append(Unknown(name, read.written[name], unit, value, low, high, **beforehand))
    if read.problems:
        raise ModelError(read.problems)
    return unknowns


def _read_entry(entry: object, unit: str) -> dict[str, float]:
    table = checked_table(entry, UNKNOWN_KEYS, 'write { at_least = "100 N/m", at_most = "200 N/m" }')
    quantities = {key: read_quantity(table, key, unit) for key in table}
    if quantities.get("at_least", -math.inf) >= quantities.get("at_most", math.inf):
        raise Refusal("leaves nothing free", got=shown(dict(table)), expected="at_least below at_most")
    if ("expected" in quantities) != ("uncertainty" in quantities) or quantities.get("uncertainty", 1.0) <= 0.0:
        expected = "a value and its standard deviation above zero"
        raise Refusal("expected and uncertainty go together", got=shown(dict(table)), expected=expected)
    return quantities
