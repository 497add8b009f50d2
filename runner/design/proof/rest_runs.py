"""The start of a run or the points of rest of the sensors: what a claim is about begins there."""

from collections.abc import Callable
from typing import Any, TypeVar

from proofmass.blocks.declaration.problem import ModelError, Problem
from proofmass.graphs.model.loops import AUTO, SETTLED
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import tick_of_time
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.derivatives.ball import UndecidedError
from proofmass.runner.design.proof.ball_map import ChangesLaterError
from proofmass.runner.design.proof.claim import BIAS, Claim
from proofmass.runner.design.proof.rest_point import RestRun, not_at_rest
from proofmass.runner.plan.planned import Plan

_Begun = TypeVar("_Begun")


class RestRuns:
    """The start of a run or the points of rest of a plan, whose run to there is shared."""

    def __init__(self, plan: Plan, at: str) -> None:
        """Take "auto", "settled" or the start, "0 s"; raises `ModelError` for another time."""
        self._plan, self._at, self._course = plan, at, Course(plan)
        if at not in (AUTO, SETTLED) and tick_of_time(plan, at):
            raise _another_time(at).error

    def begun(self, start: Callable[[RestRun | None], _Begun], claim: Claim) -> tuple[_Begun, RestRun | None]:
        """Return what a claim is about, at the start if it is the same later, else at rest, and where that is.

        Raises `ModelError` where there is none.
        """
        reasons = list[Problem]()
        if self._at != SETTLED and claim.kind != BIAS:
            try:
                return start(None), None
            except ChangesLaterError as error:
                if self._at != AUTO:
                    raise
                reasons += error.problems
        try:
            rest = RestRun(self._plan, [node_of(self._plan, claim.open_at)], self._course)
            return start(rest), rest
        except ModelError as error:
            raise ModelError([*reasons, *error.problems]) from None
        except UndecidedError as error:
            raise ModelError([*reasons, not_at_rest(str(error), claim.open_at)]) from None


def _another_time(at: Any) -> Problem:
    return Problem(
        message="proofs are about the start of a run or a point of rest",
        key="at",
        got=str(at),
        expected=f'"{AUTO}", "{SETTLED}" or "0 s"',
        hint="search at other times with `proofmass worst`",
    )
