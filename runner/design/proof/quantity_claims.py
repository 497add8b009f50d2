"""Claims about quantities of outputs, as written: "dac.code" with limits "-8830..-8820"."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from proofmass.blocks.declaration.parameter import plain
from proofmass.blocks.declaration.problem import Problem, Refusal, shown
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.call_numbers import real
from proofmass.graphs.model.flatten import inside
from proofmass.graphs.model.quantities import checked_quantity
from proofmass.runner.design.proof.claim import PEAK, RMS, SCALE_FACTOR, Claim
from proofmass.runner.plan.planned import Plan

_DOTS = ".."
_WRITE = 'write "1.9..2.1", "1.9.." or "..2.1", with or without a unit'


def settled_claims(planned: Plan, kind: str, wanted: Mapping[str, Any], source: str = "") -> Iterator[list[Claim]]:
    """Yield the claims about the scale factor or bias of each output.

    Of one without limits these are bounds on both sides that are looked for.

    Raises `ModelError` for what is not there and for limits in other units.
    """
    for output, limits in wanted.items():
        try:
            if not source and kind == SCALE_FACTOR:
                raise Refusal("a scale factor needs an input", "name an output of a source", key="input")
            part = kind.replace(" ", "_")
            quantity = checked_quantity({part: output, "input": source or output}, planned.graph)
            ends = _ends(limits, quantity.unit)
        except Refusal as error:
            raise refused(error, output, kind.replace(" ", "_")).error from None
        loop, open_at = (inside(planned.graph.root, signal) if signal else "" for signal in (source, output))
        if loop == open_at:
            raise refused(Refusal("is the input itself", "name an output that follows it"), output).error
        yield [Claim(loop, open_at, kind, limit, most=most, unit_of_quantity=quantity.unit) for limit, most in ends]


def upper_claims(planned: Plan, kind: str, wanted: Mapping[str, Any], source: str = "") -> Iterator[list[Claim]]:
    """Yield the claim about the noise or peak of each output: of one without a limit, a bound that is looked for.

    Raises `ModelError` for what is not there and for limits in other units.
    """
    for output, limit in wanted.items():
        try:
            if kind == PEAK and not source:
                raise Refusal("a peak needs an input", "name an output of a source", key="input")
            of_peak = {"response": output, "figure": "peak", "input": source}
            quantity = checked_quantity({"noise": output} if kind == RMS else of_peak, planned.graph)
            most = math.inf if limit in (None, "") else number_of(limit, quantity.unit)
            if not most > 0.0:
                raise Refusal("must be above zero", got=shown(limit))
        except Refusal as error:
            raise refused(error, output, kind).error from None
        loop, open_at = (inside(planned.graph.root, signal) if signal else "" for signal in (source, output))
        yield [Claim(loop, open_at, kind, most, most=True, unit_of_quantity=quantity.unit)]


def both_ends(limits: Any, unit: str) -> tuple[float, float]:
    """Return two limits in a unit, such as "-1..1 V"; raises `Refusal`."""
    ends = [end for end, _ in _ends(limits, unit)]
    if len(ends) != 2 or not all(map(math.isfinite, ends)):
        raise Refusal("needs two ends", 'write "-1..1", with or without a unit', got=shown(limits))
    return ends[0], ends[1]


def _ends(limits: Any, unit: str) -> list[tuple[float, bool]]:
    """Return limits in a unit, and whether each is an upper one; raises `Refusal`."""
    limits = plain(limits)
    if isinstance(limits, str) and _DOTS in limits:
        limits = [part.strip() for part in limits.split(_DOTS)]
    if limits in (None, ""):
        return [(-math.inf, False), (math.inf, True)]
    if not isinstance(limits, list | tuple) or len(limits) != 2:
        raise Refusal("are not two limits", _WRITE, got=shown(limits))
    ends = [(number_of(end, unit), most) for end, most in _named(limits)]
    if not ends or not all(math.isfinite(end) for end, _ in ends) or ends[0][0] > ends[-1][0]:
        raise Refusal("no value lies between these", _WRITE, got=shown(limits))
    return ends


def number_of(end: Any, unit: str) -> float:
    """Return a limit in a unit; raises `Refusal`."""
    try:
        return convert(end, unit) if isinstance(end, str) else real(end)
    except Refusal as error:
        raise error.under("", end, f"a quantity in {unit}") from None
    except TypeError:
        raise Refusal("must be a number", _WRITE, got=shown(end)) from None


def _named(limits: Sequence[Any]) -> Iterator[tuple[Any, bool]]:
    yield from ((end, most) for end, most in zip(limits, (False, True), strict=True) if end not in (None, ""))


def refused(error: Refusal, value: object, key: str = "scale_factor") -> Problem:
    """Return the problem of a value that stands under a key unless the refusal names another."""
    got = error.got or shown(value)
    return Problem(message=str(error), key=error.key or key, got=got, expected=error.expected, hint=error.hint)
