"""Maps F of what is remembered at a point of rest or on an orbit, over a tick or whole periods.

F is that of ideal converters, without noise, with sources that are constant, or come round, from the operating point
on. Of what comes to no rest of its own, the `places`, F has how far it moves.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course, Onward
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry, find_rings
from proofmass.runner.analysis.linearisation.seeds import HELD, at_place, held_in, place_of, put
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.derivatives.ball import UndecidedError
from proofmass.runner.derivatives.dual import SIGNALS, Dual, dual, plain, slopes_of
from proofmass.runner.design.proof.ball_ticks import RestTicks, advanced
from proofmass.runner.design.proof.places import Around, Image, NeutralPlace, neutral
from proofmass.runner.design.proof.rest_sources import LATE, MOST_PERIODS, RestSources
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

_LONG = 1 << 16  # ticks of a run that does not settle
TIME_IS_UP = "the time is up"  # why a claim is open
_AT_ONCE = 16  # ticks between two looks at the clock
_MOST_NUMBERS = 256  # at the starts of all periods of an orbit: matrices are as large


class RestMaps:
    """Maps of what the sensors of a plan remember, as far as outputs depend on it."""

    entries: tuple[Entry, ...]  # what moves
    places: tuple[NeutralPlace, ...]  # what comes to no rest of its own

    def __init__(self, plan: Plan, outputs: Sequence[Endpoint], course: Course) -> None:
        """Raises `ModelError` where the plan does not settle or come round, counts on, or cannot be enclosed."""
        self._plan, self._outputs, self.course = plan, tuple(outputs), course
        self._is_over: Callable[[], bool] | None = None
        self._begun = plan  # whose run leads there, where the plan is that of another sensor
        ends = Ends((), self._outputs, everything=True)
        self.upstream, _ = ends.blocks(plan)
        solvers = [one for one in plan.solvers if self.upstream & set(one.group.blocks)]
        looped = any(one.group.guesses for one in solvers)
        if looped or any(node[0] in self.upstream for loop in plan.schedule.loops for node in loop.nodes):
            raise plan.graph.placed(not_at_rest("an algebraic loop has no enclosure", self._signal)).error
        self._sources, self._period = RestSources(plan, self.upstream), ends.common_period(plan)
        self._sources.check(self._signal, self._period, int(LATE / plan.period))
        settled = self._near_rest()
        self.tick = settled + -settled % self._period
        self._onward = course.onward(self.tick)
        self._memory = self._onward.begin.copy()
        self.steps = dict[int, Array]()  # P of each group that is not linear
        self._sources.check(self._signal, self._period, self.tick)
        moving = self._sources.moving(plan, self.tick * plan.period)
        linear, counts = all(one.exact for one in solvers), list[str]()
        for ticks in dict.fromkeys((self._period, 1)):  # a period is that of the sensor itself
            self._ticks, self.is_exact = ticks, linear and ticks == self._period
            self._rings = find_rings(plan, self.upstream, partial(self._after, ticks))
            of_period = self._map(ends, self._memory)
            self.entries, self._coefficients = self._numbers(of_period)
            self.places, self._along = (), np.zeros((len(self.entries), 0))
            self.periods, counts = self._round()
            if self.periods == 1 and self._find_places(ends, of_period):
                counts = self._unlike(self._memory, self._after(ticks, 1))
            rests = self.is_exact or (ticks == 1 and not moving)
            if not counts and rests and not (ticks == 1 < self._period and self._offsets()):
                break
        else:
            beside = "moves with time" if moving else "lies among several rates"
            what = f"{counts[0]} counts on" if counts else f"a continuous part that is not linear {beside}"
            raise plan.graph.placed(not_at_rest(what, self._signal)).error
        self.orbit = ticks * self.periods * plan.period if moving or self.periods > 1 else 0.0  # s
        ramps = [node for one in solvers for node in one.group.ramps]
        if self.orbit and ramps:
            what = f"{'.'.join(ramps[0])} moves a continuous part between ticks"
            raise plan.graph.placed(not_at_rest(what, self._signal)).error
        self._check_places()

    def _check_places(self) -> None:
        """Raise `ModelError` where a place moves on that numbers follow."""
        later = self._after(self._ticks, 1)
        for place in self.places:
            moved = place.passed(held_in(later, place.entry, self._rings) - place.nominal)
            try:
                place.check(abs(moved))
            except UndecidedError as error:
                slow = [one.entry[0] for one in self.places if not one.turns and one is not place]
                problem = not_at_rest(str(error), self._signal)
                hint = " ".join(f'--constant "{name}.output=VALUE"' for name in slow)
                problem = replace(problem, hint=f"hold what learns slowly: {hint}") if slow else problem
                raise self._plan.graph.placed(problem).error from None

    def _map(self, ends: Ends, memory: Memory) -> PeriodMap:
        return ends.map(self._plan, memory=memory.copy(), span=self._ticks, rings=self._rings)

    def _numbers(self, of_period: PeriodMap) -> tuple[tuple[Entry, ...], tuple[Entry, ...]]:
        """Return what moves, and coefficients, which stay as they are from the start of a run on.

        Counts nothing but counts drives do not move in this sense: they have to come round exactly.
        """
        begun, states, a = start(self._plan), of_period.states, of_period.parts()[0]
        now = [held_in(self._memory, entry, self._rings) for entry in states]
        counts = {i for i, value in enumerate(now) if type(value) is int}
        while driven := {i for i in counts if not counts.issuperset(np.flatnonzero(a[i]).tolist())}:
            counts -= driven
        stay = set(np.flatnonzero((a == np.eye(len(a))).all(axis=1)).tolist())
        coefficients = [
            entry
            for i, entry in enumerate(states)
            if i in stay and entry[2] != HELD and entry[:2] not in self._rings.of
            if held_in(begun, entry, self._rings) == now[i]
        ]
        moving = (entry for i, entry in enumerate(states) if i not in counts and entry not in coefficients)
        return tuple(moving), tuple(coefficients)

    def _find_places(self, ends: Ends, of_period: PeriodMap) -> bool:
        """Take the places of a period from what moves, and go to their starts where nothing follows them."""
        of_entries = [of_period.states.index(entry) for entry in self.entries]
        rows = np.ix_(of_entries, of_entries)
        chosen, along = neutral(of_period.parts()[0][rows])
        around = Around(
            self.entries,
            self._memory,
            self._rings,
            lambda memory: Onward(self.course, memory).at(self.tick + self._ticks),
            start(self._plan),
            lambda memory: self._map(ends, memory).parts()[0][rows],
        )
        others = tuple(entry for i, entry in enumerate(self.entries) if i not in chosen)
        curves = [dict(zip(others, one, strict=True)) for one in along.T.tolist()]
        for k, own in zip(chosen, curves, strict=True):
            place, memory = around.place(self.entries[k], {**own, self.entries[k]: 1.0})
            self.places = (*self.places, place)
            around = replace(around, memory=memory)
        self.entries, self._along, self._memory = others, along, around.memory
        self._onward = Onward(self.course, self._memory)
        return bool(chosen)

    def _near_rest(self) -> int:
        """Return a tick from which the point of rest is looked for: where a converter dithers, that of a later time."""
        try:
            return settled_tick(self.course)
        except ModelError as error:
            tick = min(self._plan.ticks(), _LONG)
            try:
                self.course.at(tick)
            except ModelError:
                raise error from None
            return tick

    def _after(self, ticks: int, times: int) -> Memory:
        return self._onward.at(self.tick + times * ticks)

    @property
    def _signal(self) -> str:
        return ".".join(self._outputs[0])

    @property
    def _start(self) -> list[float]:
        memories = [self._after(self._ticks, number) for number in range(self.periods)]
        return [float(held_in(m, entry, self._rings)) for m in memories for entry in self.entries]

    def _offsets(self) -> bool:
        return bool(self.upstream & self._plan.schedule.phases.keys())

    def _round(self) -> tuple[int, list[str]]:
        """Return after how many periods sources, counts and switches come round, or the blocks that do not."""
        turn, most, counts = 1, 1, list[str]()
        if self.is_exact:
            turn = self._sources.turn(self._plan, self._ticks, self.tick)
            most = min(MOST_PERIODS, _MOST_NUMBERS // max(1, len(self.entries)))
        if turn > most:
            what = f"sources come round after {turn} periods, with {len(self.entries)} numbers in each"
            what = f"{len(self.entries)} numbers move in a period" if turn == 1 else what
            expected = f"at most {_MOST_NUMBERS} numbers" if turn == 1 else f"at most {most} periods"
            problem = replace(not_at_rest(what, self._signal), expected=expected)
            raise self._plan.graph.placed(problem).error
        for periods in range(turn, most + 1, turn):
            moved = self._after(self._ticks, periods)
            if not (changed := self._unlike(self._memory, moved)):
                return periods, []
            counts = counts or changed
        return 1, counts

    def _unlike(self, begin: Memory, memory: Memory) -> list[str]:
        """Return the blocks whose counts, switches and coefficients are not those at the beginning of an orbit."""
        seeded, names = {*self.entries, *(p.entry for p in self.places)}, sorted(self.upstream)
        before, after = (dict(self._rings.states_of(one, names)) for one in (begin, memory))
        pairs = {entry: (before[entry], after[entry]) for entry in before if entry not in seeded}
        return [entry[0] for entry, (a, b) in pairs.items() if a is not b and (isinstance(b, Dual) or a != b)]

    def image(self, plan: Plan, values: Sequence[Any], places: Sequence[Any] = (), seeded: bool = True) -> Image:
        """Return F of some numbers, with directions, and the outputs; raises `UndecidedError`."""
        begin = self.memory_of(plan, values, places, seeded)
        engine = RestTicks(plan, begin.copy(), self.upstream, self._outputs, self.steps)
        images = list[Any]()
        for number in range(1, self.periods + 1):
            self._advance(engine, self.tick + number * self._ticks)
            memory = engine.memory()
            images.append([held_in(memory, entry, self._rings) for entry in self.entries])
            if number < self.periods:
                self._put(memory, values, number, seeded)
        if changed := self._unlike(begin, engine.memory()):
            raise UndecidedError(f"{changed[0]} counts on")
        image = [value for one in (images[-1], *images[:-1]) for value in one]
        memory = engine.memory()
        passed = [
            place.passed(held_in(memory, place.entry, self._rings) - value)
            for place, value in zip(self.places, places, strict=True)
        ]
        return Image(image, [value for node in self._outputs for value in engine.recorded[node]], passed)

    def _advance(self, engine: RestTicks, last: int) -> None:
        while engine.memory().tick < last:
            if self._is_over is not None and self._is_over():
                raise UndecidedError(f"{TIME_IS_UP} in a period of {self._ticks:,} ticks")
            advanced(engine, min(last, engine.memory().tick + _AT_ONCE))

    @contextmanager
    def until(self, is_over: Callable[[], bool]) -> Iterator[None]:
        """Raise `UndecidedError` in what is asked for meanwhile once the time is over."""
        self._is_over = is_over
        try:
            yield
        finally:
            self._is_over = None

    def memory_of(self, plan: Plan, values: Sequence[Any], places: Sequence[Any] = (), seeded: bool = True) -> Memory:
        """Return the memory at the operating point with the first of some numbers, each of which has a direction.

        Coefficients are those of a plan, which may have other parameters.
        """
        memory, begun = self._memory.copy(), start(plan)
        for entry in self._coefficients:
            put(memory, place_of(memory, entry, self._rings), held_in(begun, entry, self._rings))
        self._put(memory, values, 0, seeded)
        for place, value in zip(self.places, places, strict=True):
            seed = dual(0.0, {place.entry: 1.0}, SIGNALS) if seeded else 0.0
            put(memory, place_of(memory, place.entry, self._rings), value + seed)
        return memory

    @property
    def directions(self) -> list[Any]:
        """The directions of all numbers, period by period."""
        return [(number, entry) for number in range(self.periods) for entry in self.entries]

    def _part(self, values: Sequence[Any], number: int) -> Sequence[Any]:
        """Return those of some numbers that are there at the start of a period."""
        return values[number * len(self.entries) : (number + 1) * len(self.entries)]

    def _put(self, memory: Memory, values: Sequence[Any], number: int, seeded: bool = True) -> None:
        """Put those of some numbers into a memory that are there at the start of a period."""
        for entry, value in zip(self.entries, self._part(values, number), strict=True):
            seed = dual(0.0, {(number, entry): 1.0}, SIGNALS) if seeded else 0.0
            put(memory, place_of(memory, entry, self._rings), value + seed)

    def _slopes(self, image: Image) -> list[list[Any]]:
        """Return the slopes of all that moves, and of what passes by each place, by both."""
        keys = [*self.directions, *(place.entry for place in self.places)]
        each = (slopes_of(x, SIGNALS) for x in (*image.after, *image.passed))
        return [[plain(slopes.get(key, 0.0)) for key in keys] for slopes in each]

    def _comes_round(self, plan: Plan) -> bool:
        """Return whether the sources of a plan of other parameters come round with the orbit."""
        turn = self._sources.turn(plan, self._ticks, self.tick)
        return turn > 0 and self.periods % turn == 0

    def on_the_way(self, values: Sequence[Any], last: int) -> Iterator[tuple[int, Sequence[Any]]]:
        """Yield the ticks before the last one at which it is known where the sensors are, with the numbers there."""
        for number, tick in enumerate(range(self.tick + self._ticks, last, self._ticks), 1):
            yield tick, self._part(values, number % self.periods)

    def hold(self, memory: Memory, values: Sequence[Any]) -> None:
        """Put a memory after a tick back to rest, with the slopes that it has."""
        for entry, value in zip(self.entries, values, strict=True):
            place = place_of(memory, entry, self._rings)
            put(memory, place, value + dual(0.0, slopes_of(at_place(memory, place), SIGNALS), SIGNALS))

    @property
    def ranges(self) -> list[Range]:
        """The ranges of all places."""
        return [p.range for p in self.places]

    def _matrix(self, image: Sequence[Any]) -> list[list[Any]]:
        keys = self.directions
        return [[plain(slopes.get(key, 0.0)) for key in keys] for slopes in (slopes_of(x, SIGNALS) for x in image)]

    @property
    def period(self) -> float:
        """Seconds after which all blocks compute together again."""
        return self._period * self._plan.period


def not_at_rest(what: str, signal: str) -> Problem:
    """Return the problem of an output for which no point of rest is enclosed."""
    return Problem(
        message=f"{what}: no point of rest of {signal} is proved",
        key=signal,
        hint="proofs are about the start of a run or a point of rest; `proofmass worst` searches at other points",
        path=("blocks", signal.rpartition(".")[0]),
    )
