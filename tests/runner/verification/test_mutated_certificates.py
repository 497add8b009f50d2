"""Certificates of integrators with any number changed: what the checker takes of them is true by closed forms.

What encloses the graph is taken for granted: the loops of a certificate stay as they are, whether they have rates, and
which parameters they depend on, as a product too. All else may be another number, kind or factor, with a hash that is
right. The formulas are those of `test_other_claims` and of `test_continuous_loops`.
"""

import json
import math
import random
from collections.abc import Callable
from typing import Any

import pytest

from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.runner.design.proof import test_continuous_loops, test_other_claims
from tests.runner.design.proof.test_prove import GRAPH
from tests.runner.verification.test_certificates import forged

KINDS = ("stable", "gain margin", "phase margin", "disk margin", "delay margin", "decay rate")
FACTORS = ("gain", "phase", "disk", "rest", "noise", "peak")
WITHIN = {"gain.gain": "10 %"}


def _sampled() -> Proofs:
    return test_other_claims.proofs(0.6)


def _sampled_product() -> Proofs:
    return prove(GRAPH, tolerances=WITHIN | {"hold.gain": "20 %"}, gain_margin="20 dB", disk_margin="1.4")


def _sampled_fast() -> Proofs:
    return prove(GRAPH, tolerances=WITHIN, gain_margin="20 dB", disk_margin="1.4", decay_rate="70 1/s", any_change=True)


def _sampled_slow() -> Proofs:
    return prove(
        GRAPH, tolerances=WITHIN, gain_margin="20 dB", disk_margin="1.4", decay_rate="70 1/s", slow_change="10 %/s"
    )


def _rates() -> Proofs:
    return test_continuous_loops.proofs(0.8)


def _rates_fast() -> Proofs:
    return test_continuous_loops.proofs(0.8, any_change=True)


CERTIFICATES: dict[str, Callable[[], Proofs]] = {
    "sampled": _sampled, "a product": _sampled_product,
    "under any change": _sampled_fast, "under slow change": _sampled_slow,
    "in continuous time": _rates, "in continuous time under any change": _rates_fast,
}  # fmt: skip


@pytest.fixture(scope="module", params=CERTIFICATES)
def proved(request: pytest.FixtureRequest) -> str:
    return certificate(CERTIFICATES[request.param]())


def ends_of(side: dict[str, Any]) -> tuple[float, float]:
    """The ends of the gain: those of a product of gains that are nominally 1, but for the first."""
    every = side.get("product", [side])
    low, high = (math.prod(float(one[end]) for one in every) for end in ("low", "high"))
    return low, high


def least_of(kind: str, claim: dict[str, Any]) -> float:
    """The least figure of an integrator within the coordinates of a claim."""
    ((low, high),) = (ends_of(one) for one in claim["coordinates"])
    if claim.get("continuous") is True:
        figures = {"phase margin": 90.0, "disk margin": 2.0, "delay margin": 0.5 * math.pi / high, "decay rate": low}
        return {"stable": 0.0, "gain margin": math.inf, **figures}[kind]
    period = float(claim["period"]) or math.nan  # which no limit is below
    a, least = high * 1e-3, low * 1e-3
    turn = math.asin(0.5 * a)
    return {
        "stable": 0.0, "gain margin": 20.0 * math.log10(2.0 / a), "phase margin": 90.0 - math.degrees(turn),
        "disk margin": 2.0 * (2.0 - a) / (2.0 + a), "delay margin": (0.5 * math.pi - turn) / (2.0 * turn) * period,
        "decay rate": -math.log(1.0 - least) / period,
    }[kind]  # fmt: skip


def places(tree: Any, at: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    """The places of all numbers, kinds and factors of claims."""
    if isinstance(tree, dict):
        return [place for key in sorted(tree) for place in places(tree[key], (*at, key))]
    if isinstance(tree, list):
        return [place for i, part in enumerate(tree) for place in places(part, (*at, i))]
    changes = isinstance(tree, int | float) or at[-1] in ("kind", "factor")
    return [at] if changes and at[-1] not in ("inverse", "continuous", "nominal", "power") else []


def _another(value: Any, key: Any, draw: random.Random) -> Any:
    if key in ("kind", "factor"):
        return draw.choice(KINDS if key == "kind" else FACTORS)
    if isinstance(value, bool):
        return not value
    ways = [0.0, -value, value * 1.001, value * 0.999, value * (1.0 + 1e-9), value * 2.0, value * 0.5, value + 1.0]
    ways += [value - 1.0, math.nextafter(value, math.inf), math.nextafter(value, -math.inf), 1e300, 1e-300]
    return draw.choice(ways)


@pytest.mark.exhaustive("in continuous time")
@pytest.mark.parametrize("seed", chosen([0], range(1, 40)))
def test_what_is_taken_of_a_changed_certificate_is_true(proved: str, seed: int) -> None:
    draw = random.Random(seed)
    whole = json.loads(proved)
    numbers = places(whole["claims"])
    taken, outer = 0, [place for place in numbers if "leaves" not in place]
    for _ in range(25):
        number = draw.choice(range(len(whole["claims"])))
        own = [place for place in (outer if draw.random() < 0.5 else numbers) if place[0] == number]
        chosen_places = draw.sample(own, min(len(own), draw.choice((1, 1, 2, 3))))

        def change(c: Any, number: int = number, some: Any = chosen_places) -> None:
            for place in some:
                part = c["claims"]
                for key in place[:-1]:
                    part = part[key]
                part[place[-1]] = _another(part[place[-1]], place[-1], draw)
            c["claims"] = [c["claims"][number]]

        text = forged(proved, change)
        (claim,) = json.loads(text)["claims"]
        try:
            (line,) = check_certificate(text)
        except FalseCertificateError:
            continue
        taken += 1
        ends = [ends_of(one) for one in claim["coordinates"]]
        assert all(0.0 < low <= high for low, high in ends)
        assert claim["limit"] <= least_of(claim["kind"], claim) * (1.0 + 1e-12), line
    assert seed or taken
