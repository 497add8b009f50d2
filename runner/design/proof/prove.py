"""Proofs over tolerances: no sensor whose parameters lie in a box has less than these margins.

A loop has a gain margin of m where all factors from 1/m to m at its wire leave it stable, and a phase margin of p where
all turns from -p to p do; both are boxes with one more coordinate. What is proved is a theorem about the functions of
the blocks in real numbers; rounding in a run is not a part of it, and the loop is that of the start of the run.
"""

import math
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import flint

from proofmass.blocks.declaration.problem import ModelError, Problem, Refusal, shown
from proofmass.blocks.declaration.units import convert
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.graph import Endpoint, Graph
from proofmass.graphs.model.loops import Loop, read_requirement
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.linearisation.analog_loop import analog_group
from proofmass.runner.analysis.linearisation.linearise import loops_of, node_of, one_loop
from proofmass.runner.derivatives.ball import BITS, UndecidedError
from proofmass.runner.design.proof.ball_map import StartingLoop
from proofmass.runner.design.proof.claim import UNITS, Claim
from proofmass.runner.design.proof.coordinates import Coordinates, Sides, coordinates_of
from proofmass.runner.design.proof.known import KnownProofs
from proofmass.runner.design.proof.least_found import LeastFound, least_found, margin_of, margins_there
from proofmass.runner.design.proof.search import BoxMaps, ProofSearch, Searched
from proofmass.runner.design.worst.box import ToleranceBox, box_of
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

GAIN_MARGIN, PHASE_MARGIN, SECONDS = "6 dB", "45 deg", 60.0
USUAL: Mapping[str, float | None] = {  # limits of what nobody gives one for
    "gain margin": 6.0,
    "phase margin": 45.0,
    "disk margin": None,
    "delay margin": None,
    "decay rate": None,
}
MOST_DISK = 2.0
_WHOLE_DELAYS = "the wire has several values in a period, and its delay margin is a count of them"
_NEAR, _CLOSE = 0.97, 0.02  # parts of the least margin found: where a bound is near it, and two bounds alike


@dataclass(frozen=True)
class MarginProof:
    """A claim, what came of it, and the parameters of a sensor that breaks it, if one was found."""

    claim: Claim
    searched: Searched
    seconds: float
    coordinates: Coordinates | None = None
    counterexample: Mapping[str, float] | None = None
    shown: str = ""  # the margins of that sensor
    least: LeastFound | None = None  # the least margin that was found, if the largest bound was looked for

    @property
    def status(self) -> str:
        """ "proved", "refuted" or "open"."""
        return self.searched.status

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "loop": self.claim.loop,
            "open_at": self.claim.open_at,
            "claim": str(self.claim),
            "kind": self.claim.kind,
            "limit": self.claim.limit,
            "status": self.status,
            "part": self.searched.part,
            "boxes": self.searched.boxes,
            "seconds": self.seconds,
            "why": self.searched.why,
            "counterexample": None if self.counterexample is None else dict(self.counterexample),
            "margins_there": self.shown,
            "least_found": self.least and self.least.as_data(),
        }


@dataclass(frozen=True, repr=False)
class Proofs(Told):
    """All claims about a graph within tolerances.

    >>> from proofmass import prove, read_graph
    >>> found = prove(read_graph("library:closed_loop_accelerometer"), tolerances={"torquer.gain": "5 %"})
    >>> [(str(proof.claim), proof.status) for proof in found.proofs]
    [('stable', 'proved'), ('gain margin of at least 6 dB', 'proved'), ('phase margin of at least 45 deg', 'proved')]
    """

    graph: Graph  # whose sensors they are about
    ranges: tuple[Range, ...]  # of the parameters
    proofs: tuple[MarginProof, ...]  # one of each claim
    interrupted: bool  # True after Ctrl-C
    left_out: Mapping[str, str]  # what varies and does not count, with its reason

    @property
    def proved(self) -> bool:
        """True if all claims are proved."""
        return all(proof.status == "proved" for proof in self.proofs)

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "graph": self.graph.name,
            "ranges": {
                r.written: {"nominal": r.nominal, "low": r.low, "high": r.high, "unit": r.unit} for r in self.ranges
            },
            "proofs": [proof.as_data() for proof in self.proofs],
            "proved": self.proved,
            "interrupted": self.interrupted,
            "left_out": dict(self.left_out),
        }


def prove(
    source: GraphSource | Study,
    loop: str = "",
    *,
    tolerances: Mapping[str, Any] | None = None,
    gain_margin: str = "",
    phase_margin: str = "",
    disk_margin: str = "",
    delay_margin: str = "",
    decay_rate: str = "",
    bounds: bool = False,
    seconds: float = SECONDS,
    progress: Progress | None = None,
    known: KnownProofs | None = None,
) -> Proofs:
    """Prove that no sensor within tolerances is unstable or has less than these margins, or show one that has.

    `source` is a graph, or a study, whose spread counts as tolerances: three standard deviations of normal parameters.
    `tolerances` maps parameters to "5 %", to a width with a unit or to a list of two values. `loop` names one loop;
    unless given, all of them count. `gain_margin` and `phase_margin` are limits such as "10 dB" and "60 deg"; unless
    given, those that a loop requires, else 6 dB and 45 deg. A `disk_margin` such as "0.5", a `delay_margin` such as
    "100 us" and a `decay_rate` of the slowest pole such as "50 1/s" are proved besides if they are given. With `bounds`
    the largest limits that can be proved are looked for beyond these, beside the least that are found. The search ends
    after so many `seconds`; `progress` is called with the claims that are done and all claims. `known` has what an
    earlier search proved, which is not searched again.

    Margins are those at the start of the run, with the functions of the blocks in real numbers. A loop that changes
    after the start, or lies among continuous blocks, is open, with the reason. Raises `ModelError` for what is wrong
    with the graph or the tolerances.

    >>> from proofmass import prove, read_graph
    >>> prove(read_graph("library:closed_loop_accelerometer"), gain_margin="20 dB").proved
    True
    """
    graph, box, coordinates = _varied(source, tolerances)
    planned = plan(graph)
    if loop:
        loops = dict([one_loop(planned, loop)])
    else:
        loops = {name: node_of(planned, one.open_at) for name, one in loops_of(planned).items()}
    given = {
        "gain margin": gain_margin,
        "phase margin": phase_margin,
        "disk margin": disk_margin,
        "delay margin": delay_margin,
        "decay rate": decay_rate,
    }
    claims = [(node, list(_claims(planned.graph.loops.get(name), name, node, given))) for name, node in loops.items()]
    proofs = list[MarginProof]()
    every = sum(len(wanted) for _, wanted in claims)
    with interrupts() as stop:
        for proof in _proofs(graph, planned, claims, coordinates, bounds, seconds, stop, known or KnownProofs(())):
            proofs.append(proof)
            if progress is not None:
                progress(len(proofs), every)
        return Proofs(graph, coordinates.ranges, tuple(proofs), stop.is_set(), box.left_out if box else {})


def prove_margin(
    source: GraphSource | Study,
    loop: str,
    kind: str,
    limit: float,
    tolerances: Mapping[str, Any],
    seconds: float = SECONDS,
) -> MarginProof:
    """Prove one of `UNITS` of a loop, "gain margin" in dB or "stable", as `prove` does all of them.

    Raises `ModelError`.
    """
    graph, _, coordinates = _varied(source, tolerances)
    planned = plan(graph)
    name, node = one_loop(planned, loop)
    claim = Claim(name, ".".join(node), kind, limit)
    with interrupts() as stop:
        return next(_proofs(graph, planned, [(node, [claim])], coordinates, False, seconds, stop, KnownProofs(())))


def _varied(
    source: GraphSource | Study, tolerances: Mapping[str, Any] | None
) -> tuple[Graph, ToleranceBox | None, Coordinates]:
    """Return the graph, the box of what varies, if anything does, and its coordinates."""
    graph = source.graph if isinstance(source, Study) else graph_from(source)
    varied = isinstance(source, Study) or bool(tolerances)
    box = box_of(source if isinstance(source, Study) else graph, tolerances or {}) if varied else None
    return graph, box, coordinates_of(plan(graph), tuple(box.ranges) if box else ())


def _proofs(
    graph: Graph,
    planned: Plan,
    claims: Sequence[tuple[Endpoint, Sequence[Claim]]],
    coordinates: Coordinates,
    bounds: bool,
    seconds: float,
    stop: threading.Event,
    known: KnownProofs,
) -> Iterator[MarginProof]:
    """Yield what comes of each claim about the loops through some outputs; all share the time that is left."""
    end, left = time.monotonic() + seconds, sum(len(wanted) for _, wanted in claims)
    for node, wanted in claims:
        try:
            starting = _starting(planned, node)
        except ModelError as error:
            why = "; ".join(problem.message for problem in error.problems)
            yield from (MarginProof(claim, Searched("open", (), 0, 0.0, None, why), 0.0) for claim in wanted)
            left -= len(wanted)
            continue
        straight = _straight(starting, coordinates)
        maps = BoxMaps(starting, straight.parameters)
        attempt = Attempt(graph, maps, straight, stop, known)
        for wish in wanted:
            now, claim = time.monotonic(), replace(wish, period=starting.period)
            search_ends = now + (end - now) / left
            left -= 1
            if claim.kind == "delay margin" and starting.values > 1:
                yield MarginProof(claim, Searched("open", (), 0, 0.0, None, _WHOLE_DELAYS), 0.0)
                continue
            proof = attempt.at(claim, search_ends)
            if bounds and proof.status == "proved" and claim.unit:
                proof = attempt.tightened(proof, search_ends)
            yield proof


def _starting(planned: Plan, node: Endpoint) -> StartingLoop:
    if analog_group(planned, node) is not None:
        raise ModelError([planned.graph.placed(_continuous(node))])
    return StartingLoop(planned, node)


@dataclass(frozen=True)
class Attempt:
    """Searches about one loop."""

    graph: Graph
    maps: BoxMaps
    coordinates: Coordinates
    stop: threading.Event
    known: KnownProofs

    def at(self, claim: Claim, until: float) -> MarginProof:
        """Return what comes of a claim."""
        begin = time.monotonic()
        known = self.known.leaves(claim, self.coordinates.as_data())
        search = ProofSearch(self.maps, claim, lambda box: self._breaks(claim, box), known)
        searched = search.over((*self.coordinates.box(), claim.ends), until, self.stop)
        counterexample, text = None, ""
        if searched.status == "refuted" and searched.at is not None:
            counterexample = self._middle(searched.at)
            text, fails = _checked(self.graph, claim, counterexample)
            if not fails:
                why = f"a pole lies at the boundary of stability, at margins of {text}"
                searched, counterexample, text = replace(searched, status="open", why=why), None, ""
        return MarginProof(claim, searched, time.monotonic() - begin, self.coordinates, counterexample, text)

    def _breaks(self, claim: Claim, box: Sides) -> bool:
        """Return whether the middle of a box breaks a claim: where no disc has its poles, of one disc alone."""
        return claim.kind not in ("delay margin", "disk margin") or _checked(self.graph, claim, self._middle(box))[1]

    def _middle(self, box: Sides) -> dict[str, float]:
        return self.coordinates.named([0.5 * low + 0.5 * high for low, high in box[:-1]])

    def tightened(self, proof: MarginProof, until: float) -> MarginProof:
        """Return the proof of the largest limit found by halving what lies between it and the least margin found.

        Each attempt has half of the time that is left.
        """
        best, least = proof, least_found(self.graph, self.coordinates.ranges, proof.claim)
        beyond = least.margin  # a limit that was not proved
        while best.claim.limit < _NEAR * least.margin < math.inf and beyond - best.claim.limit > _CLOSE * least.margin:
            now = time.monotonic()
            if now >= until or self.stop.is_set():
                break
            part = 0.9 if beyond == least.margin else 0.5
            limit = proof.claim.rounded(best.claim.limit + part * (beyond - best.claim.limit))
            if limit <= best.claim.limit:
                break
            claim = replace(proof.claim, limit=limit)
            tried = self.at(claim, now + 0.5 * (until - now))
            if tried.status == "proved":
                best = tried
                continue
            beyond = limit
            if tried.counterexample is not None:
                margin = margin_of(margins_there(self.graph, claim, tried.counterexample), claim.kind)
                least = LeastFound(margin, tried.counterexample) if margin < least.margin else least
        return replace(best, least=least)


def _checked(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> tuple[str, bool]:
    """Return the margins of a sensor in words, and whether the claim fails for it."""
    found = margins_there(graph, claim, parameters)
    kinds: dict[str, None] = dict.fromkeys(("gain margin", "phase margin", *([claim.kind] if claim.unit else [])))
    known = [
        (kind, replace(claim, kind=kind).shown(value))
        for kind in kinds
        if math.isfinite(value := margin_of(found, kind))
    ]
    words = [text if kind in ("gain margin", "phase margin") else f"{kind} {text}" for kind, text in known]
    return ", ".join(words) if found.stable else found.verdict, margin_of(found, claim.kind) < claim.limit


def _straight(loop: StartingLoop, coordinates: Coordinates) -> Coordinates:
    """Return the coordinates of which each bends less, of a parameter and one divided by it."""

    def bends(of: Coordinates) -> list[float]:
        try:
            return BoxMaps(loop, of.parameters).bends(of.box())
        except UndecidedError:
            return [math.inf] * len(of.ranges)

    with flint.ctx.workprec(BITS):
        for place, bend in enumerate(bends(coordinates)):
            turned = coordinates.turned(place)
            if bend and bends(turned)[place] < bend:
                coordinates = turned
    return coordinates


def _claims(required: Loop | None, name: str, node: Endpoint, given: Mapping[str, str]) -> Iterator[Claim]:
    """Yield the claims about a loop: those given, and without them those that it requires, or the usual ones."""
    at = ".".join(node)
    yield Claim(name, at, "stable", 0.0)
    for kind, usual in USUAL.items():
        limit = _limit(kind, given[kind]) if given[kind] else getattr(required, kind.replace(" ", "_"), None)
        if limit is None:
            limit = usual
        if limit is not None:
            yield Claim(name, at, kind, limit)


def _limit(kind: str, given: str) -> float:
    """Return a limit in the unit of its kind; raises `ModelError`."""
    unit = UNITS[kind]
    try:
        limit = read_requirement(given, unit) if unit in ("dB", "deg", "s") else convert(given, unit)
        if not 0.0 < limit < math.inf and kind in ("disk margin", "delay margin", "decay rate"):
            raise Refusal("must be above zero")
        if kind == "disk margin" and limit >= MOST_DISK:
            raise Refusal("must be below 2", "such a disk is a half plane")
    except Refusal as error:
        raise ModelError([error.problem(kind.replace(" ", "_"), given)]) from None
    return limit


def _continuous(node: Endpoint) -> Problem:
    signal = ".".join(node)
    return Problem(
        message=f"the loop through {signal} lies among continuous blocks, and proofs are about sampled loops",
        key=signal,
        got=shown(signal),
        expected="a loop with a wire that is sampled or held",
        hint="open the loop at a discrete block with --loop, or search with `proofmass worst`",
        path=("blocks", node[0]),
    )
