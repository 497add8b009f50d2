"""A loop among continuous blocks in balls, opened at a wire between them: x' = A x + B u, y = C x.

The rates of its group are called with balls for the parameters of the blocks, and with dual numbers on them, as a tick
is. What discrete blocks give is held, so that loops through them are open: those of `margins` at such a wire.
"""

from collections.abc import Mapping
from typing import Any

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.graph import Endpoint
from proofmass.runner.analysis.linearisation.analog_loop import analog_map, analog_rates
from proofmass.runner.analysis.linearisation.linearisation import linearised
from proofmass.runner.analysis.linearisation.map_changes import change_between
from proofmass.runner.analysis.linearisation.orbit import SAME
from proofmass.runner.derivatives.ball import UndecidedError
from proofmass.runner.derivatives.dual import SIGNALS, slopes_of
from proofmass.runner.design.proof.ball_map import (
    MOST_STATES,
    BallRun,
    ChangesLaterError,
    MatrixRows,
    StartingLoop,
    changes_later,
    too_large,
)
from proofmass.runner.design.proof.rest_point import RestRun, not_at_rest
from proofmass.runner.plan.groups import Group
from proofmass.runner.plan.planned import Plan
from proofmass.runner.reference.interpret import TickError

_ALIKE = "a loop that is the same later"


class StartingRates(StartingLoop):
    """A loop in continuous time at the start of a run, or at rest: its rates over any box of parameters."""

    def __init__(self, plan: Plan, group: Group, node: Endpoint, rest: RestRun | None, at_start: bool) -> None:
        """Take the loop of a group; with `at_start` it may change after tick 0.

        Raises `ModelError` where margins are not those of the start, or cannot be linearised.
        """
        signal = ".".join(node)
        if rest is not None and rest.orbit:
            raise plan.graph.placed(not_at_rest("a loop in continuous time changes along an orbit", signal)).error
        about = linearised(plan) if rest is None else rest.linearised(plan)
        try:
            between = about.loop(node).map
        except ModelError as error:
            raise error if rest is not None else ChangesLaterError(error.problems) from None
        if rest is None and not at_start:
            whole = analog_map(plan, about.course.onward(0), group, [node])
            if any(change_between(whole, after) > SAME for after in whole.later):
                raise changes_later(plan, f"the loop through {signal}", node, _ALIKE)
        if between.order > MOST_STATES:
            raise too_large(plan, f"the loop through {signal} has {between.order} states", node, MOST_STATES)
        self._run = _RateRun(plan, group, node, rest)
        self.period, self.values = 0.0, 1


class _RateRun(BallRun):
    """The rates of a group in balls."""

    def __init__(self, plan: Plan, group: Group, node: Endpoint, rest: RestRun | None) -> None:
        self._plan, self._group, self._node, self._rest = plan, group, node, rest

    def rows(self, parameters: Mapping[str, Any], rest: Any = None, moves: bool = True) -> tuple[MatrixRows, int]:
        """Return [A B; C D] for parameters that hold balls, and the number of states; raises `UndecidedError`."""
        plan, _, memory = self._there(parameters, rest, moves)
        try:
            moving, rates = analog_rates(plan, self._group, [self._node], memory)
        except TickError as error:
            raise UndecidedError(f"{error.at}: {error.__cause__ or error.value}") from error
        columns = (*moving, len(self._group.states))
        return [[slopes_of(rate, SIGNALS).get(key, 0.0) for key in columns] for rate in rates], len(moving)
