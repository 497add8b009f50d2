"""Searches about one loop or path: what comes of a claim, and the best limit that can be proved.

What an earlier search proved is known from its certificate: boxes with their norms, each of which
is proved anew.
"""

import json
import math
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from proofmass.blocks.declaration.shown_units import in_print
from proofmass.runner.design.proof.box_maps import BoxMaps
from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Coordinates, Sides
from proofmass.runner.design.proof.least_found import (
    LeastFound,
    Sensors,
    least_found,
    margin_of,
    margins_there,
    quantity_there,
    worst_of,
)
from proofmass.runner.design.proof.look import BoxLook, Looked
from proofmass.runner.design.proof.rest_norm import Start
from proofmass.runner.design.proof.search import LooksAhead, ProofSearch, Searched
from proofmass.runner.host.arrays import Array

_NEAR, _CLOSE = 0.97, 0.02  # of the least margin found: a bound near it, and two alike
_ROOM = 0.25  # of the way from nominal to worst: so far beyond that a limit is tried
_FINER, _CLOSEST = 4.0, 0.01  # by which that room grows or shrinks, and the part of the way that is near enough
_SMALLEST = 1e-12  # room beside a value of zero
_WIDENED = 8  # times
_SAME = tuple(each.name for each in fields(Claim) if each.name != "unit_of_quantity")


@dataclass(frozen=True)
class KnownProofs:
    """Claims of a certificate, as plain data, the proved ones and those that are proved in part."""

    claims: Sequence[Mapping[str, Any]]

    def leaves(self, claim: Claim, coordinates: Sequence[Mapping[str, Any]]) -> dict[Sides, Start]:
        """Return the boxes of a claim over the same coordinates, with their norms."""
        wanted = [getattr(claim, key) for key in _SAME] + [list(coordinates)]
        for one in self.claims:
            own = {**one, "changes": tuple(one.get("changes", ()))}
            if [own.get(key, False) for key in (*_SAME, "coordinates")] == wanted:
                return {_sides(leaf["box"]): _start(leaf) for leaf in one["leaves"]}
        return {}


def known_proofs(certificate: str, graph_sha256: str) -> KnownProofs:
    """Return what a certificate of the same graph has; nothing if it is that of another, or cannot be read."""
    try:
        data = json.loads(certificate)
        same = data["graph_sha256"] == graph_sha256
        return KnownProofs((*data["claims"], *data["unfinished"]) if same else ())
    except (ValueError, KeyError, TypeError):
        return KnownProofs(())


def _start(leaf: Mapping[str, Any]) -> Start:
    frame, left = (np.array(leaf[name], dtype=float) if name in leaf else None for name in ("frame", "left"))
    return _start_of(np.array(leaf["transform"], dtype=float), frame, left)


def _start_of(transform: Array, frame: Array | None, left: Array | None) -> Start:
    """Return where a search begins: the transformation of states, which may be told in coordinates of a `frame`."""
    if frame is not None:
        transform = np.asarray(np.kron(np.eye(len(transform) // len(frame)), frame) @ transform, dtype=np.float64)
    return Start(transform, left)


def _sides(box: Sequence[Sequence[float]]) -> Sides:
    return tuple((float(low), float(high)) for low, high in box)


@dataclass(frozen=True)
class MarginProof:
    """A claim, what came of it, and the parameters of a sensor that breaks it, if one was found."""

    claim: Claim
    searched: Searched
    seconds: float
    coordinates: Coordinates | None = None
    counterexample: Mapping[str, float] | None = None
    shown: str = ""  # the margins of that sensor, or its value
    value: float = math.nan  # its value of what the claim is about
    least: LeastFound | None = None  # the worst that was found, if the best bound was looked for

    @property
    def status(self) -> str:
        """ "proved", "refuted" or "open"."""
        return self.searched.status

    @property
    def places(self) -> dict[str, tuple[float, float]]:
        """The ranges of what comes to no rest, at each place of which the claim is."""
        known = self.coordinates
        return {r.name: (r.low, r.high) for r in known.ranges if r.name in known.places} if known else {}

    def as_data(self) -> dict[str, Any]:
        """Plain data, for `--json`."""
        return {
            "loop": self.claim.loop,
            "open_at": self.claim.open_at,
            "claim": str(self.claim),
            "kind": self.claim.kind,
            "limit": self.claim.limit if math.isfinite(self.claim.limit) else None,
            "at_rest": self.claim.at_rest,
            **({"orbit": self.claim.orbit} if self.claim.orbit else {}),
            **({"places": places} if (places := self.places) else {}),
            "side": "at most" if self.claim.most else "at least",
            "status": self.status,
            "part": self.searched.part,
            "boxes": self.searched.boxes,
            "seconds": self.seconds,
            "why": self.searched.why,
            "counterexample": None if self.counterexample is None else dict(self.counterexample),
            "margins_there": self.shown,
            "least_found": self.least and self.least.as_data(),
        }


@dataclass(frozen=True)
class Attempt:
    """Searches about one loop or path."""

    sensors: Sensors
    maps: BoxMaps
    coordinates: Coordinates
    stop: threading.Event
    known: KnownProofs
    workers: int = 1

    @cached_property
    def ahead(self) -> LooksAhead:
        """Looks at boxes, in as many processes as there may be."""
        return LooksAhead(self.look, self.workers)

    def look(self, claim: Claim, whole: Sides, box: Sides, start: Start | None) -> Looked:
        """Return what comes of a box, part of a whole, for a claim; raises `ModelError`."""
        return BoxLook(self.maps, claim, whole, lambda part: self._breaks(claim, part)).at(box, start)

    def at(self, claim: Claim, until: float) -> MarginProof:
        """Return what comes of a claim, of which the nominal sensor is looked at first."""
        if claim.row.at_corners is None:  # whose search begins with the corners
            value, text, fails = _checked(self.sensors, claim, self._nominal)
            if fails:
                return self._refuted(claim, self._nominal, text, value)
        if not claim.moves:
            return self._searched(claim, until)
        now = time.monotonic()
        proof = self._searched(claim, now + 0.5 * (until - now))
        if proof.status != "open":
            return proof
        still = self._searched(replace(claim, any_change=False, changes=()), until)
        if still.status == "refuted":
            return replace(still, claim=claim)
        why = f"{proof.searched.why}; with parameters that stay it is {still.status}"
        return replace(proof, searched=replace(proof.searched, why=why), seconds=proof.seconds + still.seconds)

    @property
    def _nominal(self) -> dict[str, float]:
        return {r.written: r.nominal for r in self.coordinates.tolerances}

    def _refuted(self, claim: Claim, at: Mapping[str, float], text: str, value: float) -> MarginProof:
        """Return that a sensor breaks a claim, for which nothing was searched."""
        return MarginProof(claim, Searched("refuted", (), 0, 0.0), 0.0, self.coordinates, at, text, value)

    def further(self, proof: MarginProof, until: float) -> MarginProof:
        """Return what comes of a claim that was left open since its time was up, from what is proved of it on."""
        leaves = proof.searched.leaves
        known = {leaf.core: _start_of(leaf.transform, leaf.loops.frame, leaf.left) for leaf in leaves}
        found = self._searched(proof.claim, until, known)
        return replace(found, seconds=proof.seconds + found.seconds)

    def _searched(self, claim: Claim, until: float, known: Mapping[Sides, Start] | None = None) -> MarginProof:
        begin = time.monotonic()
        known = self.known.leaves(claim, self.coordinates.as_data()) if known is None else known
        whole = (*self.coordinates.box(), claim.ends)
        searched = ProofSearch(
            claim, whole, self.ahead, lambda: time.monotonic() > until or self.stop.is_set(), known
        ).outcome()
        counterexample, text, value = None, "", math.nan
        if searched.status == "refuted" and searched.at is not None:
            counterexample = self._middle(searched.at)
            value, text, fails = _checked(self.sensors, claim, counterexample)
            if not fails:
                why = f"a pole lies at the boundary of stability, at margins of {text}"
                searched, counterexample, text = replace(searched, status="open", why=why), None, ""
        return MarginProof(claim, searched, time.monotonic() - begin, self.coordinates, counterexample, text, value)

    def _breaks(self, claim: Claim, box: Sides) -> bool:
        """Return whether the middle of a box breaks a claim: where no disc has its poles, of one disc alone."""
        return not claim.row.looks or _checked(self.sensors, claim, self._middle(box))[2]

    def _middle(self, box: Sides) -> dict[str, float]:
        return self.coordinates.named([0.5 * low + 0.5 * high for low, high in box[:-1]])

    def tightened(self, proof: MarginProof, until: float) -> MarginProof:
        """Return the proof of the largest limit found by halving what lies between it and the least margin found.

        Each attempt has half of the time that is left.
        """
        best, least = proof, least_found(self.sensors, self.coordinates.tolerances, proof.claim)
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
            tried = self._searched(claim, now + 0.5 * (until - now))
            if tried.status == "proved":
                best = tried
                continue
            beyond = limit
            if tried.counterexample is not None:
                least = worst_of([least, LeastFound(tried.value, tried.counterexample)], claim)
        return replace(best, least=least)

    def bounded(self, claim: Claim, until: float) -> MarginProof:
        """Return the proof of the limit of a quantity that lies nearest beyond the worst value that is found.

        The room between both is widened until there is a proof, then narrowed until there is none.
        Each attempt has half of the time that is left.
        """
        least = least_found(self.sensors, self.coordinates.tolerances, claim)
        nominal, rounding = quantity_there(self.sensors, claim, self._nominal)
        way = abs(nominal - least.margin)
        if not math.isfinite(way):
            value, text, _ = _checked(self.sensors, claim, least.at)
            return self._refuted(claim, least.at, text, value)
        close = max(_CLOSEST * way, claim.row.room * abs(nominal), rounding) or _SMALLEST
        room, best, tries = max(_ROOM * way, _FINER * close), None, 0
        while True:
            now = time.monotonic()
            limit = beyond(least.margin, claim.sign, room)
            tried = self._searched(replace(claim, limit=limit), now + 0.5 * (until - now))
            if tried.counterexample is not None:
                least = worst_of([least, LeastFound(tried.value, tried.counterexample)], claim)
            proved, tries = tried.status == "proved", tries + 1
            best = tried if proved or best is None else best
            narrows = best.status == "proved"
            late = time.monotonic() >= until or self.stop.is_set() or tries > _WIDENED
            if late or (narrows and (not proved or room <= close)) or not math.isfinite(least.margin):
                return replace(best, least=least)
            room = max(room / _FINER, close) if narrows else room * _FINER


def beyond(value: float, sign: float, room: float) -> float:
    """Return a number of few digits that lies beyond a value by about some room: below it where the sign is 1.

    >>> beyond(-8827.4014, 1.0, 0.3), beyond(0.25, -1.0, 1e-3)
    (-8827.71, 0.251)
    """
    digits = 1 - math.floor(math.log10(room))
    scale = 10.0**digits
    return sign * math.floor((sign * value - room) * scale + 1e-9) / scale


def _checked(sensors: Sensors, claim: Claim, parameters: Mapping[str, float]) -> tuple[float, str, bool]:
    """Return the value of a sensor, its figures in words, and whether the claim fails."""
    if claim.row.of_output:
        value, rounding = quantity_there(sensors, claim, parameters)
        shown = f"{claim.kind} {in_print(value, claim.unit, 8)}" if math.isfinite(value) else claim.row.nowhere
        return value, shown, claim.broken_by(value + claim.sign * rounding)
    found = margins_there(sensors, claim, parameters)
    kinds: dict[str, None] = dict.fromkeys(("gain margin", "phase margin", *([claim.kind] if claim.unit else [])))
    known = [
        (kind, replace(claim, kind=kind).shown(value))
        for kind in kinds
        if math.isfinite(value := margin_of(found, kind))
    ]
    words = [text if kind in ("gain margin", "phase margin") else f"{kind} {text}" for kind, text in known]
    value = margin_of(found, claim.kind)
    return value, ", ".join(words) if found.stable else found.verdict, value < claim.limit
