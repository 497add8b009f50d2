"""Margins of many sensors of one plan: maps by machine code, figures side by side, the certified path where it counts.

The first sensor, the plan itself, is linearised in full. Another takes the fast path if its loop is of the same kind:
the map of one common period at the same operating point, which the next period repeats, of the same states, with one
value of the wire. Any other, and any near a limit, is linearised in full too. Whether a sensor stands alone or among
others makes no difference to its figures.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, REQUIREMENTS, SETTLED, VERDICTS
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints, tick_of_time
from proofmass.runner.analysis.linearisation.linearise import loop_nodes
from proofmass.runner.analysis.linearisation.orbit import SAME
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, place_of
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.linearisation.tick_maps import maps_of_ticks
from proofmass.runner.analysis.margins.figures import decibels, least_gain_margin
from proofmass.runner.analysis.margins.margins import Margins, margins_of
from proofmass.runner.analysis.margins.side_by_side import Amounts, LoopKind, OpenLoops, amounts, kind_of
from proofmass.runner.analysis.margins.stability import attained, margins_or_reasons
from proofmass.runner.derivatives.dual_noise import changing
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import TickSlopes
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import BufferBinding, StateBinding, Tick, Time
from proofmass.runner.plan.memory import start
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.targets.native_slopes import CompiledSlopes

MarginValues = tuple[
    float, ...
]  # of each loop its requirements in their order, NaN if it is not stable, and its verdict
_TURN = 2.0 * math.pi
_OF_TIME = (StateBinding, BufferBinding, Time, Tick)


@dataclass(frozen=True)
class _Pattern:
    """Facts that the loops of all sensors at one wire share."""

    node: Endpoint
    ticks: int
    states: tuple[Entry, ...]  # between wire and wire
    places: Mapping[Entry, LastingPlace]  # of all states that have slopes
    moving: frozenset[str]
    timed: frozenset[str]  # blocks upstream that may switch the loop, at times that may be others for other numbers
    kind: LoopKind
    period: float
    tick: int  # of the operating point, unless each settles in its own


class ManyMargins:
    """The margins of sensors that differ from a plan in the numbers of blocks."""

    def __init__(self, plan: Plan, at: str) -> None:
        self._plan, self._at = plan, at
        self._time: At = 0.0 if at == AUTO else at  # of what is taken side by side
        self._course = Course(plan)
        self._nodes = loop_nodes(plan)
        self._patterns = self._common()

    def values(self, sensors: Sequence[Plan]) -> list[MarginValues | ModelError]:
        """Return the margins of each sensor, or why it has none."""
        columns = [self._fast(pattern, sensors) for pattern in self._patterns]
        made: list[MarginValues | ModelError] = []
        for number, sensor in enumerate(sensors):
            rows = [column[number] for column in columns]
            known = [row for row in rows if row is not None]
            whole = known and len(known) == len(self._nodes)
            made.append(
                tuple(value for row in known for value in row)
                if whole
                else margins_alone(sensor, self._at, self._course)
            )
        return made

    def _common(self) -> list[_Pattern]:
        """Return what is common to the loops at each wire; nothing if one of them is not of a kind for this."""
        patterns, memory = [], start(self._plan)
        for node in self._nodes.values():
            try:
                tick = 0 if self._at == SETTLED else tick_of_time(self._plan, self._time)
                about, system = OperatingPoints(self._plan, self._at).about_loop(node)
                whole = about.point_of(ends := Ends((node,), (node,), cut=True))
                found = margins_of(system, "", "")
            except ModelError:
                return []
            moves = system.continuous or whole.moves or whole.others or whole.notes or whole.rings.of
            if self._at == AUTO and about.tick:  # each looks for its own point
                return []
            if moves or whole.periods != 1 or system.per_period != 1 or found.hidden or self._course.slopes() is None:
                return []
            a, b, c, d = system.matrices
            first, turn = OpenLoops(a[None], b[None, :, 0], c[None, 0], d[0]), _TURN * system.map.period
            gains, phases = ([turn * f for f in each] for each in (found.gain_crossovers, found.phase_crossovers))
            upstream, moving = ends.blocks(self._plan)
            patterns.append(
                _Pattern(
                    node,
                    system.ticks,
                    system.map.states,
                    {entry: place_of(memory, entry, NO_RINGS) for entry in whole.map.states},
                    frozenset(moving),
                    frozenset((upstream - moving) & changing(self._plan, _OF_TIME)),
                    kind_of(first, gains, phases),
                    system.map.period,
                    tick,
                )
            )
        return patterns

    def _fast(self, pattern: _Pattern, sensors: Sequence[Plan]) -> list[MarginValues | None]:
        """Return the margins of the sensors at one wire, None for those that want the certified path."""
        alike, engine = dict[tuple[bytes, ...], dict[int, TickSlopes]](), None
        for number, sensor in enumerate(sensors):
            ran = self._two_periods(pattern, Course(sensor, like=self._course), engine)
            engine = ran or engine
            if ran:
                slopes = ran.slopes()
                alike.setdefault(slopes.structure(), {})[number] = slopes
        values: list[MarginValues | None] = [None] * len(sensors)
        for several in alike.values():
            numbers, loops = _together(pattern, several)
            if numbers:
                found = amounts(loops, pattern.kind)
                for row, number in enumerate(numbers):
                    known = found.certain[row] and (found.stable[row] or self._at != AUTO)
                    values[number] = _row(found, row, pattern.period) if known else None
        return values

    def _two_periods(
        self, pattern: _Pattern, course: Course, before: "CompiledSlopes | None"
    ) -> "CompiledSlopes | None":
        """Return two periods of a sensor's loop, by the engine of one `before` if that serves; None if they fail."""
        plan, code = course.plan, self._course.slopes()
        assert code is not None
        if any(plan.blocks[name] is not self._plan.blocks[name] for name in pattern.timed):
            return None
        try:
            tick = settled_tick(course) if self._at == SETTLED else pattern.tick
            memory = course.at(tick - tick % pattern.ticks)
            if before and course.like and not plan.recorded:
                before.again(plan, memory)
                engine = before
            else:
                engine = code.ticks(memory, pattern.node, {*pattern.places.values()}, pattern.moving, plan)
            return engine if engine.advance(memory.tick + 2 * pattern.ticks, ()) else None
        except (ModelError, ArithmeticError):
            return None


def _together(pattern: _Pattern, several: Mapping[int, TickSlopes]) -> tuple[list[int], OpenLoops]:
    """Return which of some sensors have a loop of the pattern that the next period repeats, and these loops.

    Their slopes have the same structure.
    """
    first = next(iter(several.values()))
    of_pattern = all(_is_of(pattern, half) for half in first.halves())
    both = first._replace(value=np.array([slopes.value for slopes in several.values()])).halves()
    states = [first.places.index(pattern.places[state]) for state in pattern.states]
    whole, after = (_period(half, states) for half in both)
    same = of_pattern & np.all(np.abs(after - whole) <= SAME * np.abs(whole), axis=(1, 2))
    n, whole = len(states), whole[same]
    numbers = np.array([*several])[same].tolist()
    return numbers, OpenLoops(whole[:, :n, :n], whole[:, :n, n], -whole[:, n, :n], -whole[:, n, n])


def _is_of(pattern: _Pattern, slopes: TickSlopes) -> bool:
    """Return whether a period has one value of the wire, and the states of the pattern between its ends."""
    maps = maps_of_ticks(slopes, pattern.places, pattern.places)
    return maps is not None and {*maps.places} == {*pattern.states} and len(maps.d) == 1


def _period(slopes: TickSlopes, states: Sequence[int]) -> Array:
    """Return [A b] and below it [c d] of a period with one value of the wire, for each of several sensors."""
    size, bounds = len(slopes.places), np.searchsorted(slopes.tick, np.arange(len(slopes.valued) + 1))
    moved, read = np.eye(size, size + 1)[None], np.zeros((len(slopes.value), 1, size + 1))
    for valued, first, last in zip(slopes.valued, bounds, bounds[1:], strict=False):
        maps = np.zeros((len(slopes.value), size + 1, size + 1))
        maps[:, slopes.row[first:last], slopes.column[first:last]] = slopes.value[:, first:last]
        after = maps[:, :, :size] @ moved
        after[:, :, size] += maps[:, :, size]
        moved, read = after[:, :size], after[:, size:] if valued else read
    return np.concatenate([moved[:, states], read], axis=1)[:, :, [*states, size]]


def margins_alone(sensor: Plan, at: str, like: Course | None = None) -> MarginValues | ModelError:
    """Return the margins of one sensor by the certified path, or why it has none."""
    found = margins_or_reasons(OperatingPoints(sensor, at, course=Course(sensor, like))).values()
    problems = [problem for answer in found if isinstance(answer, ModelError) for problem in answer.problems]
    if problems:
        return ModelError(problems)
    return tuple(value for each in found if isinstance(each, Margins) for value in _values(each))


def _values(found: Margins) -> MarginValues:
    stable = (attained(found, name) if found.stable else math.nan for name in REQUIREMENTS)
    return *stable, VERDICTS[found.verdict]


def _row(found: Amounts, row: int, period: float) -> MarginValues:
    """Return the margins of one of the loops."""
    if not found.stable[row]:
        return *(math.nan for _ in REQUIREMENTS), VERDICTS["unstable"]
    gain, less = float(found.gain_margin[row]), float(found.gain_reduction[row])
    phase, delay = float(found.phase_margin[row]), float(found.delay_margin[row])
    peak = decibels(float(found.sensitivity_peak[row])) or 0.0
    return least_gain_margin(gain, less), math.degrees(phase), delay * period, peak, VERDICTS["stable"]
