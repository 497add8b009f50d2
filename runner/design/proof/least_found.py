"""The worst among some sensors of a box: how far a proved bound may be from the truth at most."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.map_blocks import common_period
from proofmass.runner.analysis.linearisation.steady_state import SteadyState
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.analysis.noise.noise_map import noise_map
from proofmass.runner.analysis.response.response import response_of
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.design.proof.claim import PEAK, RMS, Claim
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_START = "0 s"
_ROUNDING = 1e-9  # part of an rms, of which a nearly neutral mode is summed over a long time


@dataclass(frozen=True)
class LeastFound:
    """The worst margin or quantity that was found, infinite if there is none, and the parameters of its sensor."""

    margin: float
    at: Mapping[str, float]

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {"margin": self.margin if math.isfinite(self.margin) else None, "at": dict(self.at)}


def margins_there(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> Margins:
    """Return the margins of a sensor by the exact polynomials of its loop."""
    return margins(with_parameters(graph, parameters), claim.open_at, at=_START)


def value_there(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> float:
    """Return the value of what a claim is about: an unstable sensor has an infinitely bad one.

    Raises `ModelError` where it has none that is known.
    """
    if not claim.row.of_output:
        return margin_of(margins_there(graph, claim, parameters), claim.kind)
    return quantity_there(graph, claim, parameters)[0]


def quantity_there(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> tuple[float, float]:
    """Return a quantity of a sensor, and what rounding may make of it; raises `ModelError` as `value_there` does."""
    planned = plan(with_parameters(graph, parameters))
    if claim.kind == PEAK:
        return _peak(planned, claim)
    return _noise(planned, claim) if claim.kind == RMS else quantity_about(linearised(planned), claim)


def quantity_about(about: Linearisation, claim: Claim) -> tuple[float, float]:
    """Return a quantity at an operating point, infinitely bad if it does not settle, and what rounding may make of it.

    Raises `ModelError`.
    """
    source, target = (node_of(about.plan, signal) for signal in (claim.loop, claim.open_at))
    whole = about.map([source], [target, source], everything=True).seen()
    try:
        settled = SteadyState(about.plan, whole, target)
    except ModelError:
        return -claim.sign * math.inf, 0.0
    return settled.values()[0], settled.rounding


def _peak(planned: Plan, claim: Claim) -> tuple[float, float]:
    """Return the largest gain of a response, infinite if it does not settle, and what rounding may make of it."""
    source, target = (node_of(planned, signal) for signal in (claim.loop, claim.open_at))
    found = response_of(linearised(planned), source, target)
    return (found.peak[1], _ROUNDING * found.peak[1]) if found.wires.radius < 1.0 else (math.inf, 0.0)


def _noise(planned: Plan, claim: Claim) -> tuple[float, float]:
    """Return the rms noise of an output, infinite if it has no bound, and what rounding may make of it."""
    target = node_of(planned, claim.open_at)
    about = linearised(planned, common_period(planned, (), [target], noise=noise_blocks(planned)))
    to_output = noise_map(about.map([], [target], noise=noise_at(about, [target])), target)
    rms = math.sqrt(float(np.sum(to_output.mean_squares()))) if to_output.settles else math.inf
    return rms, _ROUNDING * rms if to_output.settles else 0.0


def margin_of(found: Margins, kind: str) -> float:
    """Return a margin or rate, in the unit of its kind: infinite where there is none, minus infinity if unstable."""
    if not found.stable:
        return -math.inf
    if kind == "gain margin":
        gains = (abs(20.0 * math.log10(gain)) for gain in (found.gain_margin, found.gain_reduction) if gain)
        return min(gains, default=math.inf)
    if kind == "phase margin":
        return math.inf if found.phase_margin is None else math.degrees(found.phase_margin)
    if kind == "decay rate":
        largest = max(abs(found.poles), default=0.0)
        return -math.log(largest) / found.period if largest > 0.0 else math.inf
    margin = {"delay margin": found.delay_margin, "disk margin": found.disk_margin}.get(kind)
    return math.inf if margin is None else margin


def least_found(graph: Graph, ranges: tuple[Range, ...], claim: Claim) -> LeastFound:
    """Return the worst of the nominal sensor, of both ends of each range, and of all the worse ends together."""
    nominal = {r.written: r.nominal for r in ranges}
    worse = dict(nominal)
    found = [_least(graph, claim, [nominal])]
    for r in ranges:
        end = _least(graph, claim, [nominal | {r.written: value} for value in (r.low, r.high)])
        worse[r.written] = end.at[r.written]
        found.append(end)
    return worst_of([*found, _least(graph, claim, _corners(worse, ranges))], claim)


def worst_of(found: Iterable[LeastFound], claim: Claim) -> LeastFound:
    """Return the worst one: the least, or the largest where the limit is an upper one."""
    return min(found, key=lambda one: claim.sign * one.margin)


def _corners(worse: Mapping[str, float], ranges: tuple[Range, ...]) -> Iterator[dict[str, float]]:
    """Yield the corner of the worse ends, and those that differ from it in one."""
    yield dict(worse)
    for r in ranges:
        yield {**worse, r.written: r.low if worse[r.written] == r.high else r.high}


def _least(graph: Graph, claim: Claim, sensors: Iterable[dict[str, float]]) -> LeastFound:
    return worst_of((LeastFound(value_there(graph, claim, one), one) for one in sensors), claim)
