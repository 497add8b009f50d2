"""Checks of requirements against their graph: quantities must exist, limits must have their units."""

import math
from collections.abc import Iterator
from typing import NamedTuple

from proofmass.blocks.declaration.problem import Problem, Refusal, did_you_mean, shown
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.loops import MARGIN_MEASURES, SETTLED, VERDICTS, read_requirement
from proofmass.graphs.model.rates import read_duration
from proofmass.graphs.model.requirements import TABLE, YIELD, Requirement

_VERDICT = "stable"


class Asked(NamedTuple):
    """Limits of a requirement in the unit of its quantity, infinite if it has none."""

    unit: str
    at_least: float
    at_most: float


def asked(flat: FlatGraph, requirement: Requirement) -> Asked:
    """Return the limits of a requirement in the unit of its quantity; raises `Refusal`."""
    unit = _unit(flat, requirement.quantity)
    limits = [
        missing if given is None else _limit(requirement, key, given, unit)
        for key, given, missing in (
            ("at_least", requirement.at_least, -math.inf),
            ("at_most", requirement.at_most, math.inf),
        )
    ]
    if limits[0] > limits[1]:
        raise Refusal("nothing can meet it", key="at_least", got=shown(requirement.at_least), expected="below at_most")
    if requirement.at and not is_margin(flat, requirement.quantity):
        raise Refusal("is for margins, which have an operating point", key="at", got=shown(requirement.at))
    if requirement.at not in ("", SETTLED):
        try:
            read_duration(requirement.at)
        except Refusal as error:
            raise error.under("at", requirement.at) from None
    return Asked(unit, *limits)


def bad_requirements(flat: FlatGraph) -> Iterator[Problem]:
    """Yield requirements of missing quantities, and limits that do not suit their quantity."""
    broken = (flat.measures.keys() | flat.root.derived.keys()) - measure_units(flat).keys()
    for name, requirement in flat.root.requirements.items():
        if requirement.quantity in broken:
            continue  # problems of a measure are reported at the measure
        try:
            asked(flat, requirement)
        except Refusal as error:
            path = (TABLE, name, *([error.key] if error.key else ["quantity"]))
            got = error.got or shown(requirement.quantity)
            key, expected = ".".join(path), error.expected
            yield Problem(message=str(error), key=key, path=path, got=got, expected=expected, hint=error.hint)


def is_margin(flat: FlatGraph, quantity: str) -> bool:
    """Return whether a quantity is a margin, `main.phase_margin`."""
    loop, margin = split(quantity)
    return loop in flat.loops and margin in MARGIN_MEASURES


def is_yield(flat: FlatGraph, quantity: str) -> bool:
    """Return whether a quantity is the part of sensors that keep the limits of the study, or one of them."""
    head = quantity.partition(".")[0]
    return head == YIELD and quantity not in flat.measures and quantity not in flat.root.derived


def _unit(flat: FlatGraph, quantity: str) -> str:
    units = measure_units(flat)
    if quantity in units:
        return units[quantity]
    if is_margin(flat, quantity):
        return MARGIN_MEASURES[split(quantity)[1]]
    if is_yield(flat, quantity):
        return "1"
    margins = [f"{loop}.{margin}" for loop in flat.loops for margin in MARGIN_MEASURES]
    names = [*flat.measures, *flat.root.derived, *margins, YIELD]
    raise Refusal(f"there is no quantity {shown(quantity)[1:-1]}", did_you_mean(quantity, names, "the quantities"))


def _limit(requirement: Requirement, key: str, written: float | str, unit: str) -> float:
    try:
        if split(requirement.quantity)[1] == _VERDICT and isinstance(written, str):
            return _verdict(written)
        if unit == "dB":
            return read_requirement(written, unit)
        number = convert(written, unit) if isinstance(written, str) else float(written)
    except Refusal as error:
        raise error.under(key, written, f"a quantity in {unit}") from None
    except OverflowError:
        raise Refusal("is too large for a number", key=key, got=shown(written)) from None
    if math.isnan(number):
        raise Refusal("must be a number", key=key, got=shown(written))
    return number


def _verdict(given: str) -> float:
    if given not in VERDICTS:
        raise Refusal("there is no such verdict", f"the verdicts: {', '.join(VERDICTS)}")
    return VERDICTS[given]
