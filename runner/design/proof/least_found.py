"""The worst among some sensors of a box: how far a proved bound may be from the truth at most."""

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.decisions.one_bit import noise_at
from proofmass.runner.analysis.linearisation.ends import Ends
from proofmass.runner.analysis.linearisation.linearisation import Linearisation, linearised
from proofmass.runner.analysis.linearisation.linearise import node_of
from proofmass.runner.analysis.linearisation.steady_state import SteadyState
from proofmass.runner.analysis.margins.margins import Margins, margins_of
from proofmass.runner.analysis.noise.noise_map import noise_map
from proofmass.runner.analysis.response.response import response_of
from proofmass.runner.derivatives.dual_noise import noise_blocks
from proofmass.runner.design.proof.claim import BIAS, PEAK, RMS, Claim
from proofmass.runner.design.proof.rest_point import RestRun
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

_AROUND = 8  # places of a turn that are looked at
_ROUNDING = 1e-9  # part of an rms, of which a nearly neutral mode is summed over a long time
_KEPT = 64  # margins of sensors: claims about a loop ask for the same ones again


@dataclass(frozen=True)
class LeastFound:
    """The worst margin or quantity that was found, infinite if there is none, and the parameters of its sensor."""

    margin: float
    at: Mapping[str, float]

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {"margin": self.margin if math.isfinite(self.margin) else None, "at": dict(self.at)}


@dataclass(frozen=True)
class Sensors:
    """Sensors that differ in parameters, at the start of a run or at rest."""

    graph: Graph
    rest: RestRun | None = None

    def plan(self, parameters: Mapping[str, float]) -> Plan:
        """Return the plan of a sensor."""
        places = self._places(parameters)
        return plan(with_parameters(self.graph, {name: x for name, x in parameters.items() if name not in places}))

    def about(self, planned: Plan, tick: int = 0, parameters: Mapping[str, float] | None = None) -> Linearisation:
        """Return a sensor about its point of rest, at the places among its parameters, else about a tick.

        Raises `ModelError`.
        """
        if self.rest is None:
            return linearised(planned, tick)
        return self.rest.linearised(planned, self._places(parameters or {}))

    @cached_property
    def margins(self) -> Callable[[str, str, tuple[tuple[str, float], ...]], Margins]:
        """The margins of a loop of this name and wire by the parameters of a sensor; raises `ModelError`."""
        return lru_cache(_KEPT)(self._margins)

    def _margins(self, loop: str, open_at: str, parameters: tuple[tuple[str, float], ...]) -> Margins:
        known = dict(parameters)
        about = self.about(self.plan(known), parameters=known)
        return margins_of(about.loop(node_of(about.plan, open_at)), loop, open_at)

    @property
    def turns(self) -> set[str]:
        """The names of places that are whole turns, whose ends are one."""
        return set() if self.rest is None else {place.name for place in self.rest.places if place.turns}

    def _places(self, parameters: Mapping[str, float]) -> Mapping[str, float]:
        names = set() if self.rest is None else {place.name for place in self.rest.places}
        return {name: value for name, value in parameters.items() if name in names}


def margins_there(sensors: Sensors, claim: Claim, parameters: Mapping[str, float]) -> Margins:
    """Return the margins of a sensor by the exact polynomials of its loop; raises `ModelError`."""
    return sensors.margins(claim.loop, claim.open_at, tuple(parameters.items()))


def value_there(sensors: Sensors, claim: Claim, parameters: Mapping[str, float]) -> float:
    """Return the value of what a claim is about: an unstable sensor has an infinitely bad one.

    Raises `ModelError` where it has none that is known.
    """
    if not claim.row.of_output:
        return margin_of(margins_there(sensors, claim, parameters), claim.kind)
    return quantity_there(sensors, claim, parameters)[0]


def quantity_there(sensors: Sensors, claim: Claim, parameters: Mapping[str, float]) -> tuple[float, float]:
    """Return a quantity of a sensor, and what rounding may make of it; raises `ModelError` as `value_there` does."""
    planned = sensors.plan(parameters)
    if claim.kind == BIAS:
        assert sensors.rest is not None
        return sensors.rest.value(planned)
    if claim.kind == RMS:
        return _noise(sensors, planned, claim)
    about = sensors.about(planned)
    return _peak(about, claim) if claim.kind == PEAK else quantity_about(about, claim)


def quantity_about(about: Linearisation, claim: Claim) -> tuple[float, float]:
    """Return a quantity at an operating point, infinitely bad if it does not settle, and what
    rounding may make of it.

    Raises `ModelError`.
    """
    source, target = (node_of(about.plan, signal) for signal in (claim.loop, claim.open_at))
    whole = about.map([source], [target, source], everything=True).seen()
    try:
        settled = SteadyState(about.plan, whole, target)
    except ModelError:
        return -claim.sign * math.inf, 0.0
    return settled.values()[0], settled.rounding


def _peak(about: Linearisation, claim: Claim) -> tuple[float, float]:
    """Return the largest gain of a response, infinite if it does not settle, and what rounding may make of it."""
    source, target = (node_of(about.plan, signal) for signal in (claim.loop, claim.open_at))
    found = response_of(about, source, target)
    return (found.peak[1], _ROUNDING * found.peak[1]) if found.wires.radius < 1.0 else (math.inf, 0.0)


def _noise(sensors: Sensors, planned: Plan, claim: Claim) -> tuple[float, float]:
    """Return an output's rms noise, infinite without bound, and what rounding may make of it."""
    target = node_of(planned, claim.open_at)
    about = sensors.about(planned, Ends((), (target,), noise=noise_blocks(planned)).common_period(planned))
    to_output = noise_map(about.map([], [target], noise=noise_at(about, [target])), target)
    rms = math.sqrt(float(np.sum(to_output.mean_squares))) if to_output.settles else math.inf
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
    if kind == "decay rate" and found.system.continuous:
        return -max(found.poles.real, default=-math.inf)
    if kind == "decay rate":
        largest = max(abs(found.poles), default=0.0)
        return -math.log(largest) / found.period if largest > 0.0 else math.inf
    margin = {"delay margin": found.delay_margin, "disk margin": found.disk_margin}.get(kind)
    return math.inf if margin is None else margin


def least_found(sensors: Sensors, ranges: tuple[Range, ...], claim: Claim) -> LeastFound:
    """Return the worst of the nominal sensor, of both ends of each range, and of all the worse ends together.

    A whole turn has no ends: places all around it are looked at.
    """
    nominal, turns = {r.written: r.nominal for r in ranges}, sensors.turns
    worse = dict(nominal)
    found = [_least(sensors, claim, [nominal])]
    for r in ranges:
        values = np.linspace(r.low, r.high, _AROUND, endpoint=False) if r.written in turns else (r.low, r.high)
        end = _least(sensors, claim, [nominal | {r.written: float(value)} for value in values])
        worse[r.written] = end.at[r.written]
        found.append(end)
    return worst_of([*found, _least(sensors, claim, _corners(worse, ranges, turns))], claim)


def worst_of(found: Iterable[LeastFound], claim: Claim) -> LeastFound:
    """Return the worst one: the least, or the largest where the limit is an upper one."""
    return min(found, key=lambda one: claim.sign * one.margin)


def _corners(
    worse: Mapping[str, float], ranges: tuple[Range, ...], turns: Collection[str]
) -> Iterator[dict[str, float]]:
    """Yield the corner of the worse ends, and those that differ from it in one: by half a step around a turn."""
    yield dict(worse)
    for r in ranges:
        at, width, values = worse[r.written], r.high - r.low, list[float]()
        if r.written in turns:
            values += (r.low + (at + by * width / (2 * _AROUND) - r.low) % width for by in (-1, 1))
        else:
            values.append(r.low if at == r.high else r.high)
        for value in values:
            yield {**worse, r.written: value}


def _least(sensors: Sensors, claim: Claim, parameters: Iterable[dict[str, float]]) -> LeastFound:
    return worst_of((LeastFound(value_there(sensors, claim, one), one) for one in parameters), claim)
