"""The least margin among some sensors of a box: how far a proved bound may be from the truth at most."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from proofmass.graphs.model.changes import with_parameters
from proofmass.graphs.model.graph import Graph
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.worst.ranges import Range

_START = "0 s"


@dataclass(frozen=True)
class LeastFound:
    """The least margin or rate that was found, infinite if there is none, and the parameters of its sensor."""

    margin: float
    at: Mapping[str, float]

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {"margin": self.margin if math.isfinite(self.margin) else None, "at": dict(self.at)}


def margins_there(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> Margins:
    """Return the margins of a sensor by the exact polynomials of its loop."""
    return margins(with_parameters(graph, parameters), claim.open_at, at=_START)


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
    """Return the least margin of the nominal sensor, of both ends of each range, and of all the worse ends together."""
    nominal = {r.written: r.nominal for r in ranges}
    worse = dict(nominal)
    found = _least(graph, claim, [nominal])
    for r in ranges:
        end = _least(graph, claim, [nominal | {r.written: value} for value in (r.low, r.high)])
        worse[r.written] = end.at[r.written]
        found = min(found, end, key=lambda one: one.margin)
    return min(found, _least(graph, claim, _corners(worse, ranges)), key=lambda one: one.margin)


def _corners(worse: Mapping[str, float], ranges: tuple[Range, ...]) -> Iterator[dict[str, float]]:
    """Yield the corner of the worse ends, and those that differ from it in one."""
    yield dict(worse)
    for r in ranges:
        yield {**worse, r.written: r.low if worse[r.written] == r.high else r.high}


def _least(graph: Graph, claim: Claim, sensors: Iterable[dict[str, float]]) -> LeastFound:
    every = (LeastFound(margin_of(margins_there(graph, claim, one), claim.kind), one) for one in sensors)
    return min(every, key=lambda one: one.margin)
