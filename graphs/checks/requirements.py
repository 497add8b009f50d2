"""Checks of requirements by their graph: quantities must exist, limits must have their units."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from proofmass.blocks.declaration.parameter import Parameter
from proofmass.blocks.declaration.problem import Problem, Refusal, did_you_mean, shown, under
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.derived import measure_units
from proofmass.graphs.model.flatten import FlatGraph, inside
from proofmass.graphs.model.graph import split
from proofmass.graphs.model.loops import AUTO, MARGIN_MEASURES, SETTLED, VERDICTS, read_moment, read_requirement
from proofmass.graphs.model.names import Missing, find_any, is_value
from proofmass.graphs.model.quantities import (
    LoopFigure,
    MeasureOf,
    Noise,
    Quantity,
    ResponseFigure,
    TransferPart,
    YieldOf,
    checked_quantity,
)
from proofmass.graphs.model.rates import read_duration
from proofmass.graphs.model.requirements import SPREAD, TABLE, YIELD, Requirement

PROVABLE = {  # what may be proved of a loop
    name: name.replace("_", " ") for name in ("gain_margin", "phase_margin", "disk_margin", "delay_margin")
}
_VERDICT = "stable"
_MOST_DISK = 2.0


class Asked(NamedTuple):
    """Limits of a requirement in the unit of its quantity, infinite if it has none."""

    unit: str
    at_least: float
    at_most: float


def asked(flat: FlatGraph, requirement: Requirement) -> Asked:
    """Return the limits of a requirement in the unit of its quantity; raises `Refusal`."""
    quantity = quantity_of(flat, requirement)
    low = _limit(quantity, "at_least", requirement.at_least, -math.inf)
    high = _limit(quantity, "at_most", requirement.at_most, math.inf)
    if low > high:
        raise Refusal("nothing can meet it", key="at_least", got=shown(requirement.at_least), expected="below at_most")
    if requirement.at and isinstance(quantity, MeasureOf | YieldOf):
        raise Refusal("is for quantities of the linearised graph", key="at", got=shown(requirement.at))
    if requirement.tolerances and not requirement.proved and isinstance(quantity, StabilityVerdict):
        got, hint = shown(requirement.tolerances), "require a margin, or that it is proved = true"
        raise Refusal("a verdict has no worst value", hint, key="tolerances", got=got)
    if requirement.tolerances == SPREAD and isinstance(quantity, YieldOf):
        got, hint = shown(SPREAD), 'write tolerances of other parameters, { "torquer.gain" = "5 %" }'
        raise Refusal("the spread is in the yield already", hint, key="tolerances", got=got)
    with under("at", requirement.at):
        read_moment(requirement.at)
    if requirement.proved:
        _provable(requirement, quantity)
        if isinstance(quantity, LoopFigure):
            with under("at_least", requirement.at_least):
                refuse_limit(PROVABLE[quantity.figure], low)
    return Asked(quantity.unit, low, high)


def _provable(requirement: Requirement, quantity: "Quantity | StabilityVerdict") -> None:
    """Raise `Refusal` for what `proofmass prove` does not claim."""
    figure = quantity.figure if isinstance(quantity, LoopFigure) else ""
    noise = isinstance(quantity, Noise) and not quantity.input and quantity.band is None
    upper = noise or (isinstance(quantity, ResponseFigure) and quantity.figure == "peak")
    of_output = upper or (isinstance(quantity, TransferPart))
    if not isinstance(quantity, StabilityVerdict) and figure not in PROVABLE and not of_output:
        of_outputs = "a scale_factor or bias, the peak of a response, or noise without input and band"
        expected = f"{', '.join(PROVABLE)} or {_VERDICT} of a loop, {of_outputs}"
        raise Refusal("has no proof", "leave proved out: then the worst case is searched", expected=expected)
    if not requirement.tolerances:
        hint = 'name what varies: tolerances = { "torquer.gain" = "5 %" }'
        raise Refusal("there is nothing to be proved over", hint, key="proved", got="true")
    if not of_output and (requirement.at_least is None or requirement.at_most is not None):
        raise Refusal("must be at_least alone", key="proved", got="at_most")
    if upper and (requirement.at_most is None or requirement.at_least is not None):
        raise Refusal("must be at_most alone", key="proved", got="at_least")
    if requirement.at not in ("", AUTO, SETTLED) and read_duration(requirement.at) > 0:
        raise Refusal(f"must be the start or {SETTLED}", "leave it out", key="at", got=shown(requirement.at))


def refuse_limit(margin: str, limit: float) -> None:
    """Raise `Refusal` for a limit at which a proof of a margin or rate says nothing."""
    if not 0.0 < limit < math.inf and margin in ("disk margin", "delay margin", "decay rate"):
        raise Refusal("must be above zero")
    if margin == "disk margin" and limit >= _MOST_DISK:
        raise Refusal("must be below 2", "such a disk is a half plane")


def bad_requirements(flat: FlatGraph) -> Iterator[Problem]:
    """Yield requirements of missing quantities, and limits that do not suit their quantity."""
    broken = (flat.measures.keys() | flat.root.derived.keys()) - measure_units(flat).keys()
    for name, requirement in flat.root.requirements.items():
        if isinstance(requirement.quantity, str) and requirement.quantity in broken:
            continue  # problems of a measure are reported at the measure
        try:
            asked(flat, requirement)
        except Refusal as error:
            path = (TABLE, name, *(error.key.split(".") if error.key else ["quantity"]))
            got = error.got or shown(requirement.quantity)
            yield Problem(message=str(error), got=got, expected=error.expected, hint=error.hint, path=path)
        if not isinstance(requirement.tolerances, str):
            for parameter in requirement.tolerances:
                yield from _no_parameter(flat, str(parameter), (TABLE, name, "tolerances", str(parameter)))


def _no_parameter(flat: FlatGraph, name: str, path: tuple[str, ...]) -> Iterator[Problem]:
    """Yield why a tolerance has no parameter or value to be that of."""
    target = inside(flat.root, flat.root.exports.get(name, name))
    if is_value(flat.root, target):
        return
    known = find_any(flat, target)
    if isinstance(known, Missing):
        yield Problem(message=known.message, key=".".join(path[:-1]), path=path, got=shown(name), hint=known.hint)
    elif not isinstance(known[1], Parameter):
        message, hint = f"{name} is not a parameter", f"name a parameter of {split(target)[0]}"
        yield Problem(message=message, key=".".join(path[:-1]), path=path, got=shown(name), hint=hint)


@dataclass(frozen=True)
class StabilityVerdict:
    """Return whether a loop is stable."""

    loop: str
    unit: str = "1"


def quantity_of(flat: FlatGraph, requirement: Requirement) -> Quantity | StabilityVerdict:
    """Return the quantity of a requirement, whose name or table it has; raises `Refusal`."""
    wanted = requirement.quantity
    if not isinstance(wanted, str):
        try:
            return checked_quantity(wanted, flat)
        except Refusal as error:
            key = f"quantity.{error.key}" if error.key else "quantity"
            raise Refusal(str(error), error.hint, key=key, got=error.got, expected=error.expected) from None
    units = measure_units(flat)
    if wanted in units:
        return MeasureOf(wanted, units[wanted])
    loop, margin = split(wanted)
    if loop in flat.loops and margin == _VERDICT:
        return StabilityVerdict(loop)
    if loop in flat.loops and margin in MARGIN_MEASURES:
        return LoopFigure(loop, margin, MARGIN_MEASURES[margin])
    head, _, limit = wanted.partition(".")
    if head == YIELD:
        return YieldOf(limit)
    margins = [f"{loop}.{margin}" for loop in flat.loops for margin in MARGIN_MEASURES]
    names = [*flat.measures, *flat.root.derived, *margins, YIELD]
    raise Refusal(f"there is no quantity {shown(wanted)[1:-1]}", did_you_mean(wanted, names, "the quantities"))


def _limit(quantity: Quantity | StabilityVerdict, key: str, written: float | str | None, missing: float) -> float:
    if written is None:
        return missing
    try:
        if isinstance(quantity, StabilityVerdict) and isinstance(written, str):
            return _verdict(written)
        return _number(written, quantity.unit)
    except Refusal as error:
        raise error.under(key, written, f"a quantity in {quantity.unit}") from None
    except OverflowError:
        raise Refusal("is too large for a number", key=key, got=shown(written)) from None


def _number(written: float | str, unit: str) -> float:
    if unit == "dB":
        return read_requirement(written, unit)
    if unit == "%" and isinstance(written, str):
        number = 100.0 * convert(written, "1")
    else:
        number = convert(written, unit) if isinstance(written, str) else float(written)
    if math.isnan(number):
        raise Refusal("must be a number")
    if math.isinf(number):
        raise Refusal("must be finite", "leave it out where there is no limit")
    return number


def _verdict(given: str) -> float:
    if given not in VERDICTS:
        raise Refusal("there is no such verdict", f"the verdicts: {', '.join(VERDICTS)}")
    return VERDICTS[given]
