"""Inputs that bring a form as far as it gets, and runs that show whether a number overflows then.

The n-th value before the end is the upper end of its range where h[n] > 0, else the lower one.
"""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from proofmass.blocks.sources.repeating_sequence import RepeatingSequence
from proofmass.graphs.model.graph import Graph, Wire, split
from proofmass.runner.design.proof.digital_inputs import DigitalInput
from proofmass.runner.design.proof.digital_map import DigitalMap
from proofmass.runner.design.proof.digital_reach import FollowedSystem, Reach
from proofmass.runner.design.proof.reach import responses
from proofmass.runner.fixed.affine import ERROR, INPUT, AffineSymbol, FormBounds
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.planned import Plan
from proofmass.runner.run.faults import RunError
from proofmass.runner.run.simulate import simulate

LONGEST_INPUT = 1 << 16  # values


@dataclass(frozen=True, repr=False)
class OverflowRun:
    """A run in which a number overflows: a graph with these inputs, to run again."""

    graph: Graph
    inputs: Mapping[str, tuple[float, ...]]  # values by the signal that they take the place of
    overflows: Mapping[str, int]  # ticks in which a value of a block saturated or wrapped
    refused: str  # what the run refused, "" if nothing
    ticks: int

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "inputs": {signal: list(values) for signal, values in self.inputs.items()},
            "overflows": dict(self.overflows),
            "refused": self.refused,
            "ticks": self.ticks,
        }


def overflow_of_inputs(
    plan: Plan, values: Mapping[DigitalInput, Sequence[float]], blocks: AbstractSet[str], ticks: int
) -> OverflowRun | None:
    """Return the run with such values in the place of inputs, cut after the first overflow; None if
    there is none.

    Overflows of `blocks` count.
    """
    played = {given.signal: tuple(map(float, own)) for given, own in values.items()}
    graph = _graph(plan, {given: played[given.signal] for given in values})
    found = _run(graph, played, blocks, ticks)
    if found is None:
        return None
    low, high, last = 0, ticks, found  # no overflow after `low` ticks, one after `high`
    while high - low > 1:
        middle = (low + high) // 2
        tried = _run(graph, played, blocks, middle)
        low, high, last = (middle, high, last) if tried is None else (low, middle, tried)
    used = {given: own[: plan.schedule.beat(given.node[0]).before(high)] or own[:1] for given, own in values.items()}
    short = {given.signal: tuple(map(float, own)) for given, own in used.items()}
    graph = _graph(plan, {given: short[given.signal] for given in values}).changed(samples=high, duration=None)
    return replace(last, graph=graph, inputs=short)


def within_ranges(
    inputs: Sequence[DigitalInput], values: Mapping[DigitalInput, Sequence[float]]
) -> dict[DigitalInput, Sequence[float]]:
    """Return values of all inputs with a stated range: those of the same signal, else the one nearest to zero."""
    played = {given.signal: own for given, own in values.items()}
    for given in inputs:
        if given.stated:
            played.setdefault(given.signal, [min(max(0.0, given.low), given.high)])
    return {given: played[given.signal] for given in (*values, *inputs) if given.signal in played}


def worst_input(
    of: DigitalMap, driven: Sequence[DigitalInput], condition: FormBounds, reach: Reach, highest: bool
) -> tuple[dict[DigitalInput, list[float]], int]:
    """Return the values of inputs that bring a form highest, or lowest, and the ticks it takes.

    Inputs of the same signal have the same values.
    """
    most = min(reach.periods[highest] or LONGEST_INPUT, LONGEST_INPUT // max(1, len(of.inputs)))
    system = reach.system
    parts = list(responses(system.powers, system.entering, [reach.row], most))
    h = np.concatenate(parts)[:, 0] if parts else np.zeros((0, len(system.entering.ends)))
    h = h[: _enough(h, system, condition, reach, highest)][::-1]
    places = {symbol: place for place, symbol in enumerate(system.symbols)}
    columns: dict[Any, Array] = {}  # of each value of an input in a period, over all periods
    for number, entry in enumerate(of.inputs):
        symbol = AffineSymbol(INPUT, number)
        before = h[:, places[symbol]] if symbol in places else np.zeros(len(h))
        columns[entry] = np.append(before, float(condition.form.terms.get(symbol, 0)))
    values: dict[DigitalInput, list[float]] = {}
    for given in driven:
        alike = [other.node for other in driven if other.signal == given.signal]
        count = min(sum(node == other for node, _ in of.inputs) for other in alike)
        total = sum(np.stack([columns[node, n] for n in range(count)], axis=1) for node in alike)
        up = (np.asarray(total) > 0.0) == highest
        values[given] = [given.high if one else given.low for one in up.ravel().tolist()]
    return values, of.ticks * (len(h) + 1)


def _enough(h: Array, of: FollowedSystem, condition: FormBounds, reach: Reach, highest: bool) -> int:
    """Return the periods after which a form is beyond its bounds, whatever its errors are; all if
    it never is for sure.

    What it has at once counts in the same way.
    """
    limit, sign = (condition.high, 1.0) if highest else (condition.low, -1.0)
    if limit is None:
        return len(h)
    lows, highs = sign * np.array([[float(end) for end in ends] for ends in of.entering.ends]).reshape(-1, 2).T
    is_error = np.array([symbol.kind == ERROR for symbol in of.symbols] + [False] * (len(lows) - len(of.symbols)))
    ends = np.stack([h * lows, h * highs])
    steps = np.where(is_error, ends.min(axis=0), ends.max(axis=0)).sum(axis=1)
    spread = sum(abs(float(factor)) for symbol, factor in condition.form.terms.items() if symbol.kind == ERROR)
    sure = sign * float(reach.own[highest]) - spread + np.cumsum(steps) >= sign * limit + 1.0
    return int(np.argmax(sure)) + 1 if sure.any() else len(h)


def _graph(plan: Plan, played: Mapping[DigitalInput, Sequence[float]]) -> Graph:
    """Return the flat graph with sequences in the place of what drives some converters."""
    flat = plan.graph.as_graph()
    blocks, rates, offsets, wires = dict(flat.blocks), dict(flat.rates), dict(flat.offsets), list(flat.wires)
    sources: dict[str, str] = {}
    for given, values in played.items():
        converter = given.node[0]
        name = sources.get(given.signal) or _free(blocks)
        if given.signal not in sources:
            sources[given.signal] = name
            blocks[name] = RepeatingSequence(values=tuple(values), unit=given.unit)
            for table in (rates, offsets):
                if converter in table:
                    table[name] = table[converter]
        wires = [wire for wire in wires if wire.target != f"{converter}.input"]
        wires.append(Wire(f"{name}.output", f"{converter}.input"))
    return flat.bare(blocks=blocks, rates=rates, offsets=offsets, wires=tuple(wires), probes=flat.probes)


def _free(blocks: Mapping[str, Any]) -> str:
    name, number = "worst_input", 2
    while name in blocks:
        name, number = f"worst_input_{number}", number + 1
    return name


def _run(
    graph: Graph, played: Mapping[str, tuple[float, ...]], blocks: AbstractSet[str], ticks: int
) -> OverflowRun | None:
    try:
        result = simulate(graph.bare(), samples=ticks)
    except RunError as error:
        own = split(error.problem.key)[0] in blocks
        return OverflowRun(graph, played, {}, error.problem.message, ticks) if own else None
    overflows = {name: count for name, count in result.overflows.items() if count and name in blocks}
    return OverflowRun(graph, played, overflows, "", ticks) if overflows else None
