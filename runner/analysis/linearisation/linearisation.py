"""A graph about an operating point: the linear maps between its wires, and the loops opened at them.

`OperatingPoints` looks for the point. By default it takes the first of these at which an analysis has an answer:

1. the start, if nothing changes the maps there, or if they repeat;
2. where the loops have settled;
3. the end of the graph's own run;
4. an orbit that repeats, as of a carrier, which takes longest to find.

A loop that is unstable at one of them but not at a later one was starting up. One that is unstable
at all of them is unstable, and the answer is that of the first.
"""

from collections.abc import Callable, Hashable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import islice
from typing import TypeVar

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, PERIODIC, SETTLED
from proofmass.graphs.model.rates import read_duration
from proofmass.runner.analysis.linearisation.analog_loop import analog_group, analog_map, analog_map_at
from proofmass.runner.analysis.linearisation.corners import corner_notes
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course, Onward
from proofmass.runner.analysis.linearisation.growth import makes_growth, starts_up
from proofmass.runner.analysis.linearisation.left_points import LONGEST, is_left
from proofmass.runner.analysis.linearisation.map_blocks import MOST_VALUES, coarse_blocks, too_many
from proofmass.runner.analysis.linearisation.no_loop import no_gain, not_periodic, not_within
from proofmass.runner.analysis.linearisation.numbers import time_text
from proofmass.runner.analysis.linearisation.open_loop import OpenLoop, of_wires
from proofmass.runner.analysis.linearisation.orbit import FROZEN, STARTS_UP, OrbitPoint, OrbitSearch, turning
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.periodic import OperatingPoint, PeriodicPoint, periodic_point
from proofmass.runner.analysis.linearisation.seeds import PointSlopes
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.analysis.linearisation.steady_state import slopes_at_rest, slopes_near_start
from proofmass.runner.derivatives.dual_noise import NOTHING, Noisy
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan

At = str | float | Fraction
_Answer = TypeVar("_Answer")
_FIXED = "derivatives take the operating point as fixed: it is not at rest"


@dataclass(frozen=True)
class Linearisation:
    """A plan about one operating point. It owns the run to there and the maps asked for."""

    plan: Plan
    course: Course
    point: OperatingPoint = 0
    told: str = ""  # how the point was found
    at: At = 0.0  # what finds it again
    notes: tuple[str, ...] = ()  # on the point
    ahead: bool = True  # whether a loop that is open there is taken where it closes later
    _maps: dict[Hashable, tuple[Ends, OrbitPoint]] = field(default_factory=dict, repr=False, compare=False)
    _asked: set[Hashable] = field(default_factory=set, repr=False, compare=False)  # which of these one answer takes

    @property
    def tick(self) -> int:
        """Base tick of the operating point."""
        return self.point.memory.tick if isinstance(self.point, PeriodicPoint) else self.point

    def memory(self) -> Memory:
        """Return the memory there."""
        return self.point.memory.copy() if isinstance(self.point, PeriodicPoint) else self.course.at(self.point)

    def map(
        self,
        inputs: Sequence[Endpoint],
        outputs: Sequence[Endpoint],
        *,
        cut: bool = False,
        everything: bool = False,
        by_parameters: bool = False,
        noise: Noisy = NOTHING,
        beside: Sequence[Endpoint] = (),
    ) -> PeriodMap:
        """Return the map between wires over as many periods as the orbit takes; raises `ModelError` if there is none.

        See `period_map`. Of the outputs `beside`, whose maps are asked for too, it is computed together.
        """
        ends = Ends(tuple(inputs), tuple(outputs), cut, everything, noise, tuple(beside))
        if by_parameters and (not cut or turning(self.plan, ends)):
            ends = replace(ends, whole_turns=True)
        point = self.point_of(ends)
        notes, exact, later = (*self.notes, *point.notes), point.map, point.later
        if by_parameters:
            slopes, more = self._point_slopes(ends, point)
            notes += more
            moved = ends.map(self.plan, **point.where, by_parameters=True, point_slopes=slopes)
            exact = exact.with_slopes(moved)
            if point.map.ticks and not exact.between().ticks:  # parameters lead through states beside the loop
                exact, later = ends.map(self.plan, **point.where, by_ticks=False).with_slopes(moved), ()
        starting = point.map.starting
        return replace(exact, notes=notes, later=later, others=point.others, told=self.told, starting=starting)

    def corner_notes(self, ends: Ends) -> tuple[str, ...]:
        """Return a note for each block between some wires that stands exactly at a corner."""
        try:
            point = self.point_of(ends)
        except ModelError:  # a loop through bits may have a map of its own
            return ()
        return corner_notes(self.plan, ends, point.memory or self.course.at(point.map.tick))

    def corners_of(self, system: OpenLoop, node: Endpoint) -> tuple[str, ...]:
        """Return a note for each block of a loop that stands exactly at a corner."""
        return () if system.continuous else self.corner_notes(Ends((node,), (node,), cut=True))

    def point_of(self, ends: Ends) -> OrbitPoint:
        """Return the operating point of the map between some wires; raises `ModelError`."""
        self._asked.add(ends.key)
        if ends.key not in self._maps:
            self._maps[ends.key] = ends, self._found(ends)
        return self._maps[ends.key][1]

    def answer(self, ask: Callable[["Linearisation"], _Answer]) -> _Answer:
        """Return what is answered here; `is_left` then says what holds for the maps of this answer alone."""
        self._asked.clear()
        return ask(self)

    def is_left(self) -> bool:
        """Return whether a run leaves the point: a map that was asked for, of no loop, is another at its end."""
        asked = map(self._maps.__getitem__, self._asked & self._maps.keys())
        maps = [(ends, point) for ends, point in asked if not ends.cut]
        return any(is_left(self.plan, *one, self._onward(one[0].common_period(self.plan))) for one in maps)

    def _found(self, ends: Ends) -> OrbitPoint:
        orbit = self.point
        if not isinstance(orbit, PeriodicPoint):
            return OrbitSearch(self.plan, ends, self._onward(ends.common_period(self.plan)), self.ahead).point()
        of_orbit = {"memory": orbit.memory, "span": orbit.ticks, "integrated": True}
        whole = ends.map(self.plan, **of_orbit, slopes=self.course.slopes)
        notes = (orbit.note(self.plan.period),)
        return OrbitPoint(whole, 1, notes, memory=orbit.memory, ticks=orbit.ticks, integrated=True)

    def _onward(self, period: int) -> Onward:
        """Return the run on from the last start of a period of some base ticks before the operating point."""
        return self.course.onward(self.tick - self.tick % period)

    def _point_slopes(self, ends: Ends, point: OrbitPoint) -> tuple[PointSlopes | None, tuple[str, ...]]:
        """Return the derivatives of the operating point by the parameters, and a note where they are not known."""
        tick = point.map.tick
        blocks = ends.blocks(self.plan)[0]
        near_start = tick and not self.plan.schedule.phases
        near = slopes_near_start(self.plan, blocks, tick, point.rings) if near_start else None
        if near is not None or not tick:
            return near, ()
        whole = Ends((), ends.outputs, everything=True).map(self.plan, by_parameters=True, **point.where)
        at_rest = slopes_at_rest(whole)
        return at_rest, () if at_rest is not None else (_FIXED,)

    def loop(self, node: Endpoint, by_parameters: bool = False) -> OpenLoop:
        """Return the loop through an output, opened there; in continuous time if it lies among continuous blocks."""
        system = self.opened(node, by_parameters)
        if not any(part.any() for part in (system.map.parts()[1], system.map.parts()[3])):
            raise self.plan.graph.placed(no_gain(node)).error
        return system

    def opened(self, node: Endpoint, by_parameters: bool = False) -> OpenLoop:
        """Return what lies between an output and itself, opened there, if nothing returns too."""
        group = analog_group(self.plan, node)
        if group is not None:
            return self.analog_loop(group, [node], by_parameters)
        values = Ends((node,), (node,), cut=True).common_period(self.plan) // self.plan.stride(node)
        if values > MOST_VALUES:
            raise self.plan.graph.placed(too_many(node, values)).error
        whole = self.map([node], [node], cut=True, by_parameters=by_parameters)
        return of_wires(whole, self.plan.period, coarse_blocks(self.plan, node))

    def analog_loop(self, group: Group, nodes: Sequence[Endpoint], by_parameters: bool = False) -> OpenLoop:
        """Return the loop opened at wires among continuous blocks; raises `ModelError`."""
        if isinstance(self.point, PeriodicPoint):
            raise ModelError([self.plan.graph.placed(not_periodic(node)) for node in nodes])
        analog = analog_map(self.plan, self._onward(1), group, nodes)
        if by_parameters:
            ends = Ends((), tuple(nodes), everything=True)
            slopes, notes = self._point_slopes(ends, self.point_of(ends))
            exact = analog_map_at(self.plan, group, nodes, self.memory(), True, slopes)
            analog = replace(exact, notes=analog.notes + notes)
        between = replace(analog.between(), told=self.told)
        _, b, _, d = between.parts()
        alone = [node for i, node in enumerate(nodes) if not (b[:, i].any() or d[:, i].any())]
        if alone:
            raise ModelError([self.plan.graph.placed(not_within(self.plan, group, node)) for node in alone])
        return OpenLoop(between, continuous=True)


def linearised(plan: Plan, point: OperatingPoint = 0) -> Linearisation:
    """Return a plan about its state in a base tick, or about an orbit."""
    return Linearisation(plan, Course(plan), point)


class OperatingPoints:
    """The operating points of a plan an analysis may take, each looked for when it is wanted."""

    def __init__(
        self, plan: Plan, at: At = AUTO, progress: Progress | None = None, course: Course | None = None
    ) -> None:
        """Take a time, "settled", "periodic" or "auto" (else `ModelError`), and the plan's course if there is one."""
        self.plan, self.at, self._progress = plan, at, progress
        self.course = course or Course(plan)
        self._known = dict[str, Linearisation | ModelError]()
        self._starts = dict[int, Linearisation]()
        if at not in _WAYS:
            self._time = tick_of_time(plan, at)

    def answered(self, ask: Callable[[Linearisation], _Answer], first: int = 0) -> _Answer:
        """Return what is answered at the operating point, or at the first one that has an answer.

        A point that the run leaves counts where no later one has an answer. `first` is the base
        tick with which the search begins. Raises `ModelError`: that of the first point after the
        start where there is one, since a start may grow, be open or silent that a run leaves
        behind.
        """
        none: list[ModelError] = []  # where there is no such point
        refused: list[ModelError] = []
        left: list[Linearisation] = []
        for about in self._about(first):
            if not isinstance(about, Linearisation):
                none.append(about)
                continue
            try:
                answer = (replace(about, notes=(_after(about.told),)) if left else about).answer(ask)
            except ModelError as error:
                refused.append(error)
                continue
            if self.at not in (AUTO, SETTLED) or not about.is_left():
                return answer
            left.append(about)
        if left:
            return ask(replace(left[0], notes=(_LEFT,)))
        raise [*refused[1:], *refused, *none][0]

    def after_start(self, first: int) -> Linearisation:
        """Return the first operating point after the start that there is, or the start; raises `ModelError`."""
        about = [one for one in islice(self._about(first), 3) if isinstance(one, Linearisation)]
        return about[:2][-1] if about else self.answered(lambda one: one, first)

    def loop(self, node: Endpoint, by_parameters: bool = False, otherwise: "Otherwise | None" = None) -> OpenLoop:
        """Return the loop through an output at the operating point, or at the first one where it does not start up.

        At points after the start a loop that cannot be linearised there is what `otherwise` returns.
        Blocks that stand at a corner there have a note.
        """
        about, system = self.about_loop(node, by_parameters, otherwise)
        notes = about.corners_of(system, node)
        return system.noted(*notes) if notes else system

    def about_loop(
        self, node: Endpoint, by_parameters: bool = False, otherwise: "Otherwise | None" = None
    ) -> tuple[Linearisation, OpenLoop]:
        """Return the loop through an output as `loop` does, and what it is taken from."""
        about, (system,) = self.about_loops([node], by_parameters, otherwise)
        return about, system

    def about_loops(
        self,
        nodes: Sequence[Endpoint],
        by_parameters: bool = False,
        otherwise: "Otherwise | None" = None,
        joint: "Joint | None" = None,
    ) -> tuple[Linearisation, Sequence[OpenLoop]]:
        """Return the loops through some outputs at one point, each while the others are closed, and the point.

        Behind them is what is opened at all of them at once, where that is asked for as `joint`.

        A loop that makes growth itself may settle elsewhere. An oscillation that something else
        bounds, such as the range of a converter, does not make it stable: its verdict is that of
        the start.
        """
        starting: list[tuple[Linearisation, Sequence[OpenLoop]]] = []

        def loop(about: Linearisation, node: Endpoint) -> OpenLoop:
            try:
                system = about.loop(node, by_parameters)
            except ModelError:
                at_the_start = any(about is start for start in self._starts.values())
                through = otherwise(about, node) if otherwise and not at_the_start else None
                if through is None:
                    raise
                system = through
            if self.at == AUTO and not starts_up(system) and self._leaves(about, system, node):
                system = replace(system, map=replace(system.map, starting=True, notes=(STARTS_UP,)))
            return system

        def ask(about: Linearisation) -> tuple[Linearisation, Sequence[OpenLoop]]:
            if starting and about.at != SETTLED and any(map(makes_growth, starting[0][1])):
                return starting[0]
            systems = [loop(about, node) for node in nodes]
            systems += [joint(about, systems)] if joint else []
            if self.at == AUTO and any(map(starts_up, systems)):
                starting.append((about, systems))
                raise self.plan.graph.placed(no_gain(nodes[0])).error
            return about, systems

        try:
            return self.answered(ask)
        except ModelError:
            lasting = [one for one in starting if not any(system.map.starting for system in one[1])]
            end = self._known.get(_END)
            if not starting:
                with suppress(ModelError):  # what no later point closes may close for instants
                    if self.at == AUTO:
                        return self._linearisation(0, "", 0.0).answer(ask)
                raise
            if not lasting and isinstance(end, ModelError):
                raise end from None  # it starts up, and its run does not get to the end
            return (lasting or starting)[0]

    def _leaves(self, about: Linearisation, system: OpenLoop, node: Endpoint) -> bool:
        """Return whether a loop that moves on from the start, and looks the same, is another at the end of its run."""
        if system.continuous:  # linear blocks that are not driven are alike everywhere
            moves = any(node in of.group.nodes and (of.renewed or not of.exact) for of in self.plan.solvers)
        else:
            moves = not system.map.notes and bool(about.point_of(Ends((node,), (node,), cut=True)).later)
        if about.tick or not moves:
            return False
        try:
            last = self.plan.ticks()
            return last <= LONGEST and system.differs(self._there(_END).opened(node), FROZEN)
        except ModelError:  # there is no end, or no loop can be told there
            return False

    def _about(self, first: int) -> Iterator[Linearisation | ModelError]:
        if self.at != AUTO:
            yield self._one(str(self.at))
            return
        if first not in self._starts:
            self._starts[first] = replace(self._linearisation(first, "", 0.0), ahead=False)  # later points are closed
        yield self._starts[first]
        for way in (SETTLED, _END, PERIODIC):
            yield self._one(way)

    def _one(self, way: str) -> Linearisation | ModelError:
        """Return the linearisation at a point of a kind, or why there is none."""
        if way not in self._known:
            try:
                self._known[way] = self._found(way)
            except ModelError as error:
                self._known[way] = error
        return self._known[way]

    def _there(self, way: str) -> Linearisation:
        """Return the linearisation at a point of a kind; raises `ModelError`."""
        one = self._one(way)
        if isinstance(one, ModelError):
            raise one
        return one

    def _found(self, way: str) -> Linearisation:
        period = self.plan.period
        if way == SETTLED:
            tick = settled_tick(self.course, self._progress)
            return self._linearisation(tick, f"settled after {time_text(tick * period)}", SETTLED)
        if way == PERIODIC:
            return self._linearisation(periodic_point(self.course), "an orbit that repeats", PERIODIC)
        if way == _END:
            tick = self.plan.ticks()
            self.course.at(tick)
            return self._linearisation(tick, f"the end of the run, {time_text(tick * period)}", tick * period)
        return self._linearisation(self._time, "", self.at)

    def _linearisation(self, point: OperatingPoint, told: str, at: At) -> Linearisation:
        return Linearisation(self.plan, self.course, point, told, at)


Otherwise = Callable[[Linearisation, Endpoint], OpenLoop | None]
Joint = Callable[[Linearisation, Sequence[OpenLoop]], OpenLoop]
_LEFT = "the run does not end here, and what holds at its end is another: name a time, such as --at '1 s'"
_END = "end"
_WAYS = (AUTO, SETTLED, PERIODIC)


def _after(told: str) -> str:
    """Return the note on a point that is taken since the run leaves an earlier one."""
    return f"the run leaves its start, where this is another: this is about {told}"


def tick_of_time(plan: Plan, at: At) -> int:
    """Return the base tick of a time; raises `ModelError` for any other text."""
    try:
        return int(read_duration(at) * plan.schedule.base_rate)
    except Refusal as error:
        hint = f'write a time, as "20 ms", "{AUTO}", "{SETTLED}" or "{PERIODIC}"'
        raise Problem(message=str(error), key="at", got=str(at), hint=hint).error from None
