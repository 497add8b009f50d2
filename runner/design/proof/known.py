"""Parts that an earlier search proved, from its certificate: boxes with their norms, each of which is proved anew."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from proofmass.runner.design.proof.claim import Claim
from proofmass.runner.design.proof.coordinates import Sides
from proofmass.runner.host.arrays import Array


@dataclass(frozen=True)
class KnownProofs:
    """Claims of a certificate, as plain data, the proved ones and those that are proved in part."""

    claims: Sequence[Mapping[str, Any]]

    def leaves(self, claim: Claim, coordinates: Sequence[Mapping[str, Any]]) -> dict[Sides, Array]:
        """Return the boxes of a claim over the same coordinates, with their norms."""
        wanted = (claim.open_at, claim.kind, claim.limit, claim.period, list(coordinates))
        for one in self.claims:
            if tuple(one[key] for key in ("open_at", "kind", "limit", "period", "coordinates")) == wanted:
                return {_sides(leaf["box"]): np.array(leaf["transform"], dtype=float) for leaf in one["leaves"]}
        return {}


def known_proofs(certificate: str, graph_sha256: str) -> KnownProofs:
    """Return what a certificate of the same graph has; nothing if it is that of another, or cannot be read."""
    try:
        data = json.loads(certificate)
        same = data["graph_sha256"] == graph_sha256
        return KnownProofs((*data["claims"], *data["unfinished"]) if same else ())
    except (ValueError, KeyError, TypeError):
        return KnownProofs(())


def _sides(box: Sequence[Sequence[float]]) -> Sides:
    return tuple((float(low), float(high)) for low, high in box)
