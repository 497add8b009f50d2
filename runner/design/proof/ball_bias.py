"""The value of an output at rest in balls, as the scale factor of a map from an input of one.

About a point c(q) near the point of rest x, with J and C for all that lies between them,

    x - c = J (x - c) + (F(c, q) - c),   y = y(c, q) + C (x - c)

as the mean of derivatives on the way from c to x is one of J's. So y = D + C (I - A)^-1 B with A = J, B = F(c, q) - c
and D = y(c, q). c moves with the parameters as the point of rest does at the centre of the box, so that B is small. All
that the output depends on is in A, also what B does not reach: it has to decay. Where F is not a period of the sensor
itself, the map of that period stands beside it in A, which then says that the sensor stays at rest.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import flint

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.derivatives.ball import Ball
from proofmass.runner.derivatives.dual import SIGNALS, slopes_of, value_of
from proofmass.runner.design.proof.ball_map import (
    MOST_STATES,
    BallMap,
    BallRun,
    Kept,
    Starting,
    states_between,
    too_large,
)
from proofmass.runner.design.proof.ball_ticks import varied, with_balls
from proofmass.runner.design.proof.krawczyk import RestPoint
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.plan.planned import Plan


class RestingOutput(Starting):
    """An output of sensors that rest: the map about the centre of their points of rest, over any box of parameters."""

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
        """Return the map for parameters that hold balls, dual in the coordinates of a box, of what is `kept`.

        Raises `UndecidedError` where no point of rest is enclosed, or a block decides differently within the box.
        """
        rest = kept.rest if kept is not None and kept.rest is not None else self._rest.following(parameters)
        given = {name: varied(value) for name, value in parameters.items()}
        plan, near = with_balls(self._plan, given), rest.near(given)
        image, outputs = self._rest.image(plan, near)
        around, output_around = self._rest.image(plan, rest.values)
        steps = [value_of(value, SIGNALS) - c for value, c in zip(image, near, strict=True)]
        rows = [[*self._slopes(value), step] for value, step in zip(around, steps, strict=True)]
        slopes = [_mean(column) for column in zip(*map(self._slopes, output_around), strict=True)]
        rows.append([*slopes, _mean([value_of(value, SIGNALS) for value in outputs])])
        order = len(steps)
        if kept is None:
            reached = [[*row[:-1], 1.0] for row in rows]
            kept = Kept(tuple(states_between(reached, order)), (0,), (0,), rest)
        places = [*kept.states, order]
        rows, period = [[rows[i][j] for j in places] for i in places], self._period(given, rest)
        beside, empty = [0.0] * len(period), [0.0] * len(places)
        return BallMap(
            len(beside) + len(kept.states), [[*r, *empty] for r in period] + [[*beside, *r] for r in rows], kept
        )

    def _period(self, parameters: Mapping[str, Any], rest: RestPoint) -> list[list[Any]]:
        """Return the map of a period of the sensor at rest where F is another one, else nothing."""
        if self._period_run is None:
            return []
        rows, order = self._period_run.rows(parameters, rest, moves=False)
        return [row[:order] for row in rows[:order]]

    def _slopes(self, value: Any) -> list[Any]:
        slopes = slopes_of(value, SIGNALS)
        return [slopes.get(key, 0.0) for key in self._rest.directions]


def _mean(values: Sequence[Any]) -> Any:
    return sum(values, 0.0) * Ball(1 / flint.arb(len(values))) if len(values) > 1 else values[0]
