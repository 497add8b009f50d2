"""Claims under any change of the parameters: closed forms, products of matrices by hand, what has no common norm.

Where parameters change from period to period, all products A(q_1) A(q_2) ... of matrices of the box decay if one norm
serves them all. A product of N with a spectral radius of r > 1 grows, though each of its sensors may be stable.
"""

import itertools
import math
import random
from typing import Any

import numpy as np
import pytest

from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.toleranced_loops import RATE, Loop, flexure, integrator, random_loop
from tests.runner.design.proof.test_prove import GRAPH, status
from tests.runner.verification.test_certificates import forged


def test_an_integrator_keeps_its_limits_however_its_gain_changes() -> None:
    """x' = (1 - g T) x: the product of any factors within [1 - 0.11, 1 - 0.09] decays as fast as the largest."""
    rate = -math.log(1.0 - 0.09) / 1e-3
    for part, expected in ((0.99, "proved"), (1.01, "refuted")):
        found = prove(
            GRAPH,
            tolerances={"gain.gain": "10 %"},
            gain_margin="25 dB",
            decay_rate=f"{part * rate} 1/s",
            delay_margin="1 ms",
            any_change=True,
        )
        assert status(found) == ["proved", "proved", "proved", "open", expected]
        assert "parameters that stay" in found.proofs[3].searched.why
        assert "gain margin of at least 25 dB under any change" in proofs_text(found)
    lines = check_certificate(certificate(prove(GRAPH, tolerances={"gain.gain": "10 %"}, any_change=True)))
    assert lines[0].startswith("main, stable under any change: 1 box")


def test_noise_keeps_its_limit_and_a_scale_factor_is_of_parameters_that_stay() -> None:
    """x' = a x + g T w has a mean square of at most (g T)^2 / (1 - a^2) of the largest a = 1 - g T k."""
    element = integrator("first", random.Random(1), 1)
    step = 50.0 / RATE
    loop = Loop([element], {"gain.gain": 1.0, "first.gain": 50.0}, {})
    rms = step / math.sqrt(1.0 - (1.0 - 0.8 * step) ** 2)
    for part, expected in ((1.01, "proved"), (0.99, "refuted")):
        found = prove(
            loop.graph(noisy=True),
            tolerances={"gain.gain": "20 %"},
            noise={"first.output": part * rms},
            input="hiss.output",
            scale_factor={"first.output": ""},
            any_change=True,
        )
        assert status(found) == ["open", "open", expected]
        assert "parameters that stay" in found.proofs[0].searched.why


# -- parametric resonance ----------------------------------------------------------------------------------------------


def swing(width: float) -> Loop:
    """A flexure at 100 rad/s with a damping ratio of 0.02, in a loop of a small gain."""
    element = flexure("first", random.Random(1), 1)
    element.values |= {"first.inertia": 1.0, "first.damping": 4.0, "first.stiffness": 1e4, "first_force.gain": 500.0}
    return Loop([element], {"gain.gain": 1.0, **element.values}, {"first.stiffness": width})


def swung(loop: Loop, width: float) -> float:
    """The spectral radius over a swing whose stiffness is low and high by turns, for a quarter of a swing each."""
    low, high = (loop.matrix(loop.values | {"first.stiffness": 1e4 * (1.0 + sign * width)}) for sign in (-1.0, 1.0))
    radii = [
        max(abs(np.linalg.eigvals(np.linalg.matrix_power(low, m) @ np.linalg.matrix_power(high, n))))
        for m, n in itertools.product(range(10, 25), repeat=2)
    ]
    return float(max(radii))


def changing(loop: Loop, **more: Any) -> Proofs:
    within = {name: f"{100.0 * width} %" for name, width in loop.tolerances.items()}
    given = {"gain_margin": "1 dB", "phase_margin": "1 deg"} | more
    return prove(loop.graph(), tolerances=within, any_change=True, **given)


def test_what_a_change_may_swing_up_is_not_proved() -> None:
    """All sensors within 10 % are stable; a stiffness that changes twice in a swing makes it grow."""
    assert swung(swing(0.1), 0.1) > 1.03
    loop = swing(0.1)
    assert all(loop.radius(loop.values | {"first.stiffness": 1e4 + 50.0 * k}) < 1.0 for k in range(-20, 21))
    (stable, *_) = changing(loop, gain_margin="99 dB", phase_margin="179 deg", seconds=1.0).proofs
    assert (stable.status, stable.searched.boxes) == ("open", 1)
    assert "all of the tolerances at once; with parameters that stay it is" in stable.searched.why
    assert swung(swing(0.02), 0.02) < 1.0
    found = changing(swing(0.02))
    assert found.proofs[0].status == "proved"
    assert check_certificate(certificate(found))


def test_a_sensor_that_breaks_a_claim_as_it_is_breaks_it_under_any_change() -> None:
    loop = swing(0.3)
    loop.tolerances["gain.gain"] = 0.99
    loop.values["gain.gain"] = 100.0
    found = changing(loop)
    assert found.proofs[0].status == "refuted"
    assert loop.radius(loop.values | dict(found.proofs[0].counterexample or {})) > 1.0 - 1e-9


@pytest.fixture(scope="module")
def in_parts() -> Proofs:
    """A norm serves all corners, but not what may lie between them: parts of the box have it too."""
    graph = read_graph("library:closed_loop_accelerometer")
    return prove(graph, tolerances={"torquer.gain": "43 %", "pendulum.inertia": "43 %"}, any_change=True)


@pytest.mark.exhaustive
def test_parts_of_a_box_have_one_norm(in_parts: Proofs) -> None:
    assert status(in_parts) == ["proved"] * 3
    assert max(len(one.searched.leaves) for one in in_parts.proofs) > 1
    assert len(check_certificate(certificate(in_parts))) == 3
    known = known_proofs(certificate(in_parts), graph_digest(in_parts.graph))
    tolerances = {one.written: [one.low, one.high] for one in in_parts.ranges}
    again = prove(in_parts.graph, tolerances=tolerances, any_change=True, known=known)
    assert status(again) == ["proved"] * 3


def _another_norm(c: Any) -> None:
    claim = next(one for one in c["claims"] if len(one["leaves"]) > 1)
    claim["leaves"][0]["transform"] = [[2.0 * value for value in row] for row in claim["leaves"][0]["transform"]]


@pytest.mark.exhaustive
def test_parts_with_norms_of_their_own_prove_nothing_under_any_change(in_parts: Proofs) -> None:
    """Twice a norm shortens the same vectors: only the claim under any change is another."""
    text = forged(certificate(in_parts), _another_norm)
    with pytest.raises(FalseCertificateError, match="no norm serves all"):
        check_certificate(text)
    assert check_certificate(forged(text, lambda c: [one.pop("any_change") for one in c["claims"]]))
    known = known_proofs(text, graph_digest(in_parts.graph))
    tolerances = {one.written: [one.low, one.high] for one in in_parts.ranges}
    again = prove(in_parts.graph, tolerances=tolerances, any_change=True, known=known)
    assert sorted(status(again)) == ["open", "proved", "proved"] or status(again) == ["proved", "open", "open"]


def test_claims_of_parameters_that_stay_are_none_under_any_change() -> None:
    """A delay turns by more at a higher frequency, and what never settles has no scale factor."""
    within = {"gain.gain": "10 %"}
    delays = prove(GRAPH, tolerances=within, delay_margin="1 ms")
    factors = prove(GRAPH, tolerances=within, input="step.output", scale_factor={"hold.output": "0.9..1.1"})
    for proofs, place in ((delays, 3), (factors, 0)):
        assert proofs.proofs[place].status == "proved"

        def changing_too(c: Any, kind: str = proofs.proofs[place].claim.kind) -> None:
            next(one for one in c["claims"] if one["kind"] == kind)["any_change"] = True

        with pytest.raises(FalseCertificateError, match="no norm serves all"):
            check_certificate(forged(certificate(proofs), changing_too))


SAMPLE = (0, 9)


@pytest.mark.parametrize("seed", chosen(SAMPLE, [seed for seed in range(80) if seed not in SAMPLE]))
def test_products_of_matrices_do_not_contradict_a_proof(seed: int) -> None:
    loop, draw = random_loop(seed), random.Random(seed)
    nominal = loop.radius(loop.values)
    rate = -0.5 * math.log(nominal) * RATE / loop.ticks if nominal < 1.0 else 1.0
    stable, *_, decays = changing(loop, decay_rate=f"{rate!r} 1/s", seconds=4.0).proofs
    ends = itertools.product((-1.0, 1.0), repeat=len(loop.tolerances))
    places = [*ends, *([draw.uniform(-1.0, 1.0) for _ in loop.tolerances] for _ in range(10))]
    matrices = [
        loop.matrix(loop.values | {n: loop.values[n] * (1.0 + w * x) for (n, w), x in zip(widths, place, strict=True)})
        for widths in [list(loop.tolerances.items())]
        for place in places
    ]
    largest = 0.0
    for _ in range(300):
        one, other = draw.choice(matrices), draw.choice(matrices)
        m, n = draw.randint(1, 12), draw.randint(1, 12)
        product = np.linalg.matrix_power(one, m) @ np.linalg.matrix_power(other, n)
        largest = max(largest, max(abs(np.linalg.eigvals(product))) ** (1.0 / (m + n)))
    if stable.status == "proved":
        assert largest < 1.0
    if decays.status == "proved":
        assert largest <= math.exp(-rate * loop.ticks / RATE) * (1.0 + 1e-9)
    for proof in (stable, decays):
        if proof.counterexample is not None:
            radius = loop.radius(loop.values | dict(proof.counterexample))
            assert radius > (1.0 if proof is stable else math.exp(-rate * loop.ticks / RATE)) - 1e-9
