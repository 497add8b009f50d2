"""The point of rest of every sensor of a box, enclosed by Krawczyk's operator.

With the map F(x, q) of all that a graph remembers, a sensor q rests at x = F(x, q). About any c, with R near
(I - dF/dx)^-1,

    |R (F(c, q) - c)| + |I - R (I - J)| r < r   for all J = dF/dx within r of c, and all q of the box

says that each q has one point of rest within r of c, entry by entry (Krawczyk, Computing 4, 1969, 187; Neumaier,
Interval Methods for Systems of Equations, section 5.1). Its derivatives by q follow from those of F:

    x_i = (I - J)^-1 F_i,   x_ij = (I - J)^-1 (second derivative of F(x(q), q) with x_ij = 0)

F is that of ideal converters, without noise, at all times after the operating point: what depends on time is refused.
It is a tick in which all blocks compute, or a whole period. Where a continuous group is not linear, its rates f are
zero if it rests, so that x + P f serves for any regular P.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import flint
import numpy as np

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import Linearisation
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.orbit_run import OrbitRun
from proofmass.runner.analysis.linearisation.rings import Entry, find_rings
from proofmass.runner.analysis.linearisation.seeds import place_of
from proofmass.runner.analysis.linearisation.settle import settled_tick
from proofmass.runner.derivatives.ball import BITS, Ball, UndecidedError, arb_of, ball
from proofmass.runner.derivatives.dual import Dual, dual, plain, slopes_of, value_of
from proofmass.runner.derivatives.dual_groups import DualAdvance
from proofmass.runner.derivatives.dual_plan import SIGNALS, dual_hold
from proofmass.runner.design.proof.ball_map import FIRST, SECOND, BallTicks, advanced, at_place, put, with_balls
from proofmass.runner.design.proof.enclosed import Enclosed
from proofmass.runner.host.arrays import Array
from proofmass.runner.plan.bindings import Binding, Tick, Time
from proofmass.runner.plan.memory import Memory
from proofmass.runner.plan.planned import Plan
from proofmass.runner.plan.solver import Solver
from proofmass.runner.reference.advance import Advance, Moment

_TIME, _LATEST = "time", 1e18  # direction of the time, and the last one, in seconds
_VARIED = -1  # direction of all that varies, so that converters do not round it
_NEWTON, _WIDENED = 12, 16  # steps at most
_CLOSE, _ROOM, _LEAST = 1e-15, 1.1, 1e-70  # of reaches: part of a number, part of itself, and beside zero


@dataclass(frozen=True)
class RestPoint:
    """Where the sensors of a box rest: within `reach` of `centre`, as `left`, `step` and `matrix` show."""

    centre: Array  # c
    reach: Array  # r
    left: Array  # R
    step: Enclosed  # F(c, q) - c, a column
    matrix: Enclosed  # J
    follows: Mapping[str, tuple[float, Array]] = field(
        default_factory=dict
    )  # parameters at c, and how x moves with them

    @cached_property
    def values(self) -> list[Any]:
        """All numbers that may be there, as balls."""
        ends = zip(self.centre.tolist(), self.reach.tolist(), strict=True)
        return [Ball(flint.arb(c) + flint.arb(0, r)) for c, r in ends]

    def as_data(self) -> dict[str, Any]:
        """Return what shows it as plain data, for certificates."""
        enclosed = {"step": self.step, "matrix": self.matrix}
        own = {"centre": self.centre, "reach": self.reach, "left": self.left}
        parts = own | {name: one.middle[0] for name, one in enclosed.items()}
        parts |= {f"{name}_radius": one.radius[0] for name, one in enclosed.items()}
        return {name: part.reshape(-1).tolist() if "step" in name else part.tolist() for name, part in parts.items()}

    def near(self, parameters: Mapping[str, Any]) -> list[Any]:
        """Return a point near that of rest for parameters; raises `UndecidedError` if it may lie beyond the reach."""
        moved = balls_of(self.centre)
        for name, (origin, slopes) in self.follows.items():
            moved = [x + (parameters[name] - origin) * slope for x, slope in zip(moved, slopes.tolist(), strict=True)]
        if not all(a.arb.contains(arb_of(plain(x))) for a, x in zip(self.values, moved, strict=True)):
            raise UndecidedError("the point of rest bends too much")
        return moved

    def holds(self, part: "RestPoint") -> bool:
        """Return whether the points of a part of the box lie within, so that they are the same."""
        return all(a.arb.contains(b.arb) for a, b in zip(self.values, part.values, strict=True))


class RestRun:
    """The points of rest of the sensors of a plan, as far as some outputs depend on them."""

    def __init__(self, plan: Plan, outputs: Sequence[Endpoint], course: Course) -> None:
        """Raises `ModelError` where the plan does not settle, counts on, or cannot be enclosed."""
        self._plan, self._outputs, self.course = plan, tuple(outputs), course
        ends = Ends((), self._outputs, everything=True)
        self.upstream, _ = ends.blocks(plan)
        solvers = [one for one in plan.solvers if self.upstream & set(one.group.blocks)]
        looped = any(one.group.guesses for one in solvers)
        if looped or any(node[0] in self.upstream for loop in plan.schedule.loops for node in loop.nodes):
            raise plan.graph.placed(not_at_rest("an algebraic loop has no enclosure", self._signal)).error
        self._period, settled = ends.common_period(plan), settled_tick(course)
        self.tick = settled + -settled % self._period
        self._onward = course.onward(self.tick)
        self._memory = self._onward.begin.copy()
        self.steps = dict[int, Array]()  # P of each group that is not linear
        linear = all(one.exact for one in solvers)
        for ticks in dict.fromkeys((1, self._period)):
            self._ticks = ticks
            self._rings = find_rings(plan, self.upstream, partial(self._after, ticks))
            options = {"memory": self._memory.copy(), "span": ticks, "rings": self._rings}
            self.entries: tuple[Entry, ...] = ends.map(plan, **options).states
            counts = self._counting()
            if not counts and (ticks == 1 or linear) and not (ticks == 1 < self._period and self._offsets()):
                break
        else:
            what = (
                f"{counts[0]} counts on" if counts else "a continuous part that is not linear lies among several rates"
            )
            raise plan.graph.placed(not_at_rest(what, self._signal)).error
        with flint.ctx.workprec(BITS):
            late = self._late(*self.image(plan, balls_of(np.array(self._start))))
        if late:
            raise plan.graph.placed(_depends_on_time(late, self._signal, self._clocks())).error

    def _after(self, ticks: int, times: int) -> Memory:
        return self._onward.at(self.tick + times * ticks)

    @property
    def _signal(self) -> str:
        return ".".join(self._outputs[0])

    @property
    def _start(self) -> list[float]:
        return [float(at_place(self._memory, place_of(self._memory, entry, self._rings))) for entry in self.entries]

    def _offsets(self) -> bool:
        return bool(self.upstream & self._plan.schedule.phases.keys())

    def _clocks(self) -> list[str]:
        """Return the blocks upstream that read the time."""
        functions = ((name, f) for name in sorted(self.upstream) for f in self._functions(name))
        return list(dict.fromkeys(n for n, f in functions if Time() in self._plan.bindings(n, f)))

    def _functions(self, name: str) -> list[str]:
        kind = type(self._plan.blocks[name])
        return [*kind.output_functions, *(f for f in ("update", "derivative") if f in kind.functions)]

    def _counting(self) -> list[str]:
        """Return the blocks whose counts and switches are not back after the ticks of the map."""
        once, twice = (self._after(self._ticks, n) for n in (0, 1))
        seeded = set(self.entries)
        before, after = (dict(self._rings.states_of(memory, sorted(self.upstream))) for memory in (once, twice))
        return [entry[0] for entry in before if entry not in seeded and before[entry] != after[entry]]

    def _late(self, image: Sequence[Any], outputs: Sequence[Any]) -> str:
        """Return what depends on time, "" if nothing does."""
        names = [".".join(entry[:2]) for entry in self.entries] + [self._signal] * len(outputs)
        slopes = (plain(slopes_of(value, SIGNALS).get(_TIME, 0.0)) for value in [*image, *outputs])
        return next((name for name, slope in zip(names, slopes, strict=True) if not arb_of(slope).is_zero()), "")

    def image(self, plan: Plan, values: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """Return F of some numbers, with their directions, and the outputs; raises `UndecidedError`."""
        begin = self.memory_of(values)
        engine = _RestTicks(plan, begin, self.upstream, self._outputs, self.steps)
        advanced(engine, begin.tick + self._ticks)
        memory = engine.memory()
        image = [at_place(memory, place_of(memory, entry, self._rings)) for entry in self.entries]
        return image, [value for node in self._outputs for value in engine.recorded[node]]

    def memory_of(self, values: Sequence[Any], seeded: bool = True) -> Memory:
        """Return the memory with some numbers in it, each of which has a direction."""
        memory = self._memory.copy()
        for entry, value in zip(self.entries, values, strict=True):
            seed = dual(0.0, {entry: 1.0}, SIGNALS) if seeded else 0.0
            put(memory, place_of(memory, entry, self._rings), value + seed)
        return memory

    def enclosed(self, parameters: Mapping[str, Any], within: RestPoint | None = None) -> RestPoint:
        """Return where all sensors with such parameters rest, `within` where those of a larger box do.

        Raises `UndecidedError` where that is not shown.
        """
        plan = with_balls(self._plan, {name: varied(plain(value)) for name, value in parameters.items()})
        centre = np.array(self._start if within is None else within.centre)
        if not len(centre):
            empty = Enclosed(np.zeros((1, 0, 0)), np.zeros((1, 0, 0)))
            return RestPoint(centre, centre, np.zeros((0, 0)), empty, empty)
        moved = math.inf
        for _ in range(_NEWTON):
            image, _ = self.image(plan, balls_of(centre))
            left = _near_inverse(self._matrix(image))
            by = left @ np.array([float(arb_of(plain(x)).mid()) for x in image] - centre)
            size = float(np.max(np.abs(by) / (np.abs(centre) + 1e-300)))
            if not math.isfinite(size) or size >= moved:
                break
            centre, moved = centre + by, size
        found = self._around(plan, centre, left)
        if within is not None and not within.holds(found):
            raise UndecidedError("a sensor rests elsewhere than its neighbours")
        return found

    def following(self, parameters: Mapping[str, Any]) -> RestPoint:
        """Return where all sensors with such parameters rest, and how that moves with them; raises `UndecidedError`."""
        rest = self.enclosed(parameters)
        middles = {name: float(arb_of(plain(value)).mid()) for name, value in parameters.items()}
        given = {name: dual(Ball(flint.arb(value)), {name: 1.0}, FIRST) for name, value in middles.items()}
        image, _ = self.image(with_balls(self._plan, given), balls_of(rest.centre))
        own = [slopes_of(value_of(value, SIGNALS), FIRST) for value in image]
        moves = {name: [float(arb_of(plain(of.get(name, 0.0))).mid()) for of in own] for name in given}
        return replace(
            rest, follows={name: (middles[name], rest.left @ np.array(move)) for name, move in moves.items()}
        )

    def begun(self, parameters: Mapping[str, Any], rest: RestPoint) -> tuple[Memory, Plan]:
        """Return the memory at rest, each number with a direction, and the plan with the parameters."""
        given = {name: varied(value) for name, value in parameters.items()}
        plan = with_balls(self._plan, given)
        return self.memory_of(self.point(plan, given, rest), seeded=False), plan

    def map_between(self, ends: Ends) -> OrbitPoint:
        """Return the map between some ends about the point of rest of the sensor as it is; raises `ModelError`."""
        return self.linearised(self._plan).point_of(ends)

    def _around(self, plan: Plan, centre: Array, left: Array) -> RestPoint:
        image, _ = self.image(plan, balls_of(centre))
        apart = [[plain(x) - c] for x, c in zip(image, centre.tolist(), strict=True)]
        step, reach = Enclosed.of_balls([apart]), np.zeros(len(centre))
        for _ in range(_WIDENED):
            point = RestPoint(centre, reach, left, step, step)
            image, outputs = self.image(plan, point.values)
            matrix = Enclosed.of_balls([self._matrix(image)])
            point = replace(point, matrix=matrix)
            needs = _needed(point)
            if bool((needs < reach).all()):
                if late := self._late(image, outputs):
                    raise UndecidedError(f"{late} depends on time")
                return point
            reach = np.maximum(_ROOM * needs, reach) + _CLOSE * np.abs(centre) + _LEAST
            if not np.isfinite(reach).all():
                break
        raise UndecidedError("no point of rest is enclosed: something on the way does not settle, or bends too much")

    def _matrix(self, image: Sequence[Any]) -> list[list[Any]]:
        return [[plain(slopes_of(value, SIGNALS).get(key, 0.0)) for key in self.entries] for value in image]

    def point(self, plan: Plan, parameters: Mapping[str, Any], rest: RestPoint) -> list[Any]:
        """Return the numbers of the point of rest, dual in the coordinates of which the parameters are.

        `plan` has these parameters. Raises `UndecidedError`.
        """
        values: list[Any] = list(rest.values)
        keys = sorted({i for value in parameters.values() for i in slopes_of(value, FIRST) if i != _VARIED})
        if not keys or not values:
            return values
        image, _ = self.image(plan, values)
        apart = _differences(self._matrix(image))
        own = [value_of(value, SIGNALS) for value in image]
        first = {i: _solved(apart, [plain(slopes_of(value, FIRST).get(i, 0.0)) for value in own]) for i in keys}
        values = [_jet(x, {i: (first[i][k], {}) for i in keys}, first, k) for k, x in enumerate(rest.values)]
        image, _ = self.image(plan, values)
        own = [value_of(value, SIGNALS) for value in image]
        second = {
            i: {
                j: _solved(apart, [slopes_of(slopes_of(v, FIRST).get(i, 0.0), SECOND).get(j, 0.0) for v in own])
                for j in keys
            }
            for i in keys
        }
        return [
            _jet(x, {i: (first[i][k], {j: second[i][j][k] for j in keys}) for i in keys}, first, k)
            for k, x in enumerate(rest.values)
        ]

    @property
    def period(self) -> float:
        """Seconds after which all blocks compute together again."""
        return self._period * self._plan.period

    def value(self, plan: Plan) -> tuple[float, float]:
        """Return the first output of a plan with other parameters at rest, and what it may be off; raises `ModelError`.

        It is that of ideal converters.
        """
        own = RestRun.like(self, plan)
        rest = own._own_point()
        with flint.ctx.workprec(BITS):
            _, outputs = own.image(plan, rest.values)
            low, high = Ball(arb_of(plain(outputs[0]))).ends()
        return 0.5 * low + 0.5 * high, high - low

    def _own_point(self) -> RestPoint:
        """Return where the sensor as it is rests; raises `ModelError`."""
        try:
            with flint.ctx.workprec(BITS):
                return self.enclosed({})
        except UndecidedError as error:
            raise self._plan.graph.placed(not_at_rest(str(error), self._signal)).error from None

    def linearised(self, plan: Plan) -> Linearisation:
        """Return a plan with other parameters about its own point of rest; raises `ModelError`."""
        own = RestRun.like(self, plan)
        rest = own._own_point()
        return _AtRest(
            plan, own.course, own.tick, "at rest", memory_there=own.memory_of(rest.centre.tolist(), seeded=False)
        )

    @classmethod
    def like(cls, other: "RestRun", plan: Plan) -> "RestRun":
        """Return the points of rest of a plan with other parameters, which begins where another one does."""
        own = object.__new__(cls)
        vars(own).update(vars(other) | {"_plan": plan})
        return own


@dataclass(frozen=True)
class _AtRest(Linearisation):
    """A plan about a memory at rest."""

    memory_there: Memory = field(kw_only=True)

    def memory(self) -> Memory:
        """Return the memory there."""
        return self.memory_there.copy()

    def _found(self, ends: Ends) -> OrbitPoint:
        return rest_map(self.plan, ends, self.course, self.memory_there)


def rest_map(plan: Plan, ends: Ends, course: Course, memory: Memory) -> OrbitPoint:
    """Return the map of a period between some ends about a memory at rest."""
    run = OrbitRun(plan, ends, course.onward(memory.tick))
    whole = ends.map(plan, memory=memory.copy(), span=run.ticks, rings=run.rings)
    return OrbitPoint(whole, 1, memory=memory, ticks=run.ticks, rings=run.rings)


class _RestTicks(BallTicks):
    """Ticks at any time after the operating point: the time has a direction of its own."""

    def __init__(
        self, plan: Plan, begin: Memory, blocks: Any, outputs: Sequence[Endpoint], steps: dict[int, Array]
    ) -> None:
        self._any_time = dual(ball(begin.tick * plan.period, _LATEST), {_TIME: 1.0}, SIGNALS)
        self._steps = steps
        super().__init__(plan, begin, blocks, (), outputs, False, False)

    def _advance(self, plan: Plan, solver: Solver, integrated: bool) -> Advance:
        number = plan.solvers.index(solver)
        return _RestAdvance(plan, solver, self._any_time, self._steps, number)

    def _getter(self, binding: Binding) -> Any:
        match binding:
            case Time():
                return lambda tick: self._any_time
            case Tick():
                return _counting
            case _:
                return super()._getter(binding)


def _counting(tick: int) -> Any:
    raise UndecidedError("it counts ticks, and has no point of rest")


class _RestAdvance(DualAdvance):
    """Moves the states of a group by its exact step where it is linear, and else by P f."""

    def __init__(self, plan: Plan, solver: Solver, time: Any, steps: dict[int, Array], number: int) -> None:
        super().__init__(plan, solver.group, False)
        self._time, self._steps, self._number, self._exact = time, steps, number, solver.exact

    def moved(self, moment: Moment) -> dict[str, Any]:
        """Return the states of the group's blocks one tick later."""
        moment = moment._replace(time=self._time)
        if self._exact:
            return super().moved(moment)
        group, states, wires = self.stages.group, moment.states, moment.wires
        now = [getattr(states[block], field) for block, field in group.states]
        point = [*now, *(wires[node] for node in group.inputs)]
        if self._number not in self._steps:
            self._steps[self._number] = self._step(moment, point)
        rates = self._rates(moment.constants, point, len(now), [], self._time)
        rows = self._steps[self._number].tolist()
        moved = [
            x + sum((p * rate for p, rate in zip(row, rates, strict=True)), 0.0)
            for x, row in zip(now, rows, strict=True)
        ]
        kinds = zip(group.kinds, now, moved, strict=False)
        return self.stages.states([after if kind is float else before for kind, before, after in kinds])

    def _step(self, moment: Moment, point: Sequence[Any]) -> Array:
        """Return P, a regular matrix of doubles: near phi(A T) T."""
        a, _, _ = self._linear(moment, [value_of(value, SIGNALS) for value in point])
        near = [[float(arb_of(plain(value)).mid()) for value in row] for row in a]
        unit = [[float(i == j) for j in range(len(a))] for i in range(len(a))]
        step = np.array(dual_hold(near, unit, self.period)[1])
        regular: Any = flint.arb_mat(step.tolist()).det()
        return step if np.isfinite(step).all() and not regular.contains(0) else self.period * np.eye(len(a))


def balls_of(values: Array) -> list[Any]:
    """Return numbers as exact balls."""
    return [Ball(flint.arb(value)) for value in values.tolist()]


def varied(value: Any) -> Any:
    """Return a parameter with a direction: what varies is never rounded by a converter."""
    return value if isinstance(value, Dual) else dual(value, {_VARIED: 1.0}, FIRST)


def _near_inverse(matrix: Sequence[Sequence[Any]]) -> Array:
    near = np.array([[float(arb_of(value).mid()) for value in row] for row in matrix])
    try:
        return np.asarray(np.linalg.inv(np.eye(len(near)) - near))
    except np.linalg.LinAlgError:
        raise UndecidedError("something on the way does not come to rest") from None


def _needed(point: RestPoint) -> Array:
    """Return |R step| + |I - R (I - J)| r, rounded up."""
    n = len(point.centre)
    left = Enclosed(point.left[None], np.zeros((1, n, n)))
    minus = Enclosed(-point.matrix.middle, point.matrix.radius).moved(np.eye(n))
    off = (Enclosed(-point.left[None], np.zeros((1, n, n))) @ minus).moved(np.eye(n))
    by = left @ point.step
    sizes = np.abs(by.middle) + by.radius
    return np.asarray((sizes[0, :, 0] + (np.abs(off.middle[0]) + off.radius[0]) @ point.reach) * (1.0 + 1e-12))


def _differences(matrix: Sequence[Sequence[Any]]) -> Any:
    return flint.arb_mat([[(i == j) - arb_of(value) for j, value in enumerate(row)] for i, row in enumerate(matrix)])


def _solved(matrix: Any, column: Sequence[Any]) -> list[Any]:
    """Return the solution of a system of balls; raises `UndecidedError` where there may be none."""
    try:
        rows = matrix.solve(flint.arb_mat([[arb_of(plain(value))] for value in column]), algorithm="precond").tolist()
    except ZeroDivisionError:
        raise UndecidedError("something on the way may not come to rest") from None
    return [Ball(row[0]) for row in rows]


def _jet(
    value: Any, slopes: Mapping[int, tuple[Any, Mapping[int, Any]]], first: Mapping[int, Sequence[Any]], k: int
) -> Any:
    """Return a number with its first and second derivatives."""
    inner = dual(value, {i: first[i][k] for i in slopes}, SECOND)
    return dual(inner, {i: dual(slope, dict(bends), SECOND) for i, (slope, bends) in slopes.items()}, FIRST)


def not_at_rest(what: str, signal: str) -> Problem:
    """Return the problem of an output for which no point of rest is enclosed."""
    return Problem(
        message=f"{what}: no point of rest of {signal} is proved",
        key=signal,
        hint="proofs are about the start of a run or a point of rest; `proofmass worst` searches at other points",
        path=("blocks", signal.rpartition(".")[0]),
    )


def _depends_on_time(name: str, signal: str, clocks: Sequence[str]) -> Problem:
    hold = f"--constant {clocks[0]}.output=0" if clocks else "--constant BLOCK.PORT=VALUE"
    return Problem(
        message=f"{signal} has no point of rest: what it depends on changes with time, at {name}",
        key=signal,
        got=", ".join(clocks),
        expected="sources that are constant once the loops have settled",
        hint=f"give sources constant values: {hold}",
        path=("blocks", clocks[0] if clocks else name),
    )
