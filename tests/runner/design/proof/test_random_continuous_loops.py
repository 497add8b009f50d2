"""Proofs about random loops in continuous time: no proof and no refutation is false, by python-control and poles."""

import itertools
import math
import random
from collections.abc import Mapping

import control
import numpy as np
import pytest

from proofmass.runner.design.proof.attempt import MarginProof
from proofmass.runner.design.proof.claim import KINDS
from proofmass.runner.design.proof.prove import prove
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.analog_loops import AnalogLoop, control_loop, random_loop
from tests.runner.design.proof.test_prove import status


def _figures(loop: AnalogLoop, values: Mapping[str, float]) -> dict[str, float]:
    """The figures of one sensor by python-control, and its slowest pole; minus infinity if it is unstable."""
    growth = loop.growth(values)
    if growth >= 0.0:
        return dict.fromkeys(KINDS, -math.inf)
    a, b, c = loop.open(values)
    system = control.ss(a, b[:, None], -c[None], [[0.0]])
    sizes = np.abs(np.linalg.eigvals(np.block([[a, np.zeros_like(a)], [np.zeros_like(a), loop.closed(values)]])))
    w = np.geomspace(1e-2 * max(sizes[sizes > 0.0].min(), 1e-3), 1e3 * sizes.max(), 6000)
    resolvents = 1j * w[:, None, None] * np.eye(len(a)) - a
    open_loop = -np.linalg.solve(resolvents, np.broadcast_to(b[:, None], (len(w), len(b), 1)))[..., 0] @ c
    disk = 2.0 / np.abs((1.0 - open_loop) / (1.0 + open_loop)).max()
    gains, phases, _, _, crossings, _ = control.stability_margins(system, returnall=True)
    gain = min((abs(20.0 * math.log10(g)) for g in gains if g > 0.0), default=math.inf)
    phase = min((abs((p + 180.0) % 360.0 - 180.0) for p in phases), default=math.inf)
    delays = []
    for x in crossings:
        value = -(c @ np.linalg.solve(1j * x * np.eye(len(a)) - a, b))
        delays.append((np.angle(-value) % (2.0 * math.pi)) / x)
    return {
        "stable": 0.0, "gain margin": float(gain), "phase margin": float(phase), "disk margin": float(disk),
        "delay margin": float(min(delays, default=math.inf)), "decay rate": -growth,
    }  # fmt: skip


@pytest.mark.parametrize("case", chosen([(0, 100)], [(seed, 1000) for seed in range(150)]), ids=str)
def test_no_proof_and_no_refutation_is_false(case: tuple[int, int]) -> None:
    """Corners, and random places with random factors: no pole of a loop that is proved may lie beyond."""
    seed, count = case
    nothing_is_false(random_loop(seed), random.Random(seed), count)


@pytest.mark.parametrize("case", chosen([(2, 100)], [(seed, 1000) for seed in range(100)]), ids=str)
def test_no_proof_is_false_of_regulators_and_unstable_plants(case: tuple[int, int]) -> None:
    seed, count = case
    nothing_is_false(control_loop(seed), random.Random(seed), count)


def nothing_is_false(loop: AnalogLoop, draw: random.Random, places_beside: int) -> None:
    nominal = _figures(loop, loop.values)
    part = draw.choice((0.5, 0.8, 0.95, 1.02))
    limits = {kind: max(value, 0.0) * part for kind, value in nominal.items()}
    finite = {kind: limit if 0.0 < limit < math.inf else 1.0 for kind, limit in limits.items()}
    found = prove(
        loop.graph(),
        tolerances={name: f"{100.0 * width} %" for name, width in loop.tolerances.items()},
        gain_margin=f"{min(finite['gain margin'], 40.0)!r} dB",
        phase_margin=f"{min(finite['phase margin'], 170.0)!r} deg",
        disk_margin=f"{min(finite['disk margin'], 1.9)!r}",
        delay_margin=f"{finite['delay margin']!r} s",
        decay_rate=f"{finite['decay rate']!r} 1/s",
        seconds=10.0,
    )
    places = list(itertools.product((-1.0, 1.0), repeat=len(loop.tolerances)))
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in loop.tolerances) for _ in range(places_beside)]
    sensors = [loop.at(dict(zip(loop.tolerances, place, strict=True))) for place in places]
    few = [_figures(loop, one) for one in sensors[: min(40, places_beside // 10)]]
    for proof in found.proofs:
        if proof.status == "proved":
            _nothing_lies_beyond(loop, proof, sensors, draw)
            assert min(one[proof.claim.kind] for one in few) >= proof.claim.limit * (1.0 - 2e-6), proof.claim
        if proof.status == "refuted":
            broken = loop.values | dict(proof.counterexample or {})
            assert all(
                abs(broken[n] / loop.values[n] - 1.0) <= loop.tolerances[n] + 1e-12 for n in proof.counterexample or {}
            )
            assert loop.growth(broken) > -1e-9 or _figures(loop, broken)[proof.claim.kind] < proof.claim.limit * (
                1.0 + 1e-4
            ), proof.claim
    count = status(found).count("proved")
    assert not count or len(check_certificate(certificate(found))) == count


def _nothing_lies_beyond(
    loop: AnalogLoop, proof: MarginProof, sensors: list[dict[str, float]], draw: random.Random
) -> None:
    kind, limit = proof.claim.kind, proof.claim.limit
    for one in sensors:
        part = draw.uniform(-1.0, 1.0)
        factor = 1.0 + 0.0j
        if kind == "gain margin":
            factor = 10.0 ** (part * limit / 20.0)
        if kind == "phase margin":
            factor = complex(np.exp(1j * part * math.radians(limit)))
        if kind == "disk margin":
            d = complex(np.exp(1j * math.pi * part)) * limit
            factor = (2.0 + d) / (2.0 - d)
        assert loop.growth(one, factor) < (-limit if kind == "decay rate" else 0.0) + 1e-9, (proof.claim, one)
