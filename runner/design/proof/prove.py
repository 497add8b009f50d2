"""Proofs over tolerances: no sensor whose parameters lie in a box has less than these margins.

A loop has a gain margin of m where all factors from 1/m to m at its wire leave it stable, and a
phase margin of p where all turns from -p to p do; both are boxes with one more coordinate. What is
proved is a theorem about the functions of the blocks in real numbers; rounding in a run is not a
part of it, and the loop is that of the start of the run.
"""

import math
import threading
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import Any

from threadpoolctl import threadpool_limits

from proofmass.blocks.declaration.problem import ModelError, Problem, shown
from proofmass.graphs.files.toml_reader import GraphSource, graph_from
from proofmass.graphs.model.call_numbers import positive, refuse_counts
from proofmass.graphs.model.graph import Graph
from proofmass.graphs.model.loops import AUTO
from proofmass.graphs.studies.study import Study
from proofmass.runner.derivatives.ball import UndecidedError, enclosing
from proofmass.runner.design.proof.attempt import Attempt, KnownProofs, MarginProof
from proofmass.runner.design.proof.ball_map import Starting
from proofmass.runner.design.proof.box_maps import BoxMaps
from proofmass.runner.design.proof.claim import BIAS, PEAK, RMS, SCALE_FACTOR, Claim
from proofmass.runner.design.proof.constants_and_rates import change_rates, with_constants
from proofmass.runner.design.proof.coordinates import Coordinates, coordinates_of
from proofmass.runner.design.proof.digital_proof import DigitalProof, DigitalProofs
from proofmass.runner.design.proof.least_found import Sensors
from proofmass.runner.design.proof.products import with_products
from proofmass.runner.design.proof.rest_maps import TIME_IS_UP
from proofmass.runner.design.proof.search import Searched
from proofmass.runner.design.proof.wanted import RestRuns, Subject, about_loops, about_margin, about_outputs
from proofmass.runner.design.worst.box import ToleranceBox, varied
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.host.interrupts import interrupts
from proofmass.runner.host.notebook import Told
from proofmass.runner.host.processors import processors
from proofmass.runner.host.progress import Progress
from proofmass.runner.planning.plan import plan

SECONDS = 60.0
MOST_WORKERS = 1024
_BLAS = "blas"  # which has one thread while a proof is searched: with several they wait, since matrices are small
_STAY = "it is that of parameters that stay as they are"
_MOVES = "where a sensor rests is known for parameters that stay as they are"
_WHOLE_DELAYS = "the wire has several values in a period, and its delay margin is a count of them"


@dataclass(frozen=True, eq=False, repr=False)
class Proofs(Told):
    """All claims about a graph within tolerances.

    >>> from proofmass import prove, read_graph
    >>> found = prove(read_graph("library:closed_loop_accelerometer"), tolerances={"torquer.gain": "5 %"})
    >>> for proof in found.proofs:
    ...     print(proof.claim, proof.status)
    stable proved
    gain margin of at least 6 dB proved
    phase margin of at least 45 deg proved
    """

    graph: Graph  # whose sensors they are about
    ranges: tuple[Range, ...]  # of the parameters
    proofs: tuple[MarginProof, ...]  # one of each claim
    interrupted: bool  # True after Ctrl-C
    left_out: Mapping[str, str]  # what varies and does not count, with its reason
    digital: tuple[DigitalProof, ...] = ()  # one of each claim about the digital part
    constants: frozenset[str] = frozenset()  # ranges that are constant values of sources
    lost_workers: int = 0  # processes that ended early: others did their part
    rates: tuple[float, ...] = ()  # at which the parameters of the ranges may change, in their units per second
    ageing: frozenset[str] = frozenset()  # ranges that hold all that a parameter is at the ages of a study

    @property
    def proved(self) -> bool:
        """True if all claims are proved."""
        return all(
            status == "proved" for status in (one.status for part in (self.proofs, self.digital) for one in part)
        )

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "graph": self.graph.name,
            "ranges": {
                r.written: {"nominal": r.nominal, "low": r.low, "high": r.high, "unit": r.unit} for r in self.ranges
            },
            "proofs": [proof.as_data() for proof in self.proofs],
            "digital": [proof.as_data() for proof in self.digital],
            "proved": self.proved,
            "interrupted": self.interrupted,
            "constants": sorted(self.constants),
            **({"rates": [*self.rates]} if self.rates else {}),
            **({"ageing": sorted(self.ageing)} if self.ageing else {}),
            **({"lost_workers": self.lost_workers} if self.lost_workers else {}),
            "left_out": dict(self.left_out),
        }


def prove(
    source: GraphSource | Study,
    loop: str = "",
    *,
    tolerances: Mapping[str, Any] | None = None,
    gain_margin: str = "",
    phase_margin: str = "",
    disk_margin: str | float = "",
    delay_margin: str = "",
    decay_rate: str = "",
    input: str = "",
    scale_factor: Mapping[str, Any] | None = None,
    bias: Mapping[str, Any] | None = None,
    peak: Mapping[str, Any] | None = None,
    noise: Mapping[str, Any] | None = None,
    no_overflow: bool = False,
    rounding: Mapping[str, Any] | None = None,
    input_ranges: Mapping[str, Any] | None = None,
    at: str = AUTO,
    constants: Mapping[str, Any] | None = None,
    any_change: bool = False,
    slow_change: str | Mapping[str, Any] = "",
    bounds: bool = False,
    seconds: float = SECONDS,
    workers: int | None = None,
    progress: Progress | None = None,
    known: KnownProofs | None = None,
) -> Proofs:
    """Prove that no sensor within tolerances is unstable or has less than these margins, or show one that has.

    `source` is a graph, or a study, whose spread counts as tolerances: three standard deviations of
    normal parameters. `tolerances` maps parameters to "5 %", to a width with a unit or to a list of
    two values. `loop` names one loop; unless given, all of them count. `gain_margin` and
    `phase_margin` are limits such as "10 dB" and "60 deg"; unless given, those that a loop
    requires, else 6 dB and 45 deg. A `disk_margin` such as 0.5, a `delay_margin` such as "100 us"
    and a `decay_rate` of the slowest pole such as "50 1/s" are proved besides if they are given.

    `scale_factor` maps outputs to limits from an `input`, such as "1.9..2.1", `peak` maps outputs
    to the largest gain from the `input` at any frequency, and `noise` maps outputs to the most rms
    that they may have. `bias` maps outputs to limits of the value at which they rest while the
    `input` is zero. Without a limit, "", the nearest is looked for that can be proved. Where these
    are given, loops count only if one is named, or a margin.

    With `no_overflow`, no number of a block in fixed point overflows, from the start of the run on.
    `rounding` maps outputs in fixed point to the most that all rounding may move them, or to "" for
    the least that can be proved. Both hold for all that converters into fixed point can give;
    `input_ranges` has narrower ranges, such as "-1..1", of wires into a FixedQuantiser.
    Coefficients are those of the sensor as it is.

    With `any_change` the parameters may have other values within their tolerances in each period of
    the loop, held within it: however fast they change, loops stay stable with all factors of their
    margins, and noise has its limit. With a `slow_change` such as "1 %/s" they may change so fast;
    a mapping has rates of some parameters, and those of the others as "". Loops then stay stable
    with all factors of their margins, which stay.

    With `bounds` the best limits that can be proved are looked for beyond these, beside the worst
    that are found. The search ends after so many `seconds`. A search that takes long goes on in
    `workers`, processes, as many as there are processors unless given; they change no bit.
    `progress` is called with the claims that are done and all claims. `known` has what an earlier
    search proved, which is not searched again.

    Claims are about the start of the run, and where that changes later about the point where the
    sensor rests, or the orbit that it goes round, unless `at` is "0 s" or "settled". A sensor rests
    if its sources are constant, and goes round an orbit if they come round: `constants` maps
    outputs of sources to constant values. A loop without either is open, with the reason. Blocks
    compute in real numbers, and converters do
    not round. Raises `ModelError` for what is wrong with the graph or the tolerances.

    >>> from proofmass import prove, read_graph
    >>> prove(read_graph("library:closed_loop_accelerometer"), gain_margin="20 dB").proved
    True
    """
    graph, box = _read(source, tolerances or {})
    ranges = box.hulls() if box else []
    held = ({input: 0.0} if bias and input else {}) | dict(constants or {})
    planned = plan(graph)
    sensor, of_constants = with_constants(graph, planned, held, ranges)
    planned = plan(sensor) if held else planned
    coordinates, rests = coordinates_of(planned, ranges + of_constants), RestRuns(planned, at)
    margins = {
        "gain margin": gain_margin,
        "phase margin": phase_margin,
        "disk margin": disk_margin,
        "delay margin": delay_margin,
        "decay rate": decay_rate,
    }
    given = {kind: str(limit) for kind, limit in margins.items()}
    limits = {SCALE_FACTOR: scale_factor, BIAS: bias, PEAK: peak, RMS: noise}
    subjects = about_outputs(planned, input, limits)
    of_digital = [""] * no_overflow + [*(rounding or {})]
    if input_ranges and not of_digital:
        raise _of_nothing(", ".join(input_ranges)).error
    if loop or any(given.values()) or not (subjects or of_digital):
        subjects = [*about_loops(planned, loop, at, given), *subjects]
    if any_change and slow_change:
        raise _both_changes(slow_change).error
    refuse_counts(workers=(workers or processors(), 1, MOST_WORKERS))
    if not (seconds == 0 or positive(seconds)):
        raise Problem(message="must be finite and at least 0", key="seconds", got=shown(seconds)).error
    rates = change_rates(slow_change, coordinates.ranges)
    subjects = [(begin, [replace(one, any_change=any_change) for one in own]) for begin, own in subjects]
    proofs = dict[Claim, MarginProof]()
    digital = list[DigitalProof]()
    every = sum(len(own) for _, own in subjects) + len(of_digital)
    with interrupts() as stop, threadpool_limits(1, _BLAS):
        part = DigitalProofs(planned, input_ranges or {}, stop, time.monotonic() + seconds)
        for output in of_digital:
            digital.append(part.rounding(output, (rounding or {})[output]) if output else part.no_overflow())
            if progress is not None:
                progress(len(digital), every)
        end, count, none = time.monotonic() + seconds, workers or processors(), KnownProofs(())
        proving = _Proving(sensor, rests, coordinates, bounds, end, stop, known or none, count, rates)
        for proof in proving.proofs(subjects):
            proofs[proof.claim] = proof
            if progress is not None:
                progress(len(digital) + len(proofs), every)
        names = frozenset(r.written for r in of_constants)
        return Proofs(
            graph,
            coordinates.ranges,
            tuple(proofs.values()),
            stop.is_set(),
            box.left_out if box else {},
            tuple(digital),
            names,
            sum(proving.lost),
            rates,
            box.ageing if box else frozenset(),
        )


def prove_margin(
    source: GraphSource | Study,
    loop: str,
    kind: str,
    limit: float,
    tolerances: Mapping[str, Any],
    seconds: float = SECONDS,
    at: str = AUTO,
) -> MarginProof:
    """Prove one of `KINDS` of a loop, "gain margin" in dB or "stable", as `prove` does all of them.

    Raises `ModelError`.
    """
    graph, box = _read(source, tolerances or {})
    planned = plan(graph)
    subjects, rests = [about_margin(planned, loop, at, kind, limit)], RestRuns(planned, at)
    coordinates, none = coordinates_of(planned, box.hulls() if box else []), KnownProofs(())
    with interrupts() as stop, threadpool_limits(1, _BLAS):
        proving = _Proving(graph, rests, coordinates, False, time.monotonic() + seconds, stop, none, processors())
        return next(proving.proofs(subjects))


def _read(source: GraphSource | Study, tolerances: Mapping[str, Any]) -> tuple[Graph, ToleranceBox | None]:
    """Return the graph, and the box of what varies, if anything does."""
    study = source if isinstance(source, Study) else graph_from(source)
    return study.graph if isinstance(study, Study) else study, varied(study, tolerances)


@dataclass(frozen=True)
class _Proving:
    """Searches for all claims, which share the sensors, the time that is left, and processes."""

    graph: Graph
    rests: RestRuns
    coordinates: Coordinates
    bounds: bool
    end: float  # of the time, by the clock of `time.monotonic`
    stop: threading.Event
    known: KnownProofs
    workers: int
    rates: tuple[float, ...] = ()  # of changes of parameters, per second; none without
    lost: list[int] = field(default_factory=list)  # those that ended early, for each loop or path

    def proofs(self, subjects: Sequence[Subject]) -> Iterator[MarginProof]:
        """Yield what comes of each claim about some loops and paths; all share the time left.

        Claims that are open since their part of the time was up come again, if others left some.
        """
        left = sum(len(wanted) for _, wanted in subjects)
        for start, wanted in subjects:
            try:
                starting, rest = self.rests.begun(start, wanted[0], self._is_over)
            except ModelError as error:
                yield from (_open(claim, error) for claim in wanted)
                left -= len(wanted)
                continue
            coordinates = self.coordinates.beside([] if rest is None else rest.ranges)
            stays = rest is None and not (self.rates or any(one.any_change or one.row.of_output for one in wanted))
            straight = _straight(starting, with_products(starting, coordinates) if stays else coordinates)
            maps = BoxMaps(starting, straight.parameters)
            period, at_rest, orbit = starting.period, rest is not None, 0.0 if rest is None else rest.orbit
            changes = straight.changes(self.rates, period or 1.0)  # in continuous time in a second
            attempt = Attempt(Sensors(self.graph, rest), maps, straight, self.stop, self.known, self.workers)
            late = list[MarginProof]()
            with closing(attempt.ahead):
                for wish in wanted:
                    own = replace(wish, period=period, continuous=not period, changes=changes)
                    claim = replace(own, at_rest=at_rest, orbit=orbit)
                    proof = self._proof(attempt, claim, left)
                    yield proof
                    late += [proof] if proof.claim == claim and proof.searched.why == TIME_IS_UP else []
                    left -= 1
                for number, proof in enumerate(late):
                    if not self._is_over():
                        yield attempt.further(proof, self._part(left + len(late) - number))
                self.lost.append(attempt.ahead.died)

    def _is_over(self) -> bool:
        return self.stop.is_set() or time.monotonic() >= self.end

    def _part(self, left: int) -> float:
        """Return when the time of the first of so many claims that are left is up."""
        now = time.monotonic()
        return now + (self.end - now) / left

    def _proof(self, attempt: Attempt, claim: Claim, left: int) -> MarginProof:
        if why := _why_open(claim, attempt.maps.values):
            return MarginProof(claim, Searched("open", (), 0, 0.0, None, why), 0.0)
        try:
            return _proof(attempt, claim, self.bounds, self._part(left))
        except ModelError as error:  # a sensor within the tolerances has no such figure
            return _open(claim, error)


def _proof(attempt: Attempt, claim: Claim, bounds: bool, until: float) -> MarginProof:
    """Return what comes of a claim, with `bounds` of the best limit; raises `ModelError`."""
    if not math.isfinite(claim.limit):
        return attempt.bounded(claim, until)
    proof = attempt.at(claim, until)
    if bounds and proof.status == "proved" and claim.row.of_output:
        nearer = attempt.bounded(claim, until)
        return nearer if nearer.claim.broken_by(claim.limit) else replace(proof, least=nearer.least)
    return attempt.tightened(proof, until) if bounds and proof.status == "proved" and claim.unit else proof


def _open(claim: Claim, error: ModelError) -> MarginProof:
    hint = next((problem.hint for problem in reversed(error.problems) if problem.hint), "")
    words = [*(problem.message for problem in error.problems), *filter(None, [hint])]
    why = "; ".join(dict.fromkeys(words))
    return MarginProof(claim, Searched("open", (), 0, 0.0, None, why), 0.0)


def _why_open(claim: Claim, values: int) -> str:
    """Return why a claim is not searched, "" for one that is."""
    if claim.moves and (claim.row.stays or claim.at_rest):
        return _STAY if claim.row.stays else _MOVES
    return _WHOLE_DELAYS if claim.kind == "delay margin" and values > 1 else ""


def _straight(loop: Starting, coordinates: Coordinates) -> Coordinates:
    """Return the coordinates of which each bends less, of a parameter and one divided by it."""

    def bend(of: Coordinates, place: int) -> float:
        try:
            return BoxMaps(loop, of.parameters).bend(of.box(), place)
        except UndecidedError:
            return math.inf

    with enclosing():
        for place in range(len(coordinates.ranges)):
            turned = coordinates.turned(place)
            own = bend(coordinates, place)
            if own and bend(turned, place) < own:
                coordinates = turned
    return coordinates


def _both_changes(slow_change: Any) -> Problem:
    return Problem(
        message="parameters that change at will do not change slowly",
        key="slow_change",
        got=shown(slow_change),
        hint="ask for --any-change or for --slow-change",
    )


def _of_nothing(signals: str) -> Problem:
    return Problem(
        message="ranges of inputs are those of claims about the digital part, and there is none",
        key="input_ranges",
        got=signals,
        hint="ask for --no-overflow or --rounding OUTPUT too",
    )
