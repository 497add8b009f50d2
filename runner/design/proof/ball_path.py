"""The map from one wire to another over a period in balls, for an input that is the same in all of it.

    x[n+1] = A x[n] + B u,   y = C x[n] + D u

B and D are sums over the values of the input in a period, C and D means over those of the output: as the scale factor
has them. A response has all values as they are.
"""

from collections.abc import Sequence
from typing import Any

import flint

from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, OperatingPoints
from proofmass.runner.analysis.linearisation.orbit import OrbitPoint
from proofmass.runner.analysis.linearisation.steady_state import SteadyState
from proofmass.runner.analysis.response.response import response_of_map
from proofmass.runner.derivatives.ball import Ball, ball
from proofmass.runner.design.proof.ball_map import (
    MOST_STATES,
    MOST_VALUES,
    BallRun,
    MatrixRows,
    Starting,
    at_start,
    changes_later,
    too_large,
)
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.plan.planned import Plan

_ALIKE = "a way that is the same in each period from the start of the run"


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

    With p values of the input in a period, and r of the output, the gain at a frequency is o H i / r, with weights o
    and i of size 1: at most sqrt(p / r) times the norm of H.
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
    """Return whether the scale factor is that of the start, though the graph moves on from there."""

    def ask(about: Linearisation) -> bool:
        SteadyState(plan, about.map([source], [target, source], everything=True).seen(), target)
        return not about.told

    return OperatingPoints(plan).answered(ask)


def _sum(values: Sequence[Any], part: Any) -> Any:
    """Return a sum of numbers times a part: 0.0 where each of them is."""
    return sum((value * part for value in values), 0.0)
