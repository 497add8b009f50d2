"""The map from sources of noise to one output over a period in balls.

    x[n+1] = A x[n] + B w[n],   y[n] = C x[n] + D w[n]

w are independent numbers with a variance of one, and y the values of the output in a period, divided by the square root
of their number: the mean square of the output is that of all of y.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import flint

from proofmass.blocks.declaration.problem import Problem
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.decisions.truths import decided_by_noise
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.map_blocks import common_period
from proofmass.runner.analysis.noise.noise_map import noise_map, variance
from proofmass.runner.derivatives.ball import Ball
from proofmass.runner.derivatives.dual_noise import NoisyTicks, noise_blocks
from proofmass.runner.derivatives.dual_ticks import DualTicks
from proofmass.runner.design.proof.ball_map import (
    MOST_STATES,
    BallRun,
    MatrixRows,
    Starting,
    at_start,
    changes_later,
    too_large,
)
from proofmass.runner.design.proof.ball_ticks import BallTicks, advanced
from proofmass.runner.design.proof.rest_point import RestRun, not_at_rest
from proofmass.runner.plan.memory import Memory, start
from proofmass.runner.plan.planned import Plan

_MOST_ENDS = 512  # random numbers and values of the output in a period


class StartingNoise(Starting):
    """The way of noise to an output at the start of a run: in tick 0 processes start, so that it is a period later."""

    def __init__(self, plan: Plan, target: Endpoint, rest: RestRun | None = None) -> None:
        """Raises `ModelError` where the sources are not known without a run, or are too many."""
        way = f"the way of noise to {'.'.join(target)}"
        if rest is not None and rest.orbit:
            raise plan.graph.placed(not_at_rest("noise changes along an orbit", ".".join(target))).error
        first = common_period(plan, (), [target], noise=noise_blocks(plan))
        about = linearised(plan, first)
        noisy = noise_at(about, [target])
        bits = [name for name, own in noisy.items() if own or name in plan.digital]
        bits += decided_by_noise(plan, target, first)
        if bits:
            raise plan.graph.placed(_decides(target, bits)).error
        ends = Ends((), (target,), noise=noisy)
        point = at_start(plan, ends, first) if rest is None else rest.map_between(ends)
        if rest is None and point.map.tick != first:
            raise changes_later(plan, way, target)
        between = noise_map(point.map, target)
        if between.settles and not any(between.mean_squares()):
            raise plan.graph.placed(_none(target)).error
        size = max(len(point.map.inputs), len(point.map.outputs))
        if point.map.order > MOST_STATES or size > _MOST_ENDS:
            has = f"{way} has {point.map.order} states and {size} random numbers or values in a period"
            raise too_large(plan, has, target, f"{MOST_STATES} states and {_MOST_ENDS} numbers")
        self._run = _NoiseRun(plan, ends, point, rest)
        self.period, self.values = point.map.period, 1


class _NoiseRun(BallRun):
    """A period whose random numbers and errors of quantisers have directions."""

    def rows(self, parameters: Mapping[str, Any], rest: Any = None, moves: bool = True) -> tuple[MatrixRows, int]:
        """Return the map of all states from sources of variance one to a part of the rms, and how many these are."""
        rows, order = super().rows(parameters, rest, moves)
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
        """Return whether two numbers are alike to the last digit: balls cannot say that they are equal."""
        return repr(before) == repr(value)


def _decides(target: Endpoint, blocks: Sequence[str]) -> Problem:
    signal = ".".join(target)
    return Problem(
        message=f"the noise of {signal} is that of a run: this has no proof",
        key=signal,
        got=", ".join(blocks),
        expected="sources that do not depend on decisions of one bit or on fixed point",
        hint="search with `proofmass worst`",
        path=("blocks", target[0]),
    )


def _none(target: Endpoint) -> Problem:
    signal = ".".join(target)
    hint = "a WhiteNoise, or a converter, must lie on a path to it"
    return Problem(message=f"no noise reaches {signal}", key=signal, hint=hint, path=("blocks", target[0]))
