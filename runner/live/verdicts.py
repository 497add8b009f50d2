"""Verdicts of a graph for the strip of a live page: its loops, their limits, its requirements.

Those of measures are decided on the page, which has the measures of its run; the others ask an
analysis.
"""

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

from proofmass.blocks.declaration.problem import ModelError
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.graphs.checks.requirements import asked, quantity_of
from proofmass.graphs.model.flatten import FlatGraph
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO, REQUIREMENTS
from proofmass.graphs.model.quantities import MeasureOf, YieldOf
from proofmass.graphs.model.requirements import Requirement
from proofmass.runner.analysis.linearisation.linearise import loops_of
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

if TYPE_CHECKING:
    from proofmass.runner.analysis.margins.margins import Margins

_START = "0 s"
_SLOW = "proofmass verify answers this: it takes many runs"


def required_measures(flat: FlatGraph) -> list[dict[str, Any]]:
    """Return the requirements of measures, with the limits in the units of these."""
    required = {name: one for name, one in flat.root.requirements.items() if _is_of_a_run(flat, one)}
    return [
        {"id": name, "text": one.text, "measure": one.quantity, **_limits(*asked(flat, one)[1:])}
        for name, one in required.items()
    ]


class Verdicts(NamedTuple):
    """Chips of the strip, and whether a thorough answer would say more."""

    verdicts: list[dict[str, Any]]
    more: bool


def loop_names(planned: Plan) -> list[str]:
    """Return the loops of a graph that have margins, if there are any."""
    try:
        return list(loops_of(planned))
    except ModelError:
        return []


def verdicts(graph: Graph, thorough: bool) -> Verdicts:
    """Return what is known of each loop, its limits and each requirement that needs an analysis.

    Loops are judged at the start, which takes some 50 ms. They may be others later: only a thorough
    answer is about the operating point that `proofmass margins` takes, and asks the requirements.
    `met` is None where there is no answer.
    """
    planned = plan(graph)
    names = loop_names(planned)
    loops = list(_of_loops(planned, thorough)) if names else []
    required = any(not _is_of_a_run(planned.graph, one) for one in graph.requirements.values())
    rest = list(_of_requirements(graph, planned)) if thorough and required else []
    return Verdicts([*loops, *rest], not thorough and (required or bool(names)))


def _of_loops(planned: Plan, thorough: bool) -> Iterator[dict[str, Any]]:
    # start-up time: a page is there before its first margins
    from proofmass.runner.analysis.linearisation.linearisation import OperatingPoints
    from proofmass.runner.analysis.margins.margins import Margins
    from proofmass.runner.analysis.margins.stability import margins_or_reasons

    points = OperatingPoints(planned, AUTO if thorough else _START)
    for name, answer in margins_or_reasons(points, over=thorough).items():
        if not isinstance(answer, Margins):
            yield {"id": name, "met": None, "value": "no verdict", "why": _why(answer)}
            continue
        told = answer.system.map.told
        figures = ((answer.least_gain_margin, "dB", 2), (math.degrees(answer.phase_margin or math.inf), "deg", 1))
        texts = [f"{value:.{digits}f} {unit}" for value, unit, digits in figures if math.isfinite(value)]
        value = ", ".join([answer.verdict, *(texts if answer.stable else ())])
        if told:
            value = f"{told}: {value}"
        elif not thorough:
            value += " at the start"
        about = "; ".join([f"Opened at {answer.open_at}", *answer.system.map.notes])
        met = {"stable": True, "unstable": False}.get(answer.verdict)
        yield {"id": name, "met": met, "value": value, "why": about}
        yield from _limits_of(planned, name, answer)


def _limits_of(planned: Plan, name: str, answer: "Margins") -> Iterator[dict[str, Any]]:
    loop = planned.graph.loops.get(name)
    for key, limit in (loop.requirements if loop else {}).items():
        peak, unit = key == "sensitivity_peak", REQUIREMENTS[key]
        value = answer.attained(key) if answer.stable else math.nan
        kept = value <= limit if peak else value >= limit
        shown = f"{value:.4g} {unit}" if answer.stable else answer.verdict
        about = f"{shown} {_sign(not kept, peak)} {limit:g} {unit}" if answer.stable else f"{shown}: {limit:g} {unit}"
        yield {"id": f"{name} {key.replace('_', ' ')}", "met": kept, "value": about, "why": ""}


def _of_requirements(graph: Graph, planned: Plan) -> Iterator[dict[str, Any]]:
    # start-up time: as above
    from proofmass.runner.verification.verify import Measurements, finding_of

    measurements = Measurements(graph, None)
    for name, requirement in graph.requirements.items():
        if _is_of_a_run(planned.graph, requirement):
            continue
        if requirement.tolerances or isinstance(quantity_of(planned.graph, requirement), YieldOf):
            yield {"id": name, "met": None, "value": "not asked here", "why": _SLOW, "asked": False}
            continue
        finding = finding_of(measurements, name, requirement)
        met = None if finding.reason else finding.met
        most = finding.value > finding.at_most or math.isinf(finding.at_least)
        limit = finding.at_most if most else finding.at_least
        value, wanted = (in_print(number, finding.unit, 5) for number in (finding.value, limit))
        about = f"{value} {_sign(not met, most)} {wanted}"
        yield {"id": name, "met": met, "value": about, "why": finding.reason or finding.text}


def _is_of_a_run(flat: FlatGraph, requirement: Requirement) -> bool:
    return isinstance(quantity_of(flat, requirement), MeasureOf) and not requirement.tolerances


def _sign(missed: bool, most: bool) -> str:
    """Return how a value stands to its limit."""
    return (">" if most else "<") if missed else ("≤" if most else "≥")


def _limits(low: float, high: float) -> Mapping[str, float | None]:
    return {"at_least": low if math.isfinite(low) else None, "at_most": high if math.isfinite(high) else None}


def _why(error: ModelError) -> str:
    return "; ".join(f"{one.message}: {one.got}" if one.got else one.message for one in error.problems)
