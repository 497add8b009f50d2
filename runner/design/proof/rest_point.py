"""The point of rest, or the orbit, of every sensor of a box, enclosed by Krawczyk's operator.

With the map F(x, q) of all that a graph remembers, a sensor q rests at x = F(x, q), which
`enclosed` encloses. Where carriers or switches come round after N periods, x has what is remembered
at the start of each of them, and F moves each of these by its own period:

    F(x_1, ..., x_N) = (F_N(x_N), F_1(x_1), ..., F_N-1(x_N-1))

so that an orbit is a point of rest of F, and one period after the other is enclosed (multiple shooting). It lies near
a polynomial c(q), the last of the steps

    c <- c + R (F(c, q) - c),   R near (I - J)^-1 in the middle of the box

F is that of ideal converters, without noise, with sources that are constant, or come round, from
the operating point on. It is of a tick in which all blocks compute, or of whole periods
(`rest_ticks`).
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.period_map import PeriodMap
from proofmass.runner.analysis.linearisation.rings import Entry, find_rings
from proofmass.runner.analysis.linearisation.seeds import HELD, at_place, held_in, place_of, put
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.derivatives.ball import Ball, UndecidedError, arb_of, double_of, enclosing
from proofmass.runner.derivatives.dual import SIGNALS, Dual, dual, plain, slopes_of
from proofmass.runner.derivatives.polynomial import PolynomialBall, model_of
from proofmass.runner.derivatives.taylor_model import TaylorModel, order_kept
from proofmass.runner.design.proof.about_rest import AboutRest
from proofmass.runner.design.proof.ball_ticks import RestTicks, advanced, with_balls
from proofmass.runner.design.proof.enclosed import Enclosed, RestPoint, balls_of, near_inverse
from proofmass.runner.design.proof.rest_sources import LATE, MOST_PERIODS, RestSources
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

_LONG = 1 << 16  # ticks of a run that does not settle
_NEWTON, _WIDENED, _NEAR = 12, 16, 1e-13  # steps at most, and part of a number that ends Newton's
_CLOSE, _LEAST = 1e-15, 1e-70  # reaches at least: part of a number, and beside zero
_FARTHEST = 1e30  # beyond which no reach is tried
_NOWHERE = "no point of rest is enclosed: something on the way does not settle, or bends too much"
_ROOM, _SPARE = 1.3, 1.15  # how much further than needed a reach is, at least
_MOST_NUMBERS = 256  # at the starts of all periods of an orbit: matrices are as large


class RestRun:
    """Points of rest or orbits of the sensors of a plan, as far as outputs depend on them."""

    def __init__(self, plan: Plan, outputs: Sequence[Endpoint], course: Course) -> None:
        """Raises `ModelError` where the plan does not settle or come round, counts on, or cannot be enclosed."""
        self._plan, self._outputs, self.course = plan, tuple(outputs), course
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
            options = {"memory": self._memory.copy(), "span": ticks, "rings": self._rings}
            self.entries, self._coefficients = self._numbers(ends.map(plan, **options))
            self.periods, counts = self._round()
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
            problem = replace(not_at_rest(what, self._signal), expected=f"at most {most} periods")
            raise self._plan.graph.placed(problem).error
        for periods in range(turn, most + 1, turn):
            moved = self._after(self._ticks, periods)
            if not (changed := self._unlike(self._memory, moved)):
                return periods, []
            counts = counts or changed
        return 1, counts

    def _unlike(self, begin: Memory, memory: Memory) -> list[str]:
        """Return the blocks whose counts, switches and coefficients are not those at the beginning of an orbit."""
        seeded, names = set(self.entries), sorted(self.upstream)
        before, after = (dict(self._rings.states_of(one, names)) for one in (begin, memory))
        pairs = {entry: (before[entry], after[entry]) for entry in before if entry not in seeded}
        return [entry[0] for entry, (a, b) in pairs.items() if a is not b and (isinstance(b, Dual) or a != b)]

    def image(self, plan: Plan, values: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Return F of some numbers, with directions, and the outputs; raises `UndecidedError`."""
        begin = self.memory_of(plan, values)
        engine = RestTicks(plan, begin.copy(), self.upstream, self._outputs, self.steps)
        images = list[Any]()
        for number in range(1, self.periods + 1):
            advanced(engine, self.tick + number * self._ticks)
            memory = engine.memory()
            images.append([held_in(memory, entry, self._rings) for entry in self.entries])
            if number < self.periods:
                self._put(memory, values, number)
        if changed := self._unlike(begin, engine.memory()):
            raise UndecidedError(f"{changed[0]} counts on")
        image = [value for one in (images[-1], *images[:-1]) for value in one]
        return image, [value for node in self._outputs for value in engine.recorded[node]]

    def memory_of(self, plan: Plan, values: Sequence[Any], seeded: bool = True) -> Memory:
        """Return the memory at the operating point with the first of some numbers, each of which has a direction.

        Coefficients are those of a plan, which may have other parameters.
        """
        memory, begun = self._memory.copy(), start(plan)
        for entry in self._coefficients:
            put(memory, place_of(memory, entry, self._rings), held_in(begun, entry, self._rings))
        self._put(memory, values, 0, seeded)
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

    def enclosed(self, parameters: Mapping[str, Any]) -> RestPoint:
        """Return where all sensors with such parameters rest; raises `UndecidedError` where that is not shown."""
        plan = with_balls(self._plan, parameters)
        if not self._comes_round(plan):
            raise UndecidedError("a source changes with time for some parameters")
        if not self.directions:
            empty = Enclosed.exact(np.zeros((0, 0)))
            return RestPoint([], np.zeros(0), empty.middle[0], empty, empty)
        middles = {
            name: PolynomialBall(TaylorModel.constant(double_of(value)[0])) for name, value in parameters.items()
        }
        centre, left = self._in_the_middle(with_balls(self._plan, middles))
        curve = balls_of(centre)
        for _ in range(order_kept(len(parameters)) if parameters else 0):
            image, _ = self.image(plan, curve)
            apart = model_of([[plain(x) - c] for x, c in zip(image, curve, strict=True)])
            steps = TaylorModel.constant(left) @ apart
            curve = [(PolynomialBall(steps[i, 0]) + c).middles for i, c in enumerate(curve)]
        return self._around(plan, curve, left)

    def _in_the_middle(self, plan: Plan) -> tuple[Array, Array]:
        """Return about where a sensor rests, by Newton's method, and R."""
        centre = np.array(self._start)
        sizes, before, left = np.abs(centre), np.full(len(centre), math.inf), np.eye(len(centre))
        for _ in range(_NEWTON):
            image, _ = self.image(plan, balls_of(centre))
            left = near_inverse(self._matrix(image))
            by = left @ np.array([double_of(plain(x))[0] for x in image] - centre)
            if not np.isfinite(by).all():
                break
            centre, sizes = centre + by, np.maximum(sizes, np.abs(by))
            if bool(((np.abs(by) <= _NEAR * sizes) | (np.abs(by) >= 0.5 * before)).all()):  # or rounding is left
                break
            before = np.abs(by)
        return centre, left

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

    def map_between(self, ends: Ends) -> OrbitPoint:
        """Return the map between some ends about the point of rest of the sensor as it is; raises `ModelError`."""
        return self.linearised(self._plan).point_of(ends)

    def _around(self, plan: Plan, curve: Sequence[Any], left: Array) -> RestPoint:
        image, _ = self.image(plan, curve)
        apart = [[plain(x) - c] for x, c in zip(image, curve, strict=True)]
        step = Enclosed.of_balls([apart])
        point = RestPoint(curve, np.zeros(len(curve)), left, step, step)
        for _ in range(_WIDENED):
            image, _ = self.image(plan, point.values)
            point = replace(point, matrix=Enclosed.of_balls([self._matrix(image)]))
            if _fits(point):
                return point
            for _ in range(_WIDENED):  # with these slopes
                if not bool((point.reach <= _FARTHEST).all()):
                    raise UndecidedError(_NOWHERE)
                if _fits(point):
                    break
                point = _wider(point)
        raise UndecidedError(_NOWHERE)

    def _matrix(self, image: Sequence[Any]) -> list[list[Any]]:
        keys = self.directions
        return [[plain(slopes.get(key, 0.0)) for key in keys] for slopes in (slopes_of(x, SIGNALS) for x in image)]

    @property
    def period(self) -> float:
        """Seconds after which all blocks compute together again."""
        return self._period * self._plan.period

    def value(self, plan: Plan) -> tuple[float, float]:
        """Return the first output of a plan with other parameters at rest, and what it may be off;
        raises `ModelError`.

        It is that of ideal converters.
        """
        own = RestRun.like(self, plan)
        rest = own._own_point()
        with enclosing():
            _, outputs = own.image(plan, rest.values)
            low, high = Ball(sum(arb_of(plain(value)) for value in outputs) / len(outputs)).ends()
        return 0.5 * low + 0.5 * high, high - low

    def _own_point(self) -> RestPoint:
        """Return where the sensor as it is rests; raises `ModelError`."""
        try:
            with enclosing():
                return self.enclosed({})
        except UndecidedError as error:
            raise self._plan.graph.placed(not_at_rest(str(error), self._signal)).error from None

    def linearised(self, plan: Plan) -> Linearisation:
        """Return a plan with other parameters about its own point of rest; raises `ModelError`."""
        own = RestRun.like(self, plan)
        rest = own._own_point()
        there = own.memory_of(plan, rest.centre.tolist(), seeded=False)
        told = "on an orbit" if self.orbit else "at rest"
        return AboutRest(
            plan, own.course, own.tick, told, memory_there=there, least=own._ticks * own.periods if self.orbit else 1
        )

    @classmethod
    def like(cls, other: "RestRun", plan: Plan) -> "RestRun":
        """Return points of rest of a plan with other parameters, begun where another begins."""
        own = object.__new__(cls)
        vars(own).update(vars(other) | {"_plan": plan})
        return own


def _fits(point: RestPoint) -> bool:
    return bool((point.needed() * _SPARE < point.reach).all())


def _wider(point: RestPoint) -> RestPoint:
    reach = np.maximum(_ROOM * point.needed(), point.reach)
    return replace(point, reach=reach + _CLOSE * np.abs(point.centre) + _LEAST)


def not_at_rest(what: str, signal: str) -> Problem:
    """Return the problem of an output for which no point of rest is enclosed."""
    return Problem(
        message=f"{what}: no point of rest of {signal} is proved",
        key=signal,
        hint="proofs are about the start of a run or a point of rest; `proofmass worst` searches at other points",
        path=("blocks", signal.rpartition(".")[0]),
    )
