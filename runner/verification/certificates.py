"""Proofs as certificates: all a checker needs to verify them, and what it takes for granted."""

import hashlib
import json
from typing import Any

from proofmass.graphs.files.toml_writer import write_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof.attempt import MarginProof
from proofmass.runner.design.proof.closed_loop import OpenCorners
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.digital_map import AffineNumber, DigitalMap
from proofmass.runner.design.proof.digital_proof import DigitalProof
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.fixed.affine import AffineMantissa
from proofmass.runner.host.versions import version
from proofmass.runner.verification.proof_checker import FORMAT, digest_of

ASSUMED = (
    "The matrices enclose those of the graph: they come from its functions, called with intervals of numbers.",
    "Blocks compute in real numbers: the rounding of doubles in a run is not a part of the proof.",
    "Parameters of a product act on their loop as that alone: its functions, called with powers, have the same power.",
    "Loops are those of the start of the run, tick 0, or at rest. Quantisers count as a gain of one, limits by slopes.",
    "At rest sources are constant: where a sensor rests is that of ideal converters, which do not round.",
    "On an orbit sources come round as their frequencies say. It is a point of rest of all its periods at once.",
    "A BLOCK:NUMBER comes to no rest, as the phase of a carrier: loops are those about each of its places.",
    "It passes them slowly, where numbers follow it; of whole turns, and of a ramp between its falls, nothing does.",
    "Loops in continuous time are those of the differential equations: what discrete blocks give is held.",
    "Parameters stay as they are while the sensor runs; under any or slow change within each period of the loop.",
    "In fixed point the map, errors and ranges are those of the blocks, called with sums of registers and inputs.",
    "What enters fixed point is within the steps that are said; blocks outside the map may give all that they hold.",
    "Sources of noise are those of the sensor as it is: white, independent, errors of quantisers uniform over a step.",
)


def certificate(proofs: Proofs) -> str:
    """Return the certificate of all that is proved, as JSON."""
    loops: list[dict[str, Any]] = []
    places: dict[str, int] = {}
    content: dict[str, Any] = {
        "format": FORMAT,
        "version": version("proofmass"),
        "graph": proofs.graph.name,
        "graph_sha256": graph_digest(proofs.graph),
        "assumed": list(ASSUMED),
        "claims": [_claim(one, loops, places) for one in proofs.proofs if one.status == "proved"],
        "unfinished": [
            _claim(one, loops, places) for one in proofs.proofs if one.status == "open" and one.searched.leaves
        ],
        "loops": loops,
        "digital": [_digital(one, one.map) for one in proofs.digital if one.status == "proved" and one.map],
    }
    return json.dumps(content | {"sha256": digest_of(content)}, sort_keys=True, allow_nan=False) + "\n"


def graph_digest(graph: Graph) -> str:
    """Return the SHA-256 of a graph, whatever its comments and the order of its keys."""
    return hashlib.sha256(write_graph(graph).encode()).hexdigest()


def graph_of_certificate(text: str) -> str:
    """Return the SHA-256 of the graph that a certificate is about."""
    return str(json.loads(text)["graph_sha256"])


def _claim(proof: MarginProof, loops: list[dict[str, Any]], places: dict[str, int]) -> dict[str, Any]:
    claim, leaves = proof.claim, []
    for leaf in proof.searched.leaves:
        loop = _loop(leaf.loops, leaf.box[:-1])
        place = places.setdefault(digest_of(loop), len(loops))
        loops += [loop] * (place == len(loops))
        left, noise, frame = leaf.left, leaf.beyond_noise, leaf.loops.frame
        leaves.append(
            {
                "box": leaf.core,
                "loop": place,
                **leaf.disc.as_data(),
                "transform": leaf.transform.tolist(),
                "beyond": leaf.beyond.tolist(),
                **({} if leaf.shift is None else {"bends": leaf.bends, "shift": leaf.shift.tolist()}),
                **({} if left is None else {"left": left.tolist()}),
                **({} if noise is None else {"noise": noise.tolist()}),
                **({} if frame is None else {"frame": frame.tolist()}),  # where a search may begin that goes on
            }
        )
    more: dict[str, Any] = {name: True for name in ("any_change", "at_rest", "continuous") if getattr(claim, name)}
    more |= {name: value for name in ("changes", "orbit") if (value := getattr(claim, name))}
    of_quantity = {"most": claim.most, "unit": claim.unit} if claim.row.of_output else {}
    told = {
        "loop": claim.loop,
        "open_at": claim.open_at,
        "coordinates": proof.coordinates.as_data() if proof.coordinates else [],
        "claim": str(claim),
        "kind": claim.kind,
        "limit": claim.limit,
        "period": claim.period,
        "factor": claim.row.factor,
        "ends": claim.ends,
        "leaves": leaves,
    }
    return of_quantity | more | told


def _loop(of: OpenCorners, box: Sides) -> dict[str, Any]:
    wide = [i for i, (low, high) in enumerate(box) if low < high]
    return {
        "order": of.order,
        "values": of.values,
        "inputs": of.corners.middle.shape[2] - of.order,
        "box": box,
        "interpolated": list(of.interpolated),
        "bounded": [i for i in wide if i not in of.interpolated],
        **({} if of.rest is None else {"rest": of.rest.as_data()}),
        "corners": {"middle": of.corners.middle.tolist(), "radius": of.corners.radius.tolist()},
    }


def _digital(proof: DigitalProof, of: DigitalMap) -> dict[str, Any]:
    """Return a claim about fixed point with its map; of what enters also that a quantiser does not overflow."""
    signals = [given.node for given in proof.inputs]
    ranges = [((one.low, one.high), _form(one.form)) for one in of.conditions]
    ranges += [(proof.inputs[signals.index(node)].format, {f"input {i}": "1"}) for i, (node, _) in enumerate(of.inputs)]
    return {
        "kind": proof.kind,
        "output": proof.output,
        "limit": proof.limit,
        "unit": proof.unit,
        "step": str(proof.step),
        "inputs": [{"signal": ".".join(one.node), "ends": one.mantissas} for one in proof.inputs],
        "start": of.start,
        "following": [*map(_form, of.following)],
        "entering": [signals.index(node) for node, _ in of.inputs],
        "errors": [[str(error.low), str(error.high)] for error in of.errors],
        "conditions": [form for _, form in ranges],
        "ranges": [ends for ends, _ in ranges],
        "outputs": [_form(form) for forms in of.outputs.values() for form in forms],
    }


def _form(form: AffineNumber) -> dict[str, str]:
    """Return the factors of a form by its symbols, and its constant by none."""
    if not isinstance(form, AffineMantissa):
        return {"": str(form)}
    return {"": str(form.constant)} | {f"{s.kind} {s.number}": str(factor) for s, factor in form.terms.items()}
