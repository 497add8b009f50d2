"""Inputs of a digital part: converters, and ranges stated of them or the wires into them."""

import math
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import Fixed, FixedValue, fixed
from proofmass.blocks.declaration.instance import format_of
from proofmass.blocks.declaration.problem import Problem, Refusal, problem_of_output
from proofmass.blocks.registers.fixed_quantiser import FixedQuantiser
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.derivatives.dual_noise import reached
from proofmass.runner.design.proof.quantity_claims import both_ends, refused
from proofmass.runner.fixed.step_formats import WORD
from proofmass.runner.plan.planned import Plan

_WIDE, _MOST = Fixed(512, 0), Fraction(2) ** 500  # holds every mantissa before it is limited


@dataclass(frozen=True)
class DigitalInput:
    """A converter into a digital part, and what can be at the signal of which a range is known."""

    node: Endpoint  # the output of the converter
    signal: str  # of which the range is known: the wire into the converter, or its output
    low: float
    high: float
    unit: str
    stated: bool  # not what the format holds
    mantissas: tuple[int, int]  # that enter
    format: tuple[int, int]  # the lowest and the highest that can
    driven: bool  # True if a run can be given what is within the range
    over: tuple[int, int] | None = None  # of an overflowing quantiser: mantissas before limits

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        ends = {"low": self.low, "high": self.high, "unit": self.unit}
        return {"signal": self.signal, **ends, "stated": self.stated}


def digital_inputs(plan: Plan, blocks: AbstractSet[str], stated: Mapping[str, Any]) -> list[DigitalInput]:
    """Return what enters some digital blocks, whatever its format holds; `stated` has narrower ranges by signal.

    These are converters, and other digital blocks, which may give anything.

    Raises `ModelError` for a range of what does not enter the digital part of the graph, and for a
    wrong one.
    """
    ranges = {node_of(plan, signal): (signal, _ends(plan, signal, limits)) for signal, limits in stated.items()}
    known = {node for node, _ in _entering(plan, plan.digital.keys())}
    for node, (signal, _) in ranges.items():
        if node not in known | {plan.schedule.drivers.get((name, "input")) for name, _ in known}:
            raise plan.graph.placed(_elsewhere(signal, node, known)).error
    fed = reached(plan, set(plan.digital))
    return [_input(plan, node, format, ranges, fed) for node, format in _entering(plan, blocks)]


def _input(
    plan: Plan,
    node: Endpoint,
    format: Fixed,
    ranges: Mapping[Endpoint, tuple[str, tuple[float, float]]],
    fed: AbstractSet[str],
) -> DigitalInput:
    block, step = plan.blocks[node[0]], format.resolution
    is_quantiser = isinstance(block, FixedQuantiser)
    unit, all_of = plan.unit(node), (format.lowest, format.highest)
    if node in ranges:
        signal, (low, high) = ranges[node]
        first = max(math.ceil(Fraction(low) / step), format.lowest)
        last = min(math.floor(Fraction(high) / step), format.highest)
        if first > last:
            message, expected = f"no value of {signal} lies in this range", f"a range of values of {format.with_range}"
            raise plan.graph.placed(Problem(message=message, key=signal, expected=expected)).error
        return DigitalInput(node, signal, low, high, unit, True, (first, last), all_of, is_quantiser)
    wire = plan.schedule.drivers.get((node[0], "input"), node)
    if wire in ranges and isinstance(block, FixedQuantiser):
        signal, (low, high) = ranges[wire]
        steps = (min(max(Fraction(end) / step, -_MOST), _MOST) for end in (low, high))
        first, last = (int(fixed(end, _WIDE, block.rounding).value) for end in steps)
        over = (first, last) if first < format.lowest or last > format.highest else None
        held = min(max(first, format.lowest), format.highest), min(max(last, format.lowest), format.highest)
        if over and block.overflow != "saturate":
            held = all_of
        return DigitalInput(node, signal, low, high, unit, True, held, all_of, True, over)
    low, high = float(format.lowest * step), float(format.highest * step)
    driven = is_quantiser and node[0] not in fed
    return DigitalInput(node, ".".join(node), low, high, unit, False, all_of, all_of, driven)


def _entering(plan: Plan, blocks: AbstractSet[str]) -> Iterator[tuple[Endpoint, Fixed]]:
    """Yield each output that enters some digital blocks from outside, and its format; raises `ModelError`."""
    seen = set[Endpoint]()
    for (target, _), node in sorted(plan.schedule.drivers.items()):
        if target not in blocks or node[0] in blocks or node in seen:
            continue
        seen.add(node)
        block = plan.blocks[node[0]]
        port = type(block).outputs[node[1]]
        if port.shape:
            raise plan.graph.placed(_vector(node)).error
        bit = Fixed(1, 0, signed=False)
        yield node, format_of(block, node[1]) if port.dtype is FixedValue else bit if port.dtype is bool else WORD


def _ends(plan: Plan, signal: str, limits: Any) -> tuple[float, float]:
    try:
        return both_ends(limits, plan.unit(node_of(plan, signal)))
    except Refusal as error:
        raise plan.graph.placed(refused(error, limits, signal)).error from None


def _elsewhere(signal: str, node: Endpoint, known: AbstractSet[Endpoint]) -> Problem:
    return Problem(
        message=f"{signal} does not enter the digital part",
        key=signal,
        expected="the output of a converter into fixed point, or the wire into a FixedQuantiser",
        hint=f"the digital part has {', '.join(sorted(map('.'.join, known))) or 'no inputs'}",
        path=("blocks", node[0]),
    )


def _vector(node: Endpoint) -> Problem:
    return problem_of_output(
        node,
        message=f"{'.'.join(node)} enters the digital part as a vector",
        expected="inputs that are one number",
        hint="take a part of the graph without it",
    )
