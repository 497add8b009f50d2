"""Margins of many sensors of one plan: maps by machine code, figures side by side, the certified
path where it counts.

The first sensor, the plan itself, is linearised in full. Another takes the fast path if its loop is
of the same kind: the map of one common period at the same operating point, which the next period
repeats, of the same states, with one value of the wire. Any other, and any near a limit, is
linearised in full too. Whether a sensor stands alone or among others makes no difference to its
figures.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, REQUIREMENTS, SETTLED, VERDICTS
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.linearise import loop_nodes
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop
from proofmass.runner.analysis.linearisation.orbit import FROZEN, LONGEST_ORBIT, SAME
from proofmass.runner.analysis.linearisation.poles import Verdict
from proofmass.runner.analysis.linearisation.rings import Entry
from proofmass.runner.analysis.linearisation.seeds import NO_RINGS, place_of
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.linearisation.tick_maps import between
from proofmass.runner.analysis.margins.margins import Margins, margins_of
from proofmass.runner.analysis.margins.settled_lanes import SettledLanes
from proofmass.runner.analysis.margins.side_by_side import (
    MOVED,
    Amounts,
    LoopKind,
    OpenLoops,
    amounts,
    grows,
    in_rows,
    kind_of,
    neutral_mode,
    open_loops,
    responses,
)
from proofmass.runner.analysis.margins.stability import margins_or_reasons
from proofmass.runner.derivatives.dual_noise import changing
from proofmass.runner.derivatives.dual_ticks import LastingPlace
from proofmass.runner.derivatives.stepped_ticks import TickSlopes
from proofmass.runner.host.arrays import Array, Truths
from proofmass.runner.plan.bindings import BufferBinding, StateBinding, Tick, Time
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

if TYPE_CHECKING:
    from proofmass.runner.targets.native import BegunNumbers
    from proofmass.runner.targets.native_slopes import CompiledSlopes

# Of each loop its requirements in their order, NaN if it is not stable, and its verdict.
MarginValues = tuple[float, ...]
_OF_TIME = (StateBinding, BufferBinding, Time, Tick)
_TOGETHER = 256  # sensors whose slopes are kept at a time
_MOVES = 0.1  # part of L in a period, of a loop that starts up by motion: far above `NOTED`
_PLACES = math.pi * np.geomspace(1e-3, 0.9, 8)  # rad a period
_STEADY = 0.1 * FROZEN  # part of L that may change in all a search for a point looks at


@dataclass(frozen=True)
class _Period:
    """Facts that the loops of all sensors at one wire share, from one operating point on."""

    node: Endpoint
    ticks: int
    seconds: float
    states: tuple[Entry, ...]  # between wire and wire
    places: Mapping[Entry, LastingPlace]  # of all states that have slopes
    moving: frozenset[str]
    timed: frozenset[str]  # blocks upstream that may switch the loop, at times that may be others for other numbers
    tick: int  # of the operating point
    settled: bool  # each settles in its own; in the same one, if a switch may follow
    motion: float = 0.0  # of L from this period to the next, where it starts up by that


@dataclass(frozen=True)
class _Pattern:
    """A period at the operating point, and the kind of a loop there. From where it starts up it must grow away."""

    at: _Period
    kind: LoopKind
    start: _Period | None


class ManyMargins:
    """The margins of sensors that differ from a plan in the numbers of blocks."""

    def __init__(self, plan: Plan, at: str) -> None:
        self._plan, self._at = plan, at
        self._course = Course(plan, many=True)
        self._nodes = loop_nodes(plan)
        self._patterns = self._common()
        ticks = [pattern.at.tick for pattern in self._patterns if pattern.at.settled]
        self._lanes = SettledLanes(self._course.plan, max(ticks)) if ticks else None

    def values(self, sensors: Sequence[Plan]) -> list[MarginValues | ModelError]:
        """Return the margins of each sensor, or why it has none."""
        parts = (sensors[first : first + _TOGETHER] for first in range(0, len(sensors), _TOGETHER))
        return [value for part in parts for value in self._values(part, len(sensors))]

    def _values(self, sensors: Sequence[Plan], total: int) -> Iterator[MarginValues | ModelError]:
        courses = [Course(sensor, like=self._course) for sensor in sensors]
        alike = [course.plan for course in courses if course.like] if self._lanes else []
        settled = iter(self._lanes.memories(alike, total) if self._lanes and alike else ())
        begun = [_Begun(course, next(settled, None) if course.like else None) for course in courses]
        columns = [self._fast(pattern, begun) for pattern in self._patterns]
        for number, sensor in enumerate(sensors):
            known = [column[number] for column in columns if number in column]
            if known and len(known) == len(self._nodes):
                yield tuple(value for row in known for value in row)
            else:
                yield margins_alone(sensor, self._at, self._course)

    def _common(self) -> list[_Pattern]:
        """Return what is common to the loops at each wire; nothing if one of them is not of a kind for this."""
        if self._course.slopes() is None:
            return []
        points = OperatingPoints(self._plan, self._at, course=self._course)
        try:
            found = [self._pattern(points, node) for node in self._nodes.values()]
        except ModelError:
            return []
        return [] if None in found else [pattern for pattern in found if pattern is not None]

    def _pattern(self, points: OperatingPoints, node: Endpoint) -> _Pattern | None:
        about, system = points.about_loop(node)
        period, point = self._period(about, system, node), about.point_of(_ends(node))
        found = margins_of(system, "", "")
        start = None
        if self._at == AUTO and about.tick:  # each looks for its own point, first at the start
            start = self._starting(node) if about.at == SETTLED else None
            if start is None:
                return None
        elif self._at == AUTO and point.moves:  # it may leave the start
            return None
        loop = open_loops(system)
        neutral = neutral_mode(loop) if found.hidden else None
        if period is None or point.others or point.notes or len(found.hidden) != (neutral is not None):
            return None
        return _Pattern(period, kind_of(loop, found, system.map.period, neutral), start)

    def _starting(self, node: Endpoint) -> _Period | None:
        """Return the period of a loop that starts up; None if it may answer at the start."""
        about = Linearisation(self._plan, self._course)
        there, later = about.opened(node), about.point_of(_ends(node)).later
        period = self._period(about, there, node)
        if period is None or not all({*there.map.states} <= {*of.states} for of in later):
            return None
        if not period.states and period.ticks == 1 and self._counts(_ends(node).blocks(self._plan)[0]):
            return None  # it may be closed for instants
        of_states = (of.kept([of.states.index(state) for state in there.map.states]) for of in later[:1])
        loops = _Loops([0], *map(open_loops, [there, *map(OpenLoop, of_states), there][:2]))
        motion = float(loops.motion[0]) if there.map.starting else 0.0
        period = replace(period, motion=motion if motion >= _MOVES else 0.0)
        return period if loops.start_up(period) else None

    def _counts(self, names: Iterable[str]) -> bool:
        """Return whether states of some blocks have whole numbers."""
        states = (type(self._plan.blocks[name]).state_class() for name in names)
        return any(kind is not float for state in states if state for kind in state.__annotations__.values())

    def _period(self, about: Linearisation, system: OpenLoop, node: Endpoint) -> _Period | None:
        """Return the period of a loop that is that of the schedule and stays; None of any other."""
        ends = _ends(node)
        whole = about.point_of(ends)
        if system.continuous or whole.rings.of or whole.periods != 1 or system.per_period != 1:
            return None
        upstream, moving = ends.blocks(self._plan)
        memory = start(self._plan)
        return _Period(
            node,
            system.ticks,
            system.map.period,
            system.map.states,
            {entry: place_of(memory, entry, NO_RINGS) for entry in whole.map.states},
            frozenset(moving),
            frozenset((upstream - moving) & changing(self._plan, _OF_TIME)),
            about.tick,
            about.at == SETTLED,
        )

    def _fast(self, pattern: _Pattern, sensors: "Sequence[_Begun]") -> dict[int, MarginValues]:
        """Return the margins of the sensors at one wire, but of those to be certified."""
        some, values = dict(enumerate(sensors)), dict[int, MarginValues]()
        if pattern.start is not None:
            several = self._loops(pattern.start, some)
            some = {number: some[number] for rows in several for number in rows.start_up(pattern.start)}
        for rows in self._loops(pattern.at, some):
            found, sure = rows.amounts(pattern.kind)
            for row, number in enumerate(rows.numbers):
                if sure[row] and (found.stable[row] or self._at != AUTO):
                    verdict: Verdict = "stable" if found.stable[row] else "unstable"
                    values[number] = _values(verdict, found.figures(row, pattern.at.seconds).required())
        return values

    def _loops(self, period: _Period, sensors: "Mapping[int, _Begun]") -> Iterator["_Loops"]:
        """Yield loops of sensors at a wire, together if their slopes have one structure."""
        alike, engine = dict[tuple[bytes, ...], dict[int, TickSlopes]](), None
        for number, begun in sensors.items():
            ran = self._two_periods(period, begun, engine)
            engine = ran or engine
            if ran:
                slopes = ran.slopes()
                alike.setdefault(slopes.structure(), {})[number] = slopes
        for several in alike.values():
            first = next(iter(several.values()))
            whole = first._replace(value=np.array([slopes.value for slopes in several.values()]))
            first_half, second_half = whole.halves()
            now = _of_states(first_half, period)
            after = _of_states(second_half, period) if period.states else now  # what that does to no gain is nil
            if now is not None and after is not None:
                yield _Loops([*several], now, after)

    def _two_periods(
        self, period: _Period, begun: "_Begun", before: "CompiledSlopes | None"
    ) -> "CompiledSlopes | None":
        """Return two periods of a sensor's loop, by the engine of one `before` if that serves; None if they fail."""
        course, code = begun.course, self._course.slopes()
        assert code is not None
        if any(course.plan.blocks[name] is not self._plan.blocks[name] for name in period.timed):
            return None
        try:
            tick = begun.settled if period.settled else period.tick
            if period.timed and tick != period.tick:
                return None
            memory = begun.memory(tick - tick % period.ticks)
            if before and course.like and not course.plan.recorded:
                engine = before
                engine.again(course.plan, memory, begun.numbers(engine, memory))
            else:
                engine = code.ticks(memory, (period.node,), {*period.places.values()}, period.moving, course.plan)
            return engine if engine.advance(memory.tick + 2 * period.ticks, ()) else None
        except (ModelError, ArithmeticError):
            return None


class _Begun:
    """The run of a sensor, and what it begins with at operating points, for all of its loops."""

    def __init__(self, course: Course, settled: Memory | None = None) -> None:
        """Take the memory in which it has settled, if that is known."""
        self.course, self._numbers = course, dict[int, "BegunNumbers"]()
        self._settled, self._memories = settled, {settled.tick: settled} if settled else {}

    @cached_property
    def settled(self) -> int:
        return self._settled.tick if self._settled else settled_tick(self.course)

    def memory(self, tick: int) -> Memory:
        """Return the memory at the start of a tick; raises `ModelError`."""
        if tick not in self._memories:
            self._memories[tick] = self.course.at(tick)
        return self._memories[tick]

    def numbers(self, engine: "CompiledSlopes", memory: Memory) -> "BegunNumbers":
        """Return the numbers with which an engine begins there, as others with the same code."""
        if memory.tick not in self._numbers:
            self._numbers[memory.tick] = engine.numbers_of(self.course.plan, memory)
        return self._numbers[memory.tick]


@dataclass(frozen=True)
class _Loops:
    """Loops of some sensors in a period, and in the next one."""

    numbers: Sequence[int]
    now: OpenLoops
    after: OpenLoops

    @cached_property
    def same(self) -> Truths:
        """True for those that the next period repeats."""
        pairs = zip(self.now, self.after, strict=True)
        alike = [np.abs(later - part) <= SAME * np.abs(part) for part, later in pairs]
        return np.asarray(np.all([each.reshape(len(each), -1).all(axis=1) for each in alike], axis=0))

    @cached_property
    def motion(self) -> Array:
        """The largest relative change of L from one period to the next."""
        w = np.broadcast_to(_PLACES, (len(self.numbers), len(_PLACES)))
        now, after = (np.abs(responses(loops, w)) for loops in (self.now, self.after))
        change = np.abs(responses(self.now, w) - responses(self.after, w))
        return np.asarray(np.max(change / np.maximum(np.maximum(now, after), 1e-300), axis=1))

    def start_up(self, period: _Period) -> list[int]:
        """Return which of them grow beyond doubt, have no gain, or move about as much as the first that starts up."""
        open_ends = (self.now.d == 0.0) & (self.now.b.shape[1] == 0)
        moving = (self.motion >= 0.5 * period.motion) & (period.motion > 0.0)
        growing = np.where(self.same, grows(self.now), grows(self.now, MOVED))
        return [self.numbers[row] for row in np.flatnonzero(open_ends | moving | growing).tolist()]

    def amounts(self, kind: LoopKind) -> tuple[Amounts, Truths]:
        """Return their figures, and which of these are sure: of equal or nearly equal periods."""
        found, steady = amounts(self.now, kind), self.same
        if not steady.all():
            before, later = (responses(loops, found.places) for loops in (self.now, self.after))
            horizon = 1.0 / np.fmax(FROZEN * found.lowest, 1.0 / LONGEST_ORBIT)
            near = np.isnan(found.places) | (np.abs(later - before) <= (_STEADY / horizon)[:, None] * np.abs(before))
            steady = steady | (near.all(axis=1) & (np.abs(found.size - 1.0) > MOVED))
        return found, found.certain & steady


def _ends(node: Endpoint) -> Ends:
    return Ends((node,), (node,), cut=True)


def _of_states(slopes: TickSlopes, period: _Period) -> OpenLoops | None:
    """Return the loops of a period, with the sign of negative feedback.

    None if it has not one value of the wire, and its states between its ends.
    """
    if slopes.valued.sum() != 1:
        return None
    whole, size, places = _whole(slopes), len(slopes.places), [period.places[state] for state in period.states]
    first = whole[0] != 0.0
    if {slopes.places[i] for i in between(first[:size, :size], first[:size, size], first[size, :size])} != {*places}:
        return None
    states = [slopes.places.index(place) for place in places]
    rows = whole[:, states]
    return in_rows(OpenLoops(rows[:, :, states], rows[:, :, size], -whole[:, size, states], -whole[:, size, size]))


def _whole(slopes: TickSlopes) -> Array:
    """Return [A b] and below it [c d] of a period with one value of the wire, for each of several sensors."""
    size, bounds = len(slopes.places), np.searchsorted(slopes.tick, np.arange(len(slopes.valued) + 1))
    moved, read = np.eye(size, size + 1)[None], np.zeros((len(slopes.value), 1, size + 1))
    for valued, first, last in zip(slopes.valued, bounds, bounds[1:], strict=False):
        maps = np.zeros((len(slopes.value), size + 1, size + 1))
        maps[:, slopes.row[first:last], slopes.column[first:last]] = slopes.value[:, first:last]
        after = maps[:, :, :size] @ moved
        after[:, :, size] += maps[:, :, size]
        moved, read = after[:, :size], after[:, size:] if valued else read
    return np.concatenate([moved, read], axis=1)


def margins_alone(sensor: Plan, at: str, like: Course | None = None, over: bool = False) -> MarginValues | ModelError:
    """Return the margins of one sensor by the certified path, or why it has none.

    They are the least `over` the phases of an oscillation that nothing holds, if so wanted.
    """
    found = margins_or_reasons(OperatingPoints(sensor, at, course=Course(sensor, like)), over=over).values()
    problems = [problem for answer in found if isinstance(answer, ModelError) for problem in answer.problems]
    if problems:
        return ModelError(problems)
    known = (_values(one.verdict, {**one.required(), **one.elsewhere}) for one in found if isinstance(one, Margins))
    return tuple(value for values in known for value in values)


def _values(verdict: Verdict, required: Mapping[str, float]) -> MarginValues:
    return *(required[name] if verdict == "stable" else math.nan for name in REQUIREMENTS), VERDICTS[verdict]
