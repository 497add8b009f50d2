"""Noise over tolerances: the closed form of a filter, random loops with truth by hand, certificates.

The filter y' = a y + q w with a = 1 - g T b and q = g T s, w of variance one, has the variance q^2 / (1 - a^2).
"""

import itertools
import math
import random
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof import noise_norm
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.toleranced_loops import random_loop
from tests.runner.design.proof.test_prove import GRAPH, status
from tests.runner.verification.test_certificates import forged

FILTER = """
name = "filter"
rate = "1 kHz"
samples = 100
wires = ["hiss.output -> inner.first", "back.output -> inner.second", "inner.output -> state.input",
         "state.output -> back.input"]
probes = ["state.output"]
[blocks.hiss]
kind = "WhiteNoise"
density = 0.1
[blocks.inner]
kind = "Difference"
[blocks.state]
kind = "DiscreteIntegrator"
output_unit = "1"
gain = 100.0
[blocks.back]
kind = "Gain"
gain = 2.0
"""
T, S = 1e-3, 0.1 * math.sqrt(0.5 / 1e-3)
WITHIN = {"state.gain": "10 %", "back.gain": "5 %"}


def rms(gain: float, back: float) -> float:
    a, q = 1.0 - gain * T * back, gain * T * S
    return q / math.sqrt(1.0 - a * a)


WORST = rms(110.0, 1.9)


def about(limit: Any, graph: Graph | None = None, output: str = "state.output", **more: Any) -> Proofs:
    given: dict[str, Any] = {"tolerances": WITHIN} | more
    return prove(graph or read_graph_text(FILTER), noise={output: limit}, **given)


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return about(1.02 * WORST)


def test_a_limit_is_proved_up_to_the_closed_form(proved: Proofs) -> None:
    (proof,) = proved.proofs
    assert str(proof.claim).startswith("noise of at most 0.41")
    assert proof.status == "proved"
    (broken,) = about(0.99 * WORST).proofs
    assert broken.status == "refuted"
    at = broken.counterexample or {}
    assert rms(at["state.gain"], at["back.gain"]) > 0.99 * WORST
    assert broken.shown.startswith("noise 0.4")


def test_a_bound_comes_near_the_closed_form_and_does_not_pass_it() -> None:
    found = about("")
    (proof,) = found.proofs
    assert proof.status == "proved"
    assert WORST < proof.claim.limit < 1.1 * WORST
    assert proof.least is not None
    assert proof.least.margin == pytest.approx(WORST)
    assert "noise GRAPH --output state.output --set " in proofs_text(found)


def test_without_tolerances_the_sensor_itself_has_a_bound() -> None:
    assert status(about(1.001 * rms(100.0, 2.0), tolerances=None)) == ["proved"]
    assert status(about(0.999 * rms(100.0, 2.0), tolerances=None)) == ["refuted"]
    assert status(about(rms(100.0, 2.0), tolerances=None, seconds=2.0)) == ["open"]


@pytest.mark.defect("S849", before="open, as `a sensor lies too near the limit`", after="proved")
def test_an_output_that_some_sensors_do_not_have() -> None:
    """Of a gain from 0 to 1 the noise is that of the state at 1, and none at 0."""
    text = FILTER.replace("wires = [", 'wires = ["state.output -> seen.input", ') + '[blocks.seen]\nkind = "Gain"\n'
    for part, expected in ((1.01, "proved"), (0.99, "refuted")):
        limit, within = part * rms(100.0, 2.0), {"seen.gain": ["0", "1"]}
        assert status(about(limit, read_graph_text(text), "seen.output", tolerances=within)) == [expected]


def test_an_output_without_states_has_noise_within_its_gain() -> None:
    text = FILTER.replace("wires = [", 'wires = ["hiss.output -> seen.input", ') + '[blocks.seen]\nkind = "Gain"\n'
    for part, expected in ((1.11, "proved"), (1.09, "refuted")):
        found = about(part * S, read_graph_text(text), "seen.output", tolerances={"seen.gain": "10 %"})
        assert status(found) == [expected]


def test_noise_without_a_bound_is_refuted() -> None:
    """An integrator of noise wanders, and an unstable filter grows."""
    wanders = read_graph_text(FILTER.replace("gain = 2.0", "gain = 0.0"))
    for limit in (1e6, ""):
        (proof,) = about(limit, wanders, tolerances={"state.gain": "10 %"}).proofs
        assert (proof.status, proof.shown) == ("refuted", "it has no bound")
    (grows,) = about(1e6, tolerances={"back.gain": ["1", "30"]}).proofs
    assert grows.status == "refuted"
    assert (grows.counterexample or {})["back.gain"] >= 20.0


def test_what_has_no_proof_says_why() -> None:
    (silent,) = about(1.0, GRAPH, "hold.output", tolerances={"hold.gain": "10 %"}).proofs
    why = "no noise reaches hold.output; a WhiteNoise, or a converter, must lie on a path to it"
    assert (silent.status, silent.searched.why) == ("open", why)
    text = FILTER.replace('"hiss.output -> inner.first"', '"hiss.output -> chosen.input", "chosen.sign -> inner.first"')
    text += '[blocks.chosen]\nkind = "Comparator"\n'
    (decided,) = about(1.0, read_graph_text(text)).proofs
    assert decided.status == "open"
    assert "is that of a run" in decided.searched.why


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"output": "stat.output", "limit": 1.0}, "did you mean state"),
        ({"limit": "2 V"}, "V is"),
        ({"limit": 0.0}, "must be above zero"),
        ({"limit": -1.0}, "must be above zero"),
        ({"limit": [1.0, 2.0]}, "must be a number"),
    ],
    ids=str,
)
def test_wrong_words_are_answered(given: dict[str, Any], words: str) -> None:
    with pytest.raises(ModelError) as refused:
        about(**given)
    assert words in str(refused.value)


# -- truth -------------------------------------------------------------------------------------------------------------

SAMPLE = (0, 1, 4, 8)


@pytest.mark.parametrize("seed", chosen(SAMPLE, [seed for seed in range(120) if seed not in SAMPLE]))
def test_no_proof_and_no_refutation_is_false(seed: int) -> None:
    """All corners and random places of a box, of loops with delays and several rates."""
    loop, draw = random_loop(seed), random.Random(seed)
    element = draw.choice(loop.elements)
    places = list(itertools.product((-1.0, 1.0), repeat=len(loop.tolerances)))
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in loop.tolerances) for _ in range(50)]
    widths = loop.tolerances.items()
    sensors = [
        loop.values | {n: loop.values[n] * (1.0 + width * x) for (n, width), x in zip(widths, place, strict=True)}
        for place in places
    ]
    stable = all(loop.radius(one) < 1.0 - 1e-9 for one in sensors)
    values = [loop.rms(one, element.name) for one in sensors] if stable else [1.0]
    limit = max(values) * draw.choice((1.3, 1.1, 1.05, 0.99))
    found = prove(
        loop.graph(noisy=True),
        tolerances={name: f"{100.0 * width} %" for name, width in widths},
        noise={element.last: limit},
        seconds=6.0,
    )
    (proof,) = found.proofs
    if proof.status == "proved":
        assert stable
        assert max(values) < limit * (1.0 + 1e-9)
        assert check_certificate(certificate(found))
    if proof.status == "refuted":
        broken = loop.values | dict(proof.counterexample or {})
        assert loop.radius(broken) > 1.0 - 1e-9 or loop.rms(broken, element.name) > limit * (1.0 - 1e-9)


@pytest.mark.exhaustive
def test_the_accelerometer_has_a_bound_near_what_is_found() -> None:
    (proof,) = prove(
        "library:closed_loop_accelerometer",
        tolerances={"torquer.gain": "10 %", "pendulum.inertia": "10 %", "pid.proportional": "10 %"},
        noise={"dac.code": ""},
    ).proofs
    assert proof.status == "proved"
    assert proof.least is not None
    assert proof.least.margin < proof.claim.limit < 1.1 * proof.least.margin


# -- certificates ------------------------------------------------------------------------------------------------------


def _leaf(c: Any) -> Any:
    return c["claims"][0]["leaves"][0]


def _lower(c: Any) -> None:
    claim = c["claims"][0]
    claim["limit"] *= 0.9
    claim["ends"] = [claim["limit"]] * 2
    for leaf in claim["leaves"]:
        leaf["box"][-1] = claim["ends"]


def _only_said(c: Any) -> None:
    c["claims"][0]["limit"] *= 0.9


def _smaller_norm(c: Any) -> None:
    """Longer columns of T make the noise shorter, and the output longer."""
    for leaf in c["claims"][0]["leaves"]:
        leaf["transform"][0][0] *= 1.2


def _mixed_outputs(c: Any) -> None:
    _leaf(c)["transform"][-1][0] = 0.1


def _larger_outputs(c: Any) -> None:
    _leaf(c)["transform"][-1][-1] = 10.0


def _more_noise(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[0][-1] *= 2.0


def _unsure(c: Any) -> None:
    _leaf(c)["noise"][0][0] = 1.0


def _less_than_nothing(c: Any) -> None:
    _leaf(c)["noise"][0][0] = -1.0


def _no_noise(c: Any) -> None:
    del _leaf(c)["noise"]


def _neutral(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[0][0] = 1.0


def _as_scale_factor(c: Any) -> None:
    c["claims"][0]["kind"] = "scale factor"


def _as_gain(c: Any) -> None:
    c["claims"][0] |= {"kind": "stable", "limit": 0.0, "factor": "gain", "ends": [1.0, 1.0]}


FORGERIES = [
    _lower, _only_said, _smaller_norm, _mixed_outputs, _larger_outputs, _more_noise, _unsure, _less_than_nothing,
    _no_noise, _neutral, _as_scale_factor, _as_gain,
]  # fmt: skip


def test_a_certificate_is_checked_and_forged_ones_are_refused(proved: Proofs) -> None:
    text = certificate(proved)
    (line,) = check_certificate(text)
    assert line.startswith(f"state.output, noise of at most {1.02 * WORST!r}: ")
    for change in FORGERIES:
        with pytest.raises(FalseCertificateError):
            check_certificate(forged(text, change))


def test_a_search_goes_on_from_its_certificate(proved: Proofs, monkeypatch: pytest.MonkeyPatch) -> None:
    known = known_proofs(certificate(proved), graph_digest(read_graph_text(FILTER)))
    monkeypatch.setattr(noise_norm, "_root", lambda *_: pytest.fail("what is proved is searched again"))
    assert status(about(1.02 * WORST, known=known)) == ["proved"]
