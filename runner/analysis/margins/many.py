"""Margins of many sensors of one plan: maps by machine code, figures side by side, the certified path where it counts.

The first sensor, the plan itself, is linearised in full. Another takes the fast path if its loop is of the same kind:
the map of one common period at the same operating point, which the next period repeats, of the same states, with one
value of the wire. Any other, and any near a limit, is linearised in full too. Whether a sensor stands alone or among
others makes no difference to its figures.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, REQUIREMENTS, SETTLED, VERDICTS
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import At, OperatingPoints, tick_of_time
from proofmass.runner.analysis.linearisation.linearise import loops_of, node_of
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
from proofmass.runner.plan.planned import Plan

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
    seeded: tuple[Entry, ...]
    moving: frozenset[str]
    timed: frozenset[str]  # blocks upstream that may switch the loop, at times that may be others for other numbers
    kind: LoopKind
    period: float


class ManyMargins:
    """The margins of sensors that differ from a plan in the numbers of blocks."""

    def __init__(self, plan: Plan, at: str) -> None:
        self._plan, self._at = plan, at
        self._time: At = 0.0 if at == AUTO else at  # of what is taken side by side
        self._course = Course(plan)
        self._nodes = {name: node_of(plan, loop.open_at) for name, loop in loops_of(plan).items()}
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
        patterns = []
        for node in self._nodes.values():
            try:
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
                    whole.map.states,
                    frozenset(moving),
                    frozenset((upstream - moving) & changing(self._plan, _OF_TIME)),
                    kind_of(first, gains, phases),
                    system.map.period,
                )
            )
        return patterns

    def _fast(self, pattern: _Pattern, sensors: Sequence[Plan]) -> list[MarginValues | None]:
        """Return the margins of the sensors at one wire, None for those that want the certified path."""
        loops = {number: loop for number, sensor in enumerate(sensors) if (loop := self._loop(pattern, sensor))}
        values: list[MarginValues | None] = [None] * len(sensors)
        if loops:
            together = OpenLoops(*map(np.array, zip(*loops.values(), strict=True)))
            found = amounts(together, pattern.kind)
            for row, number in enumerate(loops):
                known = found.certain[row] and (found.stable[row] or self._at != AUTO)
                values[number] = _row(found, row, pattern.period) if known else None
        return values

    def _loop(self, pattern: _Pattern, sensor: Plan) -> OpenLoops | None:
        """Return A, b, c and d of a sensor's loop; None if it is not of the pattern, or the next period is another."""
        if any(sensor.blocks[name] is not self._plan.blocks[name] for name in pattern.timed):
            return None
        course = Course(sensor, like=self._course)
        try:
            tick = settled_tick(course) if self._at == SETTLED else tick_of_time(sensor, self._time)
            memory = course.at(tick - tick % pattern.ticks)
            places = [place_of(memory, entry, NO_RINGS) for entry in pattern.seeded]
            code = self._course.slopes()
            assert code is not None
            ticks = code.ticks(memory, pattern.node, {*places}, pattern.moving, course.plan)
            if not ticks.advance(memory.tick + 2 * pattern.ticks, ()):
                return None
        except (ModelError, ArithmeticError):
            return None
        both = [self._map(pattern, places, half) for half in ticks.slopes().halves()]
        if both[0] is None or both[1] is None:
            return None
        apart = np.abs(both[1] - both[0])
        if not np.all(apart <= SAME * np.abs(both[0])):
            return None
        n = len(pattern.states)
        whole = both[0]
        return OpenLoops(whole[:n, :n], whole[:n, n], -whole[n, :n], -whole[n, n])

    def _map(self, pattern: _Pattern, places: Sequence[LastingPlace], slopes: TickSlopes) -> Array | None:
        """Return [A b] and below it [c d] of some ticks; None if other states lie between the ends of the wire."""
        entries = dict(zip(pattern.seeded, places, strict=True))
        maps = maps_of_ticks(slopes, entries, entries)
        if maps is None or {*maps.places} != {*pattern.states} or len(maps.d) != 1:
            return None
        return maps.lifted(pattern.states)


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
