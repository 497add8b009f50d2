"""Claims about the digital part of a graph: nothing overflows, and how far what is dropped moves an output.

The functions of the blocks are affine as long as no number leaves its format and no decision
changes: these are the conditions. By induction over the ticks all of them hold if each holds for
all that the affine map gives, with any inputs in their ranges and any errors. Then an output
differs from that in exact arithmetic by the sum of errors times responses. The same sum bounds
limit cycles of zero input in which no condition fails: there, what a register was at the start has
decayed.
"""

import math
import threading
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from proofmass.blocks.arithmetic.fixed_point import FixedValue
from proofmass.blocks.declaration.instance import format_of
from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, shown
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.blocks.registers.fixed_to_number import FixedToNumber
from proofmass.graphs.model.digraph import turned, with_following
from proofmass.graphs.model.graph import Endpoint, split
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.design.proof.digital_inputs import DigitalInput, digital_inputs
from proofmass.runner.design.proof.digital_map import DigitalMap, digital_map
from proofmass.runner.design.proof.digital_reach import DigitalReach, Reach
from proofmass.runner.design.proof.quantity_claims import number_of, refused
from proofmass.runner.design.proof.worst_input import OverflowRun, overflow_of_inputs, within_ranges, worst_input
from proofmass.runner.fixed.affine import FormBounds
from proofmass.runner.output.json_text import finite
from proofmass.runner.plan.planned import Plan

NO_OVERFLOW, ROUNDING = "no overflow", "rounding error"
_TRIED = 8  # numbers whose worst inputs are run
_DIGITS = 4  # of a bound that is looked for


@dataclass(frozen=True)
class ValueRoom:
    """A number of a block, how far it gets, and how far it may, in steps."""

    at: str  # the function that makes it
    low: float  # infinite where there is no bound
    high: float
    lowest: int | None  # None where it may be anything
    highest: int | None

    @property
    def is_kept(self) -> bool:
        """True if it stays within: it is a whole number."""
        return self.beyond_low <= 0.0 and self.beyond_high <= 0.0

    @property
    def beyond_low(self) -> float:
        """Steps by which it may get below its range, rounded to whole steps."""
        return -math.inf if self.lowest is None else self.lowest - _whole(self.low, math.ceil)

    @property
    def beyond_high(self) -> float:
        """Steps by which it may get above its range, rounded to whole steps."""
        return -math.inf if self.highest is None else _whole(self.high, math.floor) - self.highest

    @property
    def beyond(self) -> float:
        """Part of its range by which it may get beyond it."""
        return max(self.beyond_low, self.beyond_high) / max(1, abs(self.lowest or 0), abs(self.highest or 0))

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        reach = {"low": finite(self.low), "high": finite(self.high)}
        return {"at": self.at, **reach, "lowest": self.lowest, "highest": self.highest}

    def __str__(self) -> str:
        """The number in words, in steps of its format."""
        lowest = "any" if self.lowest is None else self.lowest
        highest = "any" if self.highest is None else self.highest
        if not math.isfinite(self.high - self.low):
            return f"{self.at} has no bound, and holds {lowest} to {highest} steps"
        low, high = math.ceil(self.low), math.floor(self.high)
        return f"{self.at} gets from {low} to {high} steps, and holds {lowest} to {highest}"


@dataclass(frozen=True)
class DigitalProof:
    """A claim about the digital part, and what came of it."""

    kind: str  # `NO_OVERFLOW` or `ROUNDING`
    output: str  # of a rounding error, else ""
    limit: float  # of a rounding error, in the unit of the output; infinite where the best is looked for and not there
    unit: str
    status: str  # "proved", "refuted" or "open"
    why: str = ""
    inputs: tuple[DigitalInput, ...] = ()  # what enters
    rooms: tuple[ValueRoom, ...] = ()  # numbers with a range, the fullest first
    error: tuple[float, float] | None = None  # ends of the rounding error, while nothing overflows
    run: OverflowRun | None = None  # in which something overflows
    seconds: float = 0.0
    map: DigitalMap | None = None  # of the blocks that it is about
    step: Fraction = Fraction(1)  # of the output

    def __str__(self) -> str:
        """The claim in words."""
        if self.kind == NO_OVERFLOW:
            return self.kind
        most = f"of at most {in_print(self.limit, self.unit, 12)}" if math.isfinite(self.limit) else "without a bound"
        return f"{self.kind} {most}"

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "claim": str(self),
            "kind": self.kind,
            "output": self.output,
            "limit": finite(self.limit),
            "unit": self.unit,
            "status": self.status,
            "why": self.why,
            "inputs": [given.as_data() for given in self.inputs],
            "rooms": [room.as_data() for room in self.rooms],
            "error": None if self.error is None else {"low": self.error[0], "high": self.error[1]},
            "counterexample": self.run and self.run.as_data(),
            "seconds": self.seconds,
        }


class DigitalProofs:
    """Claims about the digital part of a plan, with inputs in stated ranges."""

    def __init__(self, plan: Plan, ranges: Mapping[str, Any], stop: threading.Event, until: float) -> None:
        self._plan, self._ranges, self._stop, self._until = plan, ranges, stop, until

    def no_overflow(self) -> DigitalProof:
        """Return whether no number of a block in fixed point overflows; raises `ModelError` where there is none.

        Blocks of which intervals show alone that they cannot overflow may give anything where forms
        do not serve.
        """
        begin, digital = time.monotonic(), self._plan.digital
        if not digital:
            hint = "blocks whose names begin with Fixed compute in registers"
            problem = Problem(message="the graph has no block in fixed point", key="no_overflow", hint=hint)
            raise self._plan.graph.placed(problem).error
        steps = {name: block.steps.values() for name, block in digital.items()}
        safe, blocks = {n for n in digital if not any(s.overflows or s.refuses for s in steps[n])}, set(digital)
        outside = digital_inputs(self._plan, blocks, self._ranges)
        while True:
            inputs = tuple(digital_inputs(self._plan, blocks, self._ranges))
            found = DigitalProof(NO_OVERFLOW, "", 0.0, "", "open", inputs=inputs)
            try:
                part = _Part(self._plan, blocks, inputs)
            except ModelError as error:
                loose = {problem.path[1] for problem in error.problems if problem.path[:1] == ("blocks",)}
                if not loose or not loose <= safe & blocks:
                    return replace(found, why=_words(error))
            else:
                loose = {split(room.at)[0] for room in part.rooms if not room.is_kept}
                if not loose or not loose <= safe & blocks:
                    break
            blocks -= loose
        quantised = [given for given in outside if given.over]
        rooms = _fullest([*part.rooms, *map(_room_of_quantiser, quantised)])
        found = replace(found, rooms=rooms, map=part.map)
        over = [room for room in rooms if not room.is_kept]
        if not over:
            why = f"the fullest: {rooms[0]}" if rooms else ""
            return replace(found, status="proved", why=why, seconds=time.monotonic() - begin)
        over = [room for room in over if split(room.at)[0] not in safe] or over
        run = self._run(part, outside, over)
        status, why = ("refuted", "") if run else ("open", f"{over[0]}; no run was found in which it does")
        return replace(found, status=status, why=why, run=run, seconds=time.monotonic() - begin)

    def rounding(self, output: str, limit: Any) -> DigitalProof:
        """Return whether an output keeps near that in exact arithmetic; raises `ModelError` for a wrong output."""
        begin = time.monotonic()
        node, step, unit = _digital_output(self._plan, output)
        most = _limit(output, limit, unit)
        sources = turned(self._plan.readers)
        blocks = with_following([node[0]], lambda one: self._plan.digital.keys() & sources[one])
        inputs = tuple(digital_inputs(self._plan, blocks, self._ranges))
        found = DigitalProof(ROUNDING, output, most, unit, "open", inputs=inputs)
        try:
            part = _Part(self._plan, blocks, inputs, node)
        except ModelError as error:
            return replace(found, why=_words(error))
        low, high = (float(step) * end for end in part.error(node))
        found = replace(found, rooms=part.rooms, map=part.map, step=step, seconds=time.monotonic() - begin)
        bound = max(-low, high)
        if not math.isfinite(bound):
            return replace(found, why="errors do not decay on the way to it, or too slowly")
        found = replace(found, error=(low, high), limit=_up(bound) if math.isinf(most) else most)
        over = next((room for room in part.rooms if not room.is_kept), None)
        at_most = f"at most {in_print(_up(bound), unit, 12)}"
        if over is not None:
            return replace(found, why=f"{at_most} while nothing overflows, but {over}")
        return replace(found, status="proved") if bound <= found.limit else replace(found, why=f"{at_most} is proved")

    def _run(self, part: "_Part", outside: Sequence[DigitalInput], over: Sequence[ValueRoom]) -> OverflowRun | None:
        """Return a run in which something overflows, if one is found with the worst inputs of some numbers."""
        if any(given.stated and not given.driven for given in outside):
            return None
        quantised = [given for given in outside if given.over]
        blocks = self._plan.digital.keys() | {given.node[0] for given in quantised}
        for values, ticks in (*map(self._worst_of_quantiser, quantised), *part.worst_inputs(over[:_TRIED])):
            run = overflow_of_inputs(self._plan, within_ranges(outside, values), blocks, ticks)
            if run is not None:
                return run
            if self._stop.is_set() or time.monotonic() >= self._until:
                break
        return None

    def _worst_of_quantiser(self, given: DigitalInput) -> tuple[Mapping[DigitalInput, list[float]], int]:
        """Return the end of a range a quantiser does not hold, and the ticks until it comes."""
        above = _room_of_quantiser(given).beyond_high > 0.0
        return {given: [given.high if above else given.low]}, self._plan.schedule.beat(given.node[0]).at(0) + 1


class _Part:
    """Some digital blocks: their map, and how far their numbers get."""

    def __init__(
        self, plan: Plan, blocks: AbstractSet[str], inputs: tuple[DigitalInput, ...], *outputs: Endpoint
    ) -> None:
        self.inputs = inputs
        self.map = digital_map(plan, blocks, {given.node: given.mantissas for given in inputs}, outputs)
        self._reach = DigitalReach(self.map)
        reached = self._reach.of_all([condition.form for condition in self.map.conditions])
        pairs = zip(self.map.conditions, reached, strict=True)
        self._reached = {_room(condition, reach): (condition, reach) for condition, reach in pairs}
        rooms = [room for room, (condition, _) in self._reached.items() if not (room.is_kept and condition.form.copies)]
        self.rooms = _fullest(rooms)

    def error(self, node: Endpoint) -> tuple[float, float]:
        """Return ends of what errors do to an output, in steps; infinite if they do not decay."""
        reached = [reach for form in self.map.outputs[node] if (reach := self._reach.of_errors(form))]
        return min((r.low for r in reached), default=0.0), max((r.high for r in reached), default=0.0)

    def worst_inputs(self, over: Sequence[ValueRoom]) -> Iterator[tuple[Mapping[DigitalInput, list[float]], int]]:
        """Yield values of the inputs that bring numbers furthest beyond their ranges, and the ticks that they take."""
        driven = [given for given in self.inputs if given.driven]
        if not driven:
            return
        for room in over:
            if room not in self._reached:  # that of a quantiser
                continue
            condition, reach = self._reached[room]
            for beyond, highest in sorted([(room.beyond_low, False), (room.beyond_high, True)], reverse=True):
                if beyond > 0.0:
                    yield worst_input(self.map, driven, condition, reach, highest)


def _fullest(rooms: Iterable[ValueRoom]) -> tuple[ValueRoom, ...]:
    return tuple(sorted(rooms, key=lambda room: -room.beyond))


def _room_of_quantiser(given: DigitalInput) -> ValueRoom:
    low, high = given.over or given.mantissas
    return ValueRoom(".".join(given.node), float(low), float(high), *given.format)


def _room(condition: FormBounds, reach: Reach) -> ValueRoom:
    return ValueRoom(condition.at, reach.low, reach.high, condition.low, condition.high)


def _digital_output(plan: Plan, signal: str) -> tuple[Endpoint, Fraction, str]:
    """Return an output in fixed point, its step and unit; of a converter to numbers its input."""
    node = node_of(plan, signal)
    block, unit = plan.blocks[node[0]], plan.unit(node)
    if isinstance(block, FixedToNumber):
        node = plan.schedule.drivers[node[0], "input"]
        block = plan.blocks[node[0]]
    if node[0] not in plan.digital:
        raise plan.graph.placed(_not_digital(signal, node)).error
    is_fixed = type(block).outputs[node[1]].dtype is FixedValue
    return node, format_of(block, node[1]).resolution if is_fixed else Fraction(1), unit


def _limit(output: str, limit: Any, unit: str) -> float:
    if limit in (None, ""):
        return math.inf
    try:
        most = number_of(limit, unit)
        if not 0.0 <= most < math.inf:
            raise Refusal("must be zero or above", got=shown(limit))
    except Refusal as error:
        raise refused(error, output, "rounding").error from None
    return most


def _whole(end: float, by: Any) -> float:
    return float(by(end)) if math.isfinite(end) else end


def _up(bound: float) -> float:
    """Return a number of few digits at or above a bound."""
    if bound == 0.0:
        return 0.0
    scale = 10.0 ** (_DIGITS - 1 - math.floor(math.log10(bound)))
    rounded = math.ceil(bound * scale) / scale
    return rounded if rounded >= bound else math.nextafter(bound, math.inf)


def _words(error: ModelError) -> str:
    return "; ".join(problem.message for problem in error.problems)


def _not_digital(signal: str, node: Endpoint) -> Problem:
    return Problem(
        message=f"{signal} is not an output of the digital part",
        key=signal,
        expected="an output of a block in fixed point, or of a FixedToNumber after one",
        path=("blocks", node[0]),
    )
