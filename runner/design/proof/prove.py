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

from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.graph import Endpoint, Graph
from proofmass.graphs.model.loops import Loop, read_loops
from proofmass.graphs.studies.study import Study
from proofmass.runner.analysis.linearisation.analog_loop import analog_group
from proofmass.runner.analysis.linearisation.linearise import loops_of, node_of, one_loop
from proofmass.runner.derivatives.ball import BITS, UndecidedError
from proofmass.runner.design.proof.ball_map import StartingLoop
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Coordinates, coordinates_of
from proofmass.runner.design.proof.least_found import LeastFound, least_found, margin_of, margins_there
from proofmass.runner.design.proof.search import BoxMaps, Searched, search
from proofmass.runner.design.worst.box import ToleranceBox, box_of
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Told
from proofmass.runner.host.progress import Progress
from proofmass.runner.plan.planned import Plan
from proofmass.runner.planning.plan import plan

GAIN_MARGIN, PHASE_MARGIN, SECONDS = "6 dB", "45 deg", 60.0
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
    bounds: bool = False,
    seconds: float = SECONDS,
    progress: Progress | None = None,
) -> Proofs:
    """Prove that no sensor within tolerances is unstable or has less than these margins, or show one that has.

    `source` is a graph, or a study, whose spread counts as tolerances: three standard deviations of normal parameters.
    `tolerances` maps parameters to "5 %", to a width with a unit or to a list of two values. `loop` names one loop;
    unless given, all of them count. `gain_margin` and `phase_margin` are limits such as "10 dB" and "60 deg"; unless
    given, those that a loop requires, else 6 dB and 45 deg. With `bounds` the largest margins that can be proved are
    looked for beyond these, beside the least that are found. The search ends after so many `seconds`; `progress` is
    called with the claims that are done and all claims.

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
    claims = [
        (node, list(_claims(planned.graph.loops.get(name), name, node, gain_margin, phase_margin)))
        for name, node in loops.items()
    ]
    proofs = list[MarginProof]()
    every = sum(len(wanted) for _, wanted in claims)
    with interrupts() as stop:
        for proof in _proofs(graph, planned, claims, coordinates, bounds, seconds, stop):
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
    """Prove one margin of a loop, "gain margin" in dB, "phase margin" in deg or "stable", as `prove` does all of them.

    Raises `ModelError`.
    """
    graph, _, coordinates = _varied(source, tolerances)
    planned = plan(graph)
    name, node = one_loop(planned, loop)
    claim = Claim(name, ".".join(node), kind, limit)
    with interrupts() as stop:
        return next(_proofs(graph, planned, [(node, [claim])], coordinates, False, seconds, stop))


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
        for claim in wanted:
            now = time.monotonic()
            search_ends = now + (end - now) / left
            proof = _proof(graph, maps, straight, claim, search_ends, stop)
            if bounds and proof.status == "proved" and claim.unit:
                proof = _tightened(graph, maps, straight, proof, search_ends, stop)
            left -= 1
            yield proof


def _starting(planned: Plan, node: Endpoint) -> StartingLoop:
    if analog_group(planned, node) is not None:
        raise ModelError([planned.graph.placed(_continuous(node))])
    return StartingLoop(planned, node)


def _proof(
    graph: Graph, maps: BoxMaps, coordinates: Coordinates, claim: Claim, until: float, stop: threading.Event
) -> MarginProof:
    begin = time.monotonic()
    searched = search(maps, claim.factor, (*coordinates.box(), claim.ends), until, stop)
    counterexample, text = None, ""
    if searched.status == "refuted" and searched.at is not None:
        counterexample = coordinates.named([0.5 * low + 0.5 * high for low, high in searched.at[:-1]])
        text, fails = _checked(graph, claim, counterexample)
        if not fails:
            why = f"a pole lies at the boundary of stability, at margins of {text}"
            searched, counterexample, text = replace(searched, status="open", why=why), None, ""
    return MarginProof(claim, searched, time.monotonic() - begin, coordinates, counterexample, text)


def _checked(graph: Graph, claim: Claim, parameters: Mapping[str, float]) -> tuple[str, bool]:
    """Return the margins of a sensor in words, and whether the claim fails for it."""
    found = margins_there(graph, claim, parameters)
    gain, phase = (margin_of(found, kind) for kind in ("gain margin", "phase margin"))
    known = [f"{value:.4g} {unit}" for value, unit in ((gain, "dB"), (phase, "deg")) if math.isfinite(value)]
    return ", ".join(known) if found.stable else found.verdict, margin_of(found, claim.kind) < claim.limit


def _tightened(
    graph: Graph, maps: BoxMaps, coordinates: Coordinates, proof: MarginProof, until: float, stop: threading.Event
) -> MarginProof:
    """Return the proof of the largest limit found by halving what lies between it and the least margin found.

    Each attempt has half of the time that is left.
    """
    best, least = proof, least_found(graph, coordinates.ranges, proof.claim)
    beyond = least.margin  # a limit that was not proved
    while best.claim.limit < _NEAR * least.margin < math.inf and beyond - best.claim.limit > _CLOSE * least.margin:
        now = time.monotonic()
        if now >= until or stop.is_set():
            break
        part = 0.9 if beyond == least.margin else 0.5
        limit = math.floor(100.0 * (best.claim.limit + part * (beyond - best.claim.limit))) / 100.0
        if limit <= best.claim.limit:
            break
        claim = replace(proof.claim, limit=limit)
        tried = _proof(graph, maps, coordinates, claim, now + 0.5 * (until - now), stop)
        if tried.status == "proved":
            best = tried
            continue
        beyond = limit
        if tried.counterexample is not None:
            margin = margin_of(margins_there(graph, claim, tried.counterexample), claim.kind)
            least = LeastFound(margin, tried.counterexample) if margin < least.margin else least
    return replace(best, least=least)


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


def _claims(required: Loop | None, name: str, node: Endpoint, gain_margin: str, phase_margin: str) -> Iterator[Claim]:
    at = ".".join(node)
    own = {key: value for key, value in (("gain_margin", gain_margin), ("phase_margin", phase_margin)) if value}
    read, problems = read_loops({"loop": {"open_at": at, **own}}, lambda _: True)
    if problems:
        raise ModelError(
            [
                Problem(message=p.message, key=p.key.split(".")[-1], got=p.got, expected=p.expected, hint=p.hint)
                for p in problems
            ]
        )
    yield Claim(name, at, "stable", 0.0)
    for kind, key, usual in (("gain margin", "gain_margin", 6.0), ("phase margin", "phase_margin", 45.0)):
        given = getattr(read["loop"], key)
        limit = given if given is not None else (getattr(required, key) if required else None)
        yield Claim(name, at, kind, usual if limit is None else limit)


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
