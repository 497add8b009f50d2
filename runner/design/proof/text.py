"""Proofs as text for people."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping

from proofmass.blocks.declaration.shown_units import in_print
from proofmass.graphs.model.loops import SETTLED
from proofmass.runner.design.proof.attempt import MarginProof
from proofmass.runner.design.proof.claim import BIAS, Claim
from proofmass.runner.design.proof.digital_inputs import DigitalInput
from proofmass.runner.design.proof.digital_proof import DigitalProof
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.design.worst.ranges import Range
from proofmass.runner.output.counts import count
from proofmass.runner.output.text_table import text_table

_EITHER = "at the start of the run, or at rest where it is said"
_NOTHING_VARIES = 'nothing varies: this is the sensor as it is; --tolerance "BLOCK.PARAMETER=5 %" lets a parameter vary'


def proofs_text(proofs: Proofs) -> str:
    """Return each claim with what came of it, and sensors that break one."""
    lines = ["interrupted: what was proved until then"] if proofs.interrupted else []
    lines += [_box(proofs)] if proofs.proofs else []
    for about in dict.fromkeys(map(_about, proofs.proofs)):
        own = [one for one in proofs.proofs if _about(one) == about]
        lines.append(about)
        lines += text_table(list(_rows(own)), left=(0, 1, 2), indent=2)
    lines += [f"not in it: {name}, since {why}" for name, why in proofs.left_out.items()]
    lost = proofs.lost_workers
    lines += [f"{count(lost, 'worker')} ended early; others did their part"] * (lost > 0)
    return "\n".join([*lines, *_digital(proofs), *_shown(proofs)])


def _rows(proofs: Iterable[MarginProof]) -> Iterator[tuple[str, str, str]]:
    """Yield each claim with what came of it; a reason why several are open is said once."""
    before = ""
    for one in proofs:
        why = _result(one)
        yield str(one.claim), one.status, "for the same reason" if one.status == "open" and why == before else why
        before = why


def _digital(proofs: Proofs) -> Iterator[str]:
    """Yield the claims about the digital part, their inputs, and runs that overflow."""
    for about, own in itertools.groupby(proofs.digital, key=lambda one: one.inputs):
        ranges = list(map(_ends, about))
        yield f"digital part, with any {', '.join(ranges)}" if ranges else "digital part, without inputs"
        yield from text_table([_row(one) for one in own], left=(0, 1, 2), indent=2)
    for run in (proof.run for proof in proofs.digital if proof.run is not None):
        yield f"overflow in tick {run.ticks - 1} of {', '.join(run.overflows) or run.refused}: see it by"
        yield "  proofmass prove GRAPH ... --counterexample overflow.toml; proofmass run overflow.toml"


def _ends(given: DigitalInput) -> str:
    low, high = (in_print(end, given.unit, 6) for end in (given.low, given.high))
    return f"{given.signal} from {low} to {high}"


def _row(proof: DigitalProof) -> tuple[str, str, str]:
    what = f"{proof}" + (f", of {proof.output}" if proof.output else "")
    return what, proof.status, proof.why


def _about(proof: MarginProof) -> str:
    claim = proof.claim
    if claim.row.of_output:
        return f"from {claim.about}" if claim.loop else f"at {claim.about}"
    opened = f", opened at {claim.open_at}" if claim.open_at != claim.loop else ""
    held = ", in continuous time: what discrete blocks give is held" * claim.continuous
    places = (f", at {name} = {_ended(*ends)}" for name, ends in proof.places.items())
    return f"loop {claim.loop}{opened}{held}{''.join(places)}"


def _ended(low: float, high: float) -> str:
    return f"{low:.6g}" if low == high else f"{low:.6g} to {high:.6g}"


def _box(proofs: Proofs) -> str:
    places = {_where(one.claim) for one in proofs.proofs}
    where = places.pop() if len(places) == 1 else _EITHER
    if not proofs.ranges:
        return f"{where}; {_NOTHING_VARIES}"
    rates = proofs.rates or (0.0,) * len(proofs.ranges)
    sides = (
        _side(r, rate) + ", at all ages" * (r.written in proofs.ageing)
        for r, rate in zip(proofs.ranges, rates, strict=True)
    )
    return f"for every sensor, {where}, with {', '.join(sides)}"


def _where(claim: Claim) -> str:
    if claim.orbit:
        return "on an orbit that comes round"
    return "at rest" if claim.at_rest or claim.kind == BIAS else "at the start of the run"


def _side(of: Range, rate: float) -> str:
    low, high = in_print(of.low, of.unit, 6), in_print(of.high, of.unit, 6)
    moves = f", which changes by at most {in_print(rate, of.unit, 6)} in a second" if rate else ""
    return f"{of.written} = {low}" if of.low == of.high else f"{of.written} from {low} to {high}{moves}"


def _result(proof: MarginProof) -> str:
    searched = proof.searched
    looked = f"{count(searched.boxes, 'region')}, {proof.seconds:.1f} s"
    if proof.status == "proved":
        least = proof.least
        return looked + (
            f"; {_found(proof.claim, least.margin)} found" if least and math.isfinite(least.margin) else ""
        )
    if proof.status == "refuted":
        return proof.shown + (" at the sensor below" if proof.counterexample else "")
    part = f"{100.0 * searched.part:.3g} % of the tolerances proved, {looked}; " if searched.boxes else ""
    return f"{part}{searched.why}"


def _found(claim: Claim, value: float) -> str:
    return in_print(value, claim.unit, 8) if claim.row.of_output else f"{value:.4g} {claim.unit}"


def _shown(proofs: Proofs) -> Iterator[str]:
    """Yield what to type to see sensors that break a claim, and the least margins found."""
    for proof in proofs.proofs:
        claim, least = proof.claim, proof.least
        if proof.counterexample is not None:
            yield from _typed(f"not {claim}, of {claim.about}", proofs, claim, proof.counterexample)
        elif least is not None and least.at and math.isfinite(least.margin):
            yield from _typed(
                f"{claim.kind} of {_found(claim, least.margin)}, of {claim.about}", proofs, claim, least.at
            )


def _typed(what: str, proofs: Proofs, claim: Claim, parameters: Mapping[str, float]) -> Iterator[str]:
    units = {r.written: f" {r.unit}" if r.unit not in ("", "1") else "" for r in proofs.ranges}
    held = [name for name in parameters if name in proofs.constants or name not in units]  # which nothing sets
    settings = [f' --set "{name}={value!r}{units[name]}"' for name, value in parameters.items() if name not in held]
    held = [f"{name} = {parameters[name]:.9g}{units.get(name, '')}" for name in held]
    yield f"{', where '.join(filter(None, [what, ', '.join(held)]))}: see it by"
    at = SETTLED if claim.at_rest else '"0 s"'
    command = f"margins GRAPH --at {at} --loop {claim.loop}"
    if claim.kind == BIAS:
        command = f"run GRAPH --probe {claim.open_at}"
    elif claim.row.of_output:
        noise = f"noise GRAPH --output {claim.open_at}"
        command = f"response GRAPH {claim.loop} {claim.open_at} --at {at}" if claim.loop else noise
    yield f"  proofmass {command}{''.join(settings)}"
