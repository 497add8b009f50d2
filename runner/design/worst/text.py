"""Worst cases as text for people."""

import math
from collections.abc import Iterator

from proofmass.graphs.model.quantities import MeasureOf
from proofmass.runner.design.worst.worst import WorstCase, WorstCases
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table

_ROWS = 12  # parameters in a table
_NOTHING = 1e-9  # part of the largest effect, or of the nominal value


def worst_text(cases: WorstCases) -> str:
    """Return each worst case with what makes it, and how much was looked at."""
    lines = ["interrupted: the worst so far"] if cases.interrupted else []
    for case in cases.cases:
        lines += [*_case(case, cases), ""]
    left_out = (f"{name} does not count: {reason}" for name, reason in cases.left_out.items())
    return "\n".join([*lines, *_coverage(cases), *left_out])


def _case(case: WorstCase, cases: WorstCases) -> Iterator[str]:
    unit = f" {case.quantity.unit}" if case.quantity.unit != "1" else ""
    nominal = value_text(case.nominal, case, "nominal", unit)
    worst = value_text(case.worst, case, "worst", unit)
    where = "inside the tolerances" if case.inside else "at a corner"
    yield f"{case.name}: {nominal} nominal, {worst} at worst, {where}"
    yield from (f"  {reason}" for reason in dict.fromkeys(of.reason for of in case.why.values()))
    if case.first_order is not None and case.worst is not None:
        yield f"  derivatives at the nominal values say {_number(case.first_order)}{unit}"
    effects = {single.parameter: _effect(case, single.parameter) for single in case.one_at_a_time}
    largest = max(filter(math.isfinite, (*effects.values(), abs(case.nominal or 0.0))), default=0.0)
    rows: list[tuple[str, ...]] = [("parameter", "low", "high", "at worst", "unit", "alone, low", "alone, high")]
    order = sorted(cases.ranges, key=lambda r: -effects[r.written])
    shown = [r for r in order if effects[r.written] > _NOTHING * largest][:_ROWS]
    singles = {single.parameter: single for single in case.one_at_a_time}
    for r in shown:
        place, single = case.places[r.written], singles[r.written]
        at = f"{case.values[r.written]:.6g} " + ("low" if place == -1.0 else "high" if place == 1.0 else "inside")
        ends = f"{r.low:.6g}", f"{r.high:.6g}"
        alone = (
            value_text(single.at_low, case, f"{r.written}, low"),
            value_text(single.at_high, case, f"{r.written}, high"),
        )
        rows.append((r.written, *ends, at, r.unit if r.unit != "1" else "", *alone))
    yield from (f"  {line}" for line in text_table(rows, left=(0, 4), indent=2))
    silent = [r.written for r in order if r not in shown]
    if silent:
        yield f"  of little or no effect alone: {', '.join(silent[:_ROWS])}" + (" and more" if silent[_ROWS:] else "")


def _effect(case: WorstCase, parameter: str) -> float:
    single = next(s for s in case.one_at_a_time if s.parameter == parameter)
    if case.nominal is None or single.at_low is None or single.at_high is None:
        return math.inf
    changes = [abs(end - case.nominal) for end in (single.at_low, single.at_high)]
    return max((change for change in changes if math.isfinite(change)), default=math.inf)


def _coverage(cases: WorstCases) -> Iterator[str]:
    corners = 2 ** len(cases.ranges)
    tried = "all" if cases.all_corners else f"{cases.corners:,} of"
    yield (
        f"looked at {tried} {count(corners, 'corner')} and {count(cases.random, 'random point')} of"
        f" {count(len(cases.ranges), 'parameter')}, {count(cases.evaluations, 'point')} in all"
    )
    if cases.random:
        yield (
            f"no random point is worse: with 95 % confidence less than {100.0 * cases.unseen:.2g} % of the box is;"
            " this is a search, not a proof"
        )


def value_text(value: float | None, case: WorstCase, place: str, unit: str = "") -> str:
    """Return a value with its unit, or that there is none at a place, or that a loop is unstable there."""
    if value is None:
        unstable = case.why[place].unstable if place in case.why else not isinstance(case.quantity, MeasureOf)
        return "unstable" if unstable else "no value"
    return f"{_number(value)}{unit}"


def _number(value: float) -> str:
    return "no limit" if math.isinf(value) else f"{value:.6g}"
