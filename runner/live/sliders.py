"""The parameters a page can change: their ranges, and what the command line is told about them."""

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

from proofmass.blocks.declaration.declare import Block
from proofmass.blocks.declaration.instance import unit_of, written
from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import pretty
from proofmass.blocks.declaration.spelled_units import usual_unit
from proofmass.blocks.declaration.unit_expressions import unit
from proofmass.blocks.declaration.units import short_unit, split_quantity
from proofmass.graphs.drawing.picture import box_of
from proofmass.graphs.model.graph import Endpoint, Graph
from proofmass.graphs.model.measures import MEASURES
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan as make_plan
from proofmass.runner.program.tick_loop import settled_before

LOGARITHMIC = 1.5  # decades that a range spans from where a slider is logarithmic


@dataclass(frozen=True)
class Slider:
    """A number of a block, with the range its slider has and the bounds that its field keeps."""

    block: str
    parameter: str
    unit: str
    doc: str
    value: float
    low: float
    high: float
    logarithmic: bool
    above: float | None = None
    at_least: float | None = None
    below: float | None = None
    at_most: float | None = None
    named: bool = False  # a named value, in coherent units; the block is the subgraph it belongs to
    written: str = ""  # as in the file, "20 ug"; empty for a number or a default
    drawn: str = ""  # as the diagram has it

    @property
    def shown_in(self) -> str:
        """The unit of its field: that of the file, or the one that suits a number."""
        _, own = split_quantity(self.written) if self.written else (0, "")
        return own or ("1" if self.unit == "1" else usual_unit(short_unit(self.unit), abs(self.value or self.high)))

    @property
    def factor(self) -> Fraction:
        """The unit of its field in that of its value, exactly."""
        return unit(self.shown_in).factor / unit(self.unit).factor

    @property
    def node(self) -> Endpoint:
        """Block and parameter."""
        return self.block, self.parameter

    def as_data(self) -> dict[str, Any]:
        """Plain data, for the page."""
        factor = [str(part) for part in self.factor.as_integer_ratio()]
        return asdict(self) | {"shown": self.shown_in, "printed": pretty(self.shown_in), "factor": factor}


@dataclass(frozen=True)
class FixedParameter:
    """A parameter that a page shows and cannot change: it fixes a size, start, format or choice."""

    block: str
    parameter: str
    unit: str
    doc: str
    value: str
    named: bool = False
    choices: tuple[str, ...] = ()  # that a served page offers: the process takes them
    whole: bool = False  # an integer, which the process takes

    def as_data(self) -> dict[str, Any]:
        """Plain data, for the page."""
        return asdict(self)


def sliders(graph: Graph, plan: Plan) -> tuple[Slider, ...]:
    """The numbers of a graph that constants follow from in the loop itself: another value needs no compilation."""
    nodes = (node for node in _parameters(plan) if _in_the_loop(plan, node))
    moving = (_slider(plan, name, p) for name, p in nodes)
    return tuple(slider for slider in moving if not _turns_the_method(graph, plan, slider))


def fixed_parameters(plan: Plan, moving: tuple[Slider, ...]) -> tuple[FixedParameter, ...]:
    """The other parameters that no wire drives."""
    nodes = {slider.node for slider in moving}
    return tuple(_fixed(plan.blocks[name], name, p) for name, p in _parameters(plan) if (name, p) not in nodes)


def _parameters(plan: Plan) -> Iterator[Endpoint]:
    for name, block in plan.blocks.items():
        if not name.startswith(f"{MEASURES}."):
            nodes = ((name, parameter) for parameter in type(block).parameters)
            yield from (node for node in nodes if node not in plan.schedule.drivers)


def _in_the_loop(plan: Plan, node: Endpoint) -> bool:
    name, parameter = node
    return type(plan.blocks[name]).taken_in_the_loop(parameter) and name not in settled_before(plan, [node])


def _turns_the_method(graph: Graph, plan: Plan, slider: Slider) -> bool:
    """Return whether a group of continuous blocks is stepped as it is only because this parameter is zero."""
    if slider.value != 0.0 or not any(slider.block in solver.group.members for solver in plan.solvers):
        return False
    try:
        other = make_plan(graph, free=[f"{slider.block}.{slider.parameter}"])
    except ModelError:
        return True
    return other.solvers != plan.solvers


def _slider(plan: Plan, name: str, parameter: str) -> Slider:
    block = plan.blocks[name]
    declared, value = type(block).parameters[parameter], float(getattr(block, parameter))
    lowest = declared.at_least if declared.above is None else declared.above
    highest = declared.at_most if declared.below is None else declared.below
    ends = range_of(value, lowest, highest, float(declared.default))
    limits = (declared.above, declared.at_least, declared.below, declared.at_most)
    own, text = unit_of(block, declared), written(block, parameter)
    drawn = box_of(plan.graph, name, block).shown(parameter)
    return Slider(name, parameter, own, declared.doc, value, *ends, *limits, written=text, drawn=drawn)


def range_of(value: float, lowest: float | None, highest: float | None, usual: float) -> tuple[float, float, bool]:
    """Return the ends of the range of a slider, and whether it is logarithmic."""
    low, high = _ends(value, lowest, highest, usual)
    return low, high, low > 0.0 and math.log10(high / low) >= LOGARITHMIC


def _ends(value: float, lowest: float | None, highest: float | None, usual: float) -> tuple[float, float]:
    """Return a decade either side of a positive value, twice any other; cut where it is bounded on both sides."""
    if lowest is not None and highest is not None:
        low, high = float(lowest), float(highest)
        return (low, high) if value - low > (high - low) / 100.0 else (low, min(high, max(10.0 * value, low + 1e-300)))
    size = abs(value) or abs(usual) or 1.0
    low, high = (value / 10.0, value * 10.0) if value > 0.0 else (value - size, value + size)
    low = low if lowest is None else max(low, float(lowest))
    return low, high if highest is None else min(high, float(highest))


def _fixed(block: Block, name: str, parameter: str) -> FixedParameter:
    declared, value = type(block).parameters[parameter], getattr(block, parameter)
    unit = unit_of(block, declared) if declared.kind in (float, int, tuple) else ""
    text = str(value).lower() if isinstance(value, bool) else str(value)
    choices = ("false", "true") if declared.kind is bool else tuple(map(str, declared.choices or ()))
    return FixedParameter(name, parameter, unit, declared.doc, text, choices=choices, whole=declared.kind is int)
