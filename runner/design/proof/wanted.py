"""The claims that are wanted: what loops and outputs they are about, and their limits, as options have them.

What a claim is about begins at the start of a run or at the points of rest of the sensors.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.checks.requirements import refuse_limit
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, SETTLED, Loop, read_requirement
from proofmass.runner.analysis.linearisation.analog_loop import analog_group
from proofmass.runner.analysis.linearisation.forward import Course
from proofmass.runner.analysis.linearisation.linearisation import tick_of_time
from proofmass.runner.analysis.linearisation.linearise import loop_nodes, node_of, one_loop
from proofmass.runner.derivatives.ball import UndecidedError
from proofmass.runner.design.proof.ball_map import ChangesLaterError, Starting, StartingLoop
from proofmass.runner.design.proof.claim import BIAS, KINDS, PEAK, RMS, SCALE_FACTOR, Claim
from proofmass.runner.design.proof.quantity_claims import settled_claims, upper_claims
from proofmass.runner.design.proof.rest_maps import TIME_IS_UP, not_at_rest
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.proof.starting import (
    RestingOutput,
    StartingNoise,
    StartingPath,
    StartingRates,
    StartingResponse,
)
from proofmass.runner.plan.planned import Plan

Subject = tuple[Callable[[RestRun | None], Starting], Sequence[Claim]]  # at the start or at rest, and claims about it
_Begun = TypeVar("_Begun")


class RestRuns:
    """The start of a run or the points of rest of a plan, whose run to there is shared."""

    def __init__(self, plan: Plan, at: str) -> None:
        """Take "auto", "settled" or the start, "0 s"; raises `ModelError` for another time."""
        self._plan, self._at, self._course = plan, at, Course(plan)
        if at not in (AUTO, SETTLED) and tick_of_time(plan, at):
            raise _another_time(at).error

    def begun(
        self, start: Callable[[RestRun | None], _Begun], claim: Claim, is_over: Callable[[], bool]
    ) -> tuple[_Begun, RestRun | None]:
        """Return what a claim is about, at the start if it is the same later, else at rest, and where that is.

        Raises `ModelError` where there is none, or where the time is over.
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
            if is_over():
                raise UndecidedError(TIME_IS_UP)
            rest = RestRun(self._plan, [node_of(self._plan, claim.open_at)], self._course)
            if rest.places and claim.row.of_output:
                raise self._plan.graph.placed(
                    not_at_rest(f"{rest.places[0].name} comes to no rest", claim.open_at)
                ).error
            with rest.until(is_over):
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


def about_loops(planned: Plan, loop: str, at: str, given: Mapping[str, str]) -> list[Subject]:
    """Return claims about one loop, or all of them, by their limits; raises `ModelError`."""
    return [
        (partial(_starting, planned, node, at), list(_claims(planned.graph.loops.get(name), name, node, given)))
        for name, node in loop_nodes(planned, loop).items()
    ]


def about_margin(planned: Plan, loop: str, at: str, kind: str, limit: float) -> Subject:
    """Return one claim about a loop; raises `ModelError`."""
    name, node = one_loop(planned, loop)
    return partial(_starting, planned, node, at), [Claim(name, ".".join(node), kind, limit)]


def about_outputs(planned: Plan, source: str, limits: Mapping[str, Mapping[str, Any] | None]) -> list[Subject]:
    """Return claims about quantities of outputs, by kind, from an input; raises `ModelError`."""
    wanted = [
        *settled_claims(planned, SCALE_FACTOR, limits[SCALE_FACTOR] or {}, source),
        *settled_claims(planned, BIAS, limits[BIAS] or {}, source),
        *upper_claims(planned, PEAK, limits[PEAK] or {}, source),
        *upper_claims(planned, RMS, limits[RMS] or {}),
    ]
    return [(_path(planned, own[0]), own) for own in wanted]


def _path(planned: Plan, claim: Claim) -> Callable[[RestRun | None], Starting]:
    target = node_of(planned, claim.open_at)
    if claim.kind in (RMS, BIAS):
        return partial(StartingNoise if claim.kind == RMS else RestingOutput, planned, target)
    kind = StartingResponse if claim.kind == PEAK else StartingPath
    return partial(kind, planned, node_of(planned, claim.loop), target)


def _starting(planned: Plan, node: Endpoint, at: str, rest: RestRun | None) -> StartingLoop:
    group = analog_group(planned, node)
    if group is not None:
        return StartingRates(planned, group, node, rest, at not in (AUTO, SETTLED))
    return StartingLoop(planned, node, rest)


def _claims(required: Loop | None, name: str, node: Endpoint, given: Mapping[str, str]) -> Iterator[Claim]:
    """Yield the claims about a loop: those given, and without them those that it requires, or the usual ones."""
    at = ".".join(node)
    yield Claim(name, at, "stable", 0.0)
    for kind, text in given.items():
        limit = _limit(kind, text) if text else getattr(required, kind.replace(" ", "_"), None)
        limit = KINDS[kind].usual if limit is None else limit
        if limit is not None:
            yield Claim(name, at, kind, limit)


def _limit(kind: str, given: str) -> float:
    """Return a limit in the unit of its kind; raises `ModelError`."""
    unit = KINDS[kind].unit or ""
    try:
        limit = read_requirement(given, unit) if unit in ("dB", "deg", "s") else convert(given, unit)
        refuse_limit(kind, limit)
    except Refusal as error:
        raise error.problem(kind.replace(" ", "_"), given).error from None
    return limit
