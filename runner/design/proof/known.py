"""Parts that an earlier search proved, from its certificate: boxes with their norms, each of which is proved anew."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.design.proof.rest_norm import Start

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
    left = leaf.get("left")
    return Start(np.array(leaf["transform"], dtype=float), None if left is None else np.array(left, dtype=float))


def _sides(box: Sequence[Sequence[float]]) -> Sides:
    return tuple((float(low), float(high)) for low, high in box)
