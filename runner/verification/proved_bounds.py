"""Bounds that a certificate proves, for the report of a study of the same graph."""

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from proofmass.blocks.declaration.problem import Problem
from proofmass.blocks.declaration.shown_units import in_print
from proofmass.graphs.model.loops import VERDICTS
from proofmass.graphs.studies.study import Study
from proofmass.runner.design.proof.claim import KINDS, Claim
from proofmass.runner.design.worst.box import varied
from proofmass.runner.studies.shown.proved import ProvedBound
from proofmass.runner.verification.certificates import graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate

_ROUNDING = 1e-12  # of the ends of a box, relative


def proved_bounds(certificate: str, study: Study, measures: Sequence[str]) -> list[ProvedBound]:
    """Return what a certificate proves about the sensors of a study, with which of its measures.

    Raises `ModelError` for one that proves nothing, or is that of another graph.
    """
    try:
        check_certificate(certificate)
    except FalseCertificateError as error:
        raise _refused(str(error)).error from None
    data = json.loads(certificate)
    if data["graph_sha256"] != graph_digest(study.graph):
        raise _refused("is that of another graph").error
    return list(_bounds(data["claims"], study, measures))


def _bounds(claims: Sequence[Mapping[str, Any]], study: Study, measures: Sequence[str]) -> Iterator[ProvedBound]:
    box = varied(study, {})
    needed = {r.written: (r.low, r.high) for r in (box.hulls() if box else ())}
    for one in claims:
        told: dict[str, Any] = {key: one[key] for key in ("loop", "open_at", "kind", "limit", "period")}
        told |= {key: bool(one.get(key)) for key in ("any_change", "at_rest")}
        told |= {"most": one["most"], "unit_of_quantity": one["unit"]} if KINDS[one["kind"]].of_output else {}
        claim = Claim(**told, changes=tuple(one.get("changes", ())))
        measure = f"{claim.loop}.{claim.kind.replace(' ', '_')}"
        varying = [each for side in one["coordinates"] for each in side.get("product", [side])]
        sides = {each["name"]: _ends(each) for each in varying}
        words = [
            f"{each['name']} from {' to '.join(in_print(end, each['unit'], 6) for end in sides[each['name']])}"
            for each in varying
        ]
        beyond = tuple(name for name, ends in needed.items() if name not in sides or not _within(ends, sides[name]))
        shown = measure if measure in measures else ""
        limit = claim.limit if claim.unit else VERDICTS["stable"]
        yield ProvedBound(shown, f"{claim.about}: {claim}", limit, ", ".join(words) or "nothing varies", beyond)


def _ends(side: Mapping[str, Any]) -> tuple[float, float]:
    low, high = float(side["low"]), float(side["high"])
    return (1.0 / high, 1.0 / low) if side.get("inverse") else (low, high)


def _within(ends: tuple[float, float], whole: tuple[float, float]) -> bool:
    room = _ROUNDING * max(map(abs, whole))
    return whole[0] - room <= ends[0] and ends[1] <= whole[1] + room


def _refused(why: str) -> Problem:
    hint = "prove the study's graph: proofmass prove STUDY --out proof.json"
    return Problem(message=f"the certificate {why}", key="proof", hint=hint)
