"""Sources that a proof at rest takes as constant, and rates at which parameters may change, as they are written.

Each such source is a `Constant` of the same name. A rate is "1 %/s" of what the graph says, or a
width per time.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, did_you_mean, shown
from proofmass.blocks.declaration.unit_expressions import UnitError
from proofmass.blocks.declaration.units import convert, part_of
from proofmass.blocks.sources.constant import Constant
from proofmass.graphs.model.call_numbers import real
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.design.proof.quantity_claims import both_ends
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.plan.planned import Plan

_WRITE = 'write "1 %/s", or a width with a unit per time'


def with_constants(
    graph: Graph, planned: Plan, constants: Mapping[str, Any], varied: Iterable[Range]
) -> tuple[Graph, list[Range]]:
    """Return the graph with constant values at some outputs, such as "0.1 V" or "-1..1 V", and these as ranges.

    Raises `ModelError` for an output that is not there or not that of a source, for a value in
    another unit, and where something of that source is `varied`.
    """
    blocks, ranges = dict(graph.blocks), dict[str, Range]()
    for signal, written in constants.items():
        node = node_of(planned, signal)
        name, unit = node[0], planned.unit(node)
        if name not in graph.blocks or [*type(planned.blocks[name]).outputs] != ["output"]:
            raise planned.graph.placed(_no_source(signal, name)).error
        try:
            low, high = both_ends(written if ".." in str(written) else [written] * 2, unit)
        except Refusal as error:
            problem = error.under("", written, f"a value in {unit}").problem(signal, shown(written))
            raise planned.graph.placed(problem).error from None
        middle = 0.5 * low + 0.5 * high
        blocks[name] = Constant(value=middle, unit=unit or "1")
        ranges[name] = Range(f"{name}.value", f"{name}.value", unit, middle, low, high)
    twice = next((r for r in varied if r.name.partition(".")[0] in ranges), None)
    if twice is not None:
        raise planned.graph.placed(_constant(twice)).error
    wires = tuple(wire for wire in graph.wires if wire.target.partition(".")[0] not in ranges)
    formulas = {key: one for key, one in graph.formulas.items() if key.partition(".")[0] not in ranges}
    return graph.changed(blocks=blocks, wires=wires, formulas=formulas) if ranges else graph, [*ranges.values()]


def _constant(varied: Range) -> Problem:
    name = varied.name.partition(".")[0]
    return Problem(
        message="the tolerance is that of a source that is a constant here",
        key=f"tolerances.{varied.written}",
        hint=f'leave it out, and give the constant a range: --constant "{name}.output=-1..1"',
        path=("tolerances", varied.written),
    )


def _no_source(signal: str, name: str) -> Problem:
    return Problem(
        message=f"{signal} cannot be given a constant value",
        key=signal,
        expected="the output of a block of the graph itself that has no other output",
        hint="name a source, such as step.output",
        path=("blocks", name),
    )


def change_rates(slow_change: str | Mapping[str, Any] | None, ranges: Sequence[Range]) -> tuple[float, ...]:
    """Return how fast the parameters of ranges change, in their units per second: none if nothing is given.

    One text is the rate of all; of a mapping the rate of "" is that of all that have no other, else
    they stay.

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
        part = part_of(text, "1/s") if isinstance(text, str) else real(text)
        rate = convert(text, f"({r.unit})/s" if r.unit else "1/s") if part is None else abs(r.nominal) * part
    except UnitError as error:
        raise Refusal(f"is not a rate of change: {error}", _WRITE) from None
    except TypeError:
        raise Refusal("is not a rate of change", _WRITE, got=shown(text)) from None
    if not (math.isfinite(rate) and rate > 0.0):
        hint = "give its rate in its unit per time" if r.nominal == 0.0 else _WRITE
        raise Refusal("is not a rate above zero", hint, got=shown(text))
    return rate


def _unknown(name: str, written: Sequence[str]) -> Problem:
    hint = did_you_mean(name, written, "parameters with a tolerance")
    return Problem(message="has no tolerance, and so does not change", key=f"slow_change.{name}", hint=hint)
