"""Subjects of claims, in balls, at the start of a run or at rest.

A path is the map from one wire to another over a period, for an input that is the same in all of
it.

    x[n+1] = A x[n] + B u,   y = C x[n] + D u

B and D are sums over the values of the input in a period, C and D means over those of the output:
as the scale factor has them. A response has all values as they are.

The value of an output at rest is the scale factor of a map from an input of one. About a point c(q)
near the point of rest x, with J and C for all that lies between them,

    x - c = J (x - c) + (F(c, q) - c),   y = y(c, q) + C (x - c)

as the mean of derivatives on the way from c to x is one of J's. So y = D + C (I - A)^-1 B with A =
J, B = F(c, q) - c and D = y(c, q). c moves with the parameters as the point of rest does at the
centre of the box, so that B is small. All that the output depends on is in A, also what B does not
reach: it has to decay. Where F is not a period of the sensor itself, the map of that period stands
beside it in A, which then says that the sensor stays at rest.

Noise is the map from its sources to one output over a period:

    x[n+1] = A x[n] + B w[n],   y[n] = C x[n] + D w[n]

w are independent numbers with a variance of one, and y the values of the output in a period,
divided by the square root of their number: the mean square of the output is that of all of y. On an
orbit a period is the whole of it, so that this is the mean over the orbit of the variance.

A loop among continuous blocks is opened at a wire between them: x' = A x + B u, y = C x. The rates
of its group are called with balls for the parameters of the blocks, and with dual numbers on them,
as a tick is. What discrete blocks give is held, so that loops through them are open: those of
`margins` at such a wire.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import flint

from proofmass.blocks.declaration.problem import ModelError, Problem, problem_of_output
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.decisions.truths import decided_by_noise
from proofmass.runner.analysis.linearisation.analog_loop import analog_map, analog_rates
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints, linearised
from proofmass.runner.analysis.linearisation.map_changes import change_between
from proofmass.runner.analysis.linearisation.orbit import SAME, OrbitPoint
from proofmass.runner.analysis.linearisation.steady_state import SteadyState
from proofmass.runner.analysis.noise.budget import silence
from proofmass.runner.analysis.noise.grid_errors import errors_about
from proofmass.runner.analysis.noise.noise_map import noise_map, variance
from proofmass.runner.analysis.response.response import response_of_map
from proofmass.runner.derivatives.ball import Ball, UndecidedError, ball
from proofmass.runner.derivatives.dual import SIGNALS, slopes_of, value_of
from proofmass.runner.derivatives.dual_noise import NoisyTicks, noise_blocks
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.design.proof.ball_map import (
    MOST_STATES,
    MOST_VALUES,
    BallMap,
    BallRun,
    ChangesLaterError,
    Kept,
    MatrixRows,
    Starting,
    StartingLoop,
    at_start,
    changes_later,
    states_between,
    too_large,
)
from proofmass.runner.design.proof.ball_ticks import BallTicks, advanced, with_balls
from proofmass.runner.design.proof.enclosed import RestPoint
from proofmass.runner.design.proof.rest_maps import not_at_rest
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

_ALIKE = "a way that is the same in each period from the start of the run"
_MOST_ENDS = 512  # random numbers and values of the output in a period
_UNIFORM = 1.0 + 1e-9  # most of a size that counts as uniform over a step
_SAME_LATER = "a loop that is the same later"


class StartingPath(Starting):
    """The way from one wire to another at the start of a run."""

    def __init__(self, plan: Plan, source: Endpoint, target: Endpoint, rest: RestRun | None = None) -> None:
        """Raises `ModelError` where the graph changes after the start, or has too many states."""
        ends, way = Ends((source,), (target,)), f"the way from {'.'.join(source)} to {'.'.join(target)}"
        self._point: OrbitPoint = at_start(plan, ends) if rest is None else rest.map_between(ends)
        later = self._point.map.tick or (self._point.moves and not _answers_at_start(plan, source, target))
        if rest is None and later:
            raise changes_later(plan, way, target, _ALIKE)
        order = self._point.map.between().order
        if order > MOST_STATES:
            raise too_large(plan, f"{way} has {order} states", target, MOST_STATES)
        self._run = BallRun(plan, ends, self._point, rest)
        self.period, self.values = self._point.map.period, 1

    def _seen(self, rows: MatrixRows, order: int) -> MatrixRows:
        """Return the map for an input that stays as it is, to the mean of the output."""
        unit, part = ball(1.0, 1.0), ball(1.0, 1.0) / (len(rows) - order)
        inner = [[*row[:order], _sum(row[order:], unit)] for row in rows]
        below = [_sum([row[place] for row in inner[order:]], part) for place in range(order + 1)]
        return [*inner[:order], below]


class StartingResponse(StartingPath):
    """The response from one wire to another at the start of a run, at all frequencies.

    With p values of the input in a period, and r of the output, the gain at a frequency is o H i /
    r, with weights o and i of size 1: at most sqrt(p / r) times the norm of H.
    """

    def __init__(self, plan: Plan, source: Endpoint, target: Endpoint, rest: RestRun | None = None) -> None:
        """Raises `ModelError` where the graph changes after the start, has too many states, or nothing comes out."""
        super().__init__(plan, source, target, rest)
        if self._point.moves:
            raise changes_later(plan, f"the way from {'.'.join(source)} to {'.'.join(target)}", target, _ALIKE)
        response_of_map(plan, source, target, self._point.map)
        size = max(len(self._point.map.inputs), len(self._point.map.outputs))
        if size > MOST_VALUES:
            has = f"a wire of the way to {'.'.join(target)} has {size} values in a period"
            raise too_large(plan, has, target, MOST_VALUES)
        self.values = size

    def _seen(self, rows: MatrixRows, order: int) -> MatrixRows:
        inputs, outputs = len(rows[0]) - order, len(rows) - order
        part = Ball((flint.arb(inputs) / outputs).sqrt())
        size = max(inputs, outputs)
        wide = [[*row, *[0.0] * (size - inputs)] for row in rows]
        below = [[value * part for value in row] for row in wide[order:]]
        return [*wide[:order], *below, *[[0.0] * (order + size) for _ in range(size - outputs)]]


def _answers_at_start(plan: Plan, source: Endpoint, target: Endpoint) -> bool:
    """Return whether the scale factor is that of the start, though the graph moves on."""

    def ask(about: Linearisation) -> bool:
        SteadyState(plan, about.map([source], [target, source], everything=True).seen(), target)
        return not about.told

    return OperatingPoints(plan).answered(ask)


def _sum(values: Sequence[Any], part: Any) -> Any:
    """Return a sum of numbers times a part: 0.0 where each of them is."""
    return sum((value * part for value in values), 0.0)


class RestingOutput(Starting):
    """An output of sensors that rest: the map about a curve of their points of rest, over any box of parameters."""

    def __init__(self, plan: Plan, target: Endpoint, rest: RestRun) -> None:
        """Raises `ModelError` where the output depends on too many states."""
        most = MOST_STATES if rest.is_exact else MOST_STATES // 2
        if len(rest.directions) > most:
            raise too_large(plan, f"{'.'.join(target)} depends on {len(rest.directions)} states", target, most)
        self._plan, self._rest = plan, rest
        ends = Ends((), (target,), everything=True)
        self._period_run = None if rest.is_exact else BallRun(plan, ends, rest.map_between(ends), rest)
        self.period, self.values = rest.period, 1

    def map(self, parameters: Mapping[str, Any], kept: Kept | None = None) -> BallMap:
        """Return the map for parameters that hold polynomials.

        Raises `UndecidedError` where no point of rest is enclosed, or a block decides differently
        within the box.
        """
        rest, plan = self._rest.enclosed(parameters), with_balls(self._plan, parameters)
        image, outputs, _ = self._rest.image(plan, rest.curve)
        around, output_around, _ = self._rest.image(plan, rest.values)
        steps = [value_of(value, SIGNALS) - c for value, c in zip(image, rest.curve, strict=True)]
        rows = [[*self._slopes(value), step] for value, step in zip(around, steps, strict=True)]
        slopes = [_mean(column) for column in zip(*map(self._slopes, output_around), strict=True)]
        rows.append([*slopes, _mean([value_of(value, SIGNALS) for value in outputs])])
        order = len(steps)
        reached = [[*row[:-1], 1.0] for row in rows]
        kept = Kept(tuple(states_between(reached, order)), (0,), (0,), rest)
        places = [*kept.states, order]
        rows, period = [[rows[i][j] for j in places] for i in places], self._period(parameters, rest)
        beside, empty = [0.0] * len(period), [0.0] * len(places)
        return BallMap(
            len(beside) + len(kept.states), [[*r, *empty] for r in period] + [[*beside, *r] for r in rows], kept
        )

    def _period(self, parameters: Mapping[str, Any], rest: RestPoint) -> list[list[Any]]:
        """Return the map of a period of the sensor at rest where F is another one, else nothing."""
        if self._period_run is None:
            return []
        rows, order = self._period_run.rows(parameters, rest)
        return [row[:order] for row in rows[:order]]

    def _slopes(self, value: Any) -> list[Any]:
        slopes = slopes_of(value, SIGNALS)
        return [slopes.get(key, 0.0) for key in self._rest.directions]


def _mean(values: Sequence[Any]) -> Any:
    return sum(values, 0.0) * Ball(1 / flint.arb(len(values))) if len(values) > 1 else values[0]


class StartingNoise(Starting):
    """The way of noise to an output at the start of a run: in tick 0 processes start, so that it is a period later."""

    def __init__(self, plan: Plan, target: Endpoint, rest: RestRun | None = None) -> None:
        """Raises `ModelError` where the sources are not known without a run, or are too many."""
        way = f"the way of noise to {'.'.join(target)}"
        first = Ends((), (target,), noise=noise_blocks(plan)).common_period(plan)
        about = linearised(plan, first) if rest is None else rest.linearised(plan)
        noisy = noise_at(about, [target])
        bits = [name for name, own in noisy.items() if own or name in plan.digital]
        bits += decided_by_noise(plan, target, about.tick, {})
        if bits:
            raise plan.graph.placed(_decides(target, bits)).error
        ends = Ends((), (target,), noise=noisy)
        point = at_start(plan, ends, first) if rest is None else about.point_of(ends)
        if rest is None and point.map.tick != first:
            raise changes_later(plan, way, target)
        sizes = errors_about(about, ends)[0].sizes
        if uneven := sorted(name for (name, _), size in sizes.items() if size > _UNIFORM):
            raise plan.graph.placed(_decides(target, uneven)).error
        between = noise_map(point.map, target)
        if between.settles and not any(between.mean_squares):
            raise silence(about, target, len(between.sources), noisy)
        size = max(len(point.map.inputs), len(point.map.outputs))
        if point.map.order > MOST_STATES or size > _MOST_ENDS:
            has = f"{way} has {point.map.order} states and {size} random numbers or values in a period"
            raise too_large(plan, has, target, f"{MOST_STATES} states and {_MOST_ENDS} numbers")
        self._run = _NoiseRun(plan, ends, point, rest)
        self.period, self.values = point.map.period, 1


class _NoiseRun(BallRun):
    """A period whose random numbers and errors of quantisers have directions."""

    def rows(self, parameters: Mapping[str, Any], rest: RestPoint | None = None) -> tuple[MatrixRows, int]:
        """Return the map of all states from sources of variance one to a part of the rms, and how many these are."""
        rows, order = super().rows(parameters, rest)
        part = Ball(1 / flint.arb(len(rows) - order).sqrt())
        twelfth = Ball(1 / flint.arb(12).sqrt())
        weights = [1.0] * order + [1.0 if variance(name) == 1.0 else twelfth for _, name, _ in self._sources]
        scaled = [[value * weight for value, weight in zip(row, weights, strict=True)] for row in rows]
        return scaled[:order] + [[value * part for value in row] for row in scaled[order:]], order

    def _begin(self, plan: Plan) -> Memory:
        engine = BallTicks(plan, start(plan), self._blocks, (), (), False, False)
        advanced(engine, self._point.map.tick)
        return engine.memory()

    def _engine(self, plan: Plan, begin: Memory) -> DualTicks:
        noisy = self._ends.noise
        return _NoisyBallTicks(plan, begin, self._blocks, (), self._ends.outputs, False, False, noise=noisy)

    def _columns(self, engine: DualTicks) -> list[Any]:
        self._sources = sorted(engine.sources)
        return [*self._sources]


class _NoisyBallTicks(BallTicks, NoisyTicks):
    """Ticks of balls with a direction for each source."""

    def _same(self, before: Any, value: Any) -> bool:
        """Return whether two numbers are alike to the last digit: balls cannot say so."""
        return repr(before) == repr(value)


def _decides(target: Endpoint, blocks: Sequence[str]) -> Problem:
    return problem_of_output(
        target,
        message=f"the noise of {'.'.join(target)} is that of a run: this has no proof",
        got=", ".join(blocks),
        expected="sources that do not depend on decisions of one bit, on fixed point or on words of few bits",
        hint="search with `proofmass worst`",
    )


class StartingRates(StartingLoop):
    """A loop in continuous time at the start of a run, or at rest: its rates over any box of parameters."""

    def __init__(self, plan: Plan, group: Group, node: Endpoint, rest: RestRun | None, at_start: bool) -> None:
        """Take the loop of a group; with `at_start` it may change after tick 0.

        Raises `ModelError` where margins are not those of the start, or cannot be linearised.
        """
        signal = ".".join(node)
        if rest is not None and (rest.orbit or rest.places):
            raise plan.graph.placed(not_at_rest("a loop in continuous time changes along an orbit", signal)).error
        about = linearised(plan) if rest is None else rest.linearised(plan)
        try:
            between = about.loop(node).map
        except ModelError as error:
            raise error if rest is not None else ChangesLaterError(error.problems) from None
        if rest is None and not at_start:
            whole = analog_map(plan, about.course.onward(0), group, [node])
            if any(change_between(whole, after) > SAME for after in whole.later):
                raise changes_later(plan, f"the loop through {signal}", node, _SAME_LATER)
        if between.order > MOST_STATES:
            raise too_large(plan, f"the loop through {signal} has {between.order} states", node, MOST_STATES)
        self._run = _RateRun(plan, group, node, rest)
        self.period, self.values = 0.0, 1


class _RateRun(BallRun):
    """The rates of a group in balls."""

    def __init__(self, plan: Plan, group: Group, node: Endpoint, rest: RestRun | None) -> None:
        self._plan, self._group, self._node, self._rest = plan, group, node, rest

    def rows(self, parameters: Mapping[str, Any], rest: RestPoint | None = None) -> tuple[MatrixRows, int]:
        """Return [A B; C D] for parameters that hold balls, and the number of states; raises `UndecidedError`."""
        plan, memory = self._there(parameters, rest)
        try:
            moving, rates = analog_rates(plan, self._group, [self._node], memory)
        except TickError as error:
            raise UndecidedError(f"{error.at}: {error.__cause__ or error.value}") from error
        columns = (*moving, len(self._group.states))
        return [[slopes_of(rate, SIGNALS).get(key, 0.0) for key in columns] for rate in rates], len(moving)
