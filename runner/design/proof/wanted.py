"""The claims that are wanted: what loops and outputs they are about, and their limits, as options have them."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

from proofmass.blocks.declaration.problem import Refusal
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.model.graph import Endpoint
from proofmass.graphs.model.loops import AUTO, SETTLED, Loop, read_requirement
from proofmass.runner.analysis.linearisation.analog_loop import analog_group
from proofmass.runner.analysis.linearisation.linearise import loop_nodes, node_of, one_loop
from proofmass.runner.design.proof.ball_map import Starting, StartingLoop
from proofmass.runner.design.proof.claim import BIAS, KINDS, PEAK, RMS, SCALE_FACTOR, Claim
from proofmass.runner.design.proof.quantity_claims import settled_claims, upper_claims
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.proof.starting import (
    RestingOutput,
    StartingNoise,
    StartingPath,
    StartingRates,
    StartingResponse,
)
from proofmass.runner.plan.planned import Plan

MOST_DISK = 2.0
Subject = tuple[Callable[[RestRun | None], Starting], Sequence[Claim]]  # at the start or at rest, and claims about it


def about_loops(planned: Plan, loop: str, at: str, given: Mapping[str, str]) -> list[Subject]:
    """Return the claims about one loop, or about all of them, by their limits; raises `ModelError`."""
    return [
        (partial(_starting, planned, node, at), list(_claims(planned.graph.loops.get(name), name, node, given)))
        for name, node in loop_nodes(planned, loop).items()
    ]


def about_margin(planned: Plan, loop: str, at: str, kind: str, limit: float) -> Subject:
    """Return one claim about a loop; raises `ModelError`."""
    name, node = one_loop(planned, loop)
    return partial(_starting, planned, node, at), [Claim(name, ".".join(node), kind, limit)]


def about_outputs(planned: Plan, source: str, limits: Mapping[str, Mapping[str, Any] | None]) -> list[Subject]:
    """Return the claims about quantities of outputs, by their kinds, from an input; raises `ModelError`."""
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
        if not 0.0 < limit < math.inf and kind in ("disk margin", "delay margin", "decay rate"):
            raise Refusal("must be above zero")
        if kind == "disk margin" and limit >= MOST_DISK:
            raise Refusal("must be below 2", "such a disk is a half plane")
    except Refusal as error:
        raise error.problem(kind.replace(" ", "_"), given).error from None
    return limit
