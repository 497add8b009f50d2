"""Rates at which parameters may change, as they are written: "1 %/s" of what the graph says, or a width per time."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert
from proofmass.runner.design.worst.ranges import Range

_WRITE = 'write "1 %/s", or a width with a unit per time'


def change_rates(slow_change: str | Mapping[str, Any] | None, ranges: Sequence[Range]) -> tuple[float, ...]:
    """Return how fast the parameters of ranges change, in their units per second: none if nothing is given.

    One text is the rate of all; of a mapping the rate of "" is that of all that have no other, else they stay.

    Raises `ModelError` with every problem.
    """
    given = dict(slow_change) if isinstance(slow_change, Mapping) else {"": slow_change} if slow_change else {}
    written = [r.written for r in ranges]
    problems = [_unknown(name, written) for name in given if name and name not in written]
    rates = []
    for r in ranges if given else ():
        text = given.get(r.written, given.get("", 0.0))
        try:
            rates.append(_rate(text, r) if text != 0.0 else 0.0)
        except Refusal as error:
            problems.append(error.problem("slow_change" + f".{r.written}" * (r.written in given), text))
    if problems:
        raise ModelError(problems)
    return tuple(rates) if any(rates) else ()


def _rate(text: Any, r: Range) -> float:
    try:
        rate = abs(r.nominal) * (convert(text, "1/s") if isinstance(text, str) else float(text))
    except UnitError:
        try:
            rate = convert(text, f"({r.unit})/s" if r.unit else "1/s")
        except UnitError as error:
            raise Refusal(f"is not a rate of change: {error}", _WRITE) from None
    except (TypeError, ValueError):
        raise Refusal("is not a rate of change", _WRITE, got=shown(text)) from None
    if not (math.isfinite(rate) and rate > 0.0):
        hint = "give its rate in its unit per time" if r.nominal == 0.0 else _WRITE
        raise Refusal("is not a rate above zero", hint, got=shown(text))
    return rate


def _unknown(name: str, written: Sequence[str]) -> Problem:
    hint = did_you_mean(name, written, "parameters with a tolerance")
    return Problem(message="has no tolerance, and so does not change", key=f"slow_change.{name}", hint=hint)
