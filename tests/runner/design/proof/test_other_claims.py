"""Disk margins, delay margins and decay rates over tolerances against closed forms, and searches that go on.

The integrator has L = a / (z - 1) with a = g T, T = 1 ms:

- its pole is 1 - a, which decays by -ln(1 - a) / T;
- |L| = 1 at w with 2 sin(w / 2) = a, where the phase that is left is 90 deg - w / 2: a delay of as much over w;
- (1 - L) / (1 + L) = (z - 1 - a) / (z - 1 + a) is largest at z = -1: the disk margin is 2 (2 - a) / (2 + a).
"""

import json
import math
import signal
from typing import Any

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.runner.analysis.margins.stability import margins
from proofmass.runner.design.proof.attempt import KnownProofs, known_proofs
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.prove import Proofs, prove, prove_margin
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import amounts
from tests.runner.design.proof.test_prove import GRAPH, INTEGRATING, status
from tests.runner.verification.test_certificates import forged

WITHIN = {"gain.gain": "10 %"}  # about 100 /s
MOST, LEAST = 0.11, 0.09  # a
DISK = 2.0 * (2.0 - MOST) / (2.0 + MOST)
DELAY = (0.5 * math.pi - math.asin(0.5 * MOST)) / (2.0 * math.asin(0.5 * MOST)) * 1e-3
RATE = -math.log(1.0 - LEAST) / 1e-3


def proofs(part: float, **more: Any) -> Proofs:
    """What comes of limits that are parts of the least there are."""
    limits = {"disk_margin": f"{DISK * part}", "delay_margin": f"{DELAY * part} s", "decay_rate": f"{RATE * part} 1/s"}
    return prove(GRAPH, tolerances=WITHIN, **limits, **more)


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return proofs(0.8)


@pytest.mark.parametrize("part", amounts(0.8, 0.99))
def test_other_claims_are_proved_up_to_their_closed_forms(part: float, proved: Proofs) -> None:
    assert status(proved if part == 0.8 else proofs(part)) == ["proved"] * 6
    assert [str(one.claim) for one in proved.proofs[3:]] == [
        "disk margin of at least 1.43318",
        "delay margin of at least 11.0182 ms",
        "decay rate of at least 75.4485 1/s",
    ]


@pytest.mark.exhaustive
@pytest.mark.defect("C873", before="TypeError for a limit that is a number", after="taken, or a sentence")
def test_a_limit_may_be_a_number_where_it_has_no_unit() -> None:
    *_, disk = prove(GRAPH, tolerances=WITHIN, disk_margin=0.5 * DISK).proofs
    assert (disk.status, disk.claim.limit) == ("proved", 0.5 * DISK)
    with pytest.raises(ModelError, match=r'write it as "6 dB"'):
        prove(GRAPH, gain_margin=6.0)  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="above zero"):
        prove(GRAPH, disk_margin=0.0)


@pytest.mark.defect("S790", before="a disk 0.01 % beyond the least there is: open", after="refuted")
def test_a_disk_a_little_beyond_its_closed_form_is_refuted() -> None:
    disk = prove_margin(GRAPH, "main", "disk margin", 1.0001 * DISK, WITHIN)
    assert disk.status == "refuted"
    gain = (disk.counterexample or {})["gain.gain"] * 1e-3
    assert 2.0 * (2.0 - gain) / (2.0 + gain) < 1.0001 * DISK


def test_other_claims_beyond_their_closed_forms_are_refuted_by_a_sensor() -> None:
    found = proofs(1.05)
    assert status(found) == ["proved"] * 3 + ["refuted"] * 3
    gains = [(one.counterexample or {})["gain.gain"] * 1e-3 for one in found.proofs[3:]]
    assert 2.0 * (2.0 - gains[0]) / (2.0 + gains[0]) < 1.05 * DISK
    assert (0.5 * math.pi - math.asin(0.5 * gains[1])) / (2.0 * math.asin(0.5 * gains[1])) * 1e-3 < 1.05 * DELAY
    assert -math.log(1.0 - gains[2]) / 1e-3 < 1.05 * RATE
    assert "disk margin" in found.proofs[3].shown


@pytest.mark.exhaustive
def test_bounds_of_other_claims_come_near_the_least_there_are() -> None:
    for proof, truth in zip(proofs(0.5, bounds=True).proofs[3:], (DISK, DELAY, RATE), strict=True):
        assert 0.95 * truth < proof.claim.limit < truth
        assert proof.least is not None
        assert proof.least.margin == pytest.approx(truth, rel=1e-6)


@pytest.mark.exhaustive
def test_a_delay_margin_below_a_sample_is_proved() -> None:
    """At 1600 /s two samples are too many: the phase that is left turns by half a turn in a sample at most."""
    graph = GRAPH.with_parameters({"gain.gain": 1600.0})
    delay = margins(graph).delay_margin
    assert delay is not None
    a = 1.6
    assert delay == pytest.approx((0.5 * math.pi - math.asin(0.5 * a)) / (2.0 * math.asin(0.5 * a)) * 1e-3)
    for part, expected in ((0.97, "proved"), (1.03, "refuted")):
        found = prove(graph, gain_margin="1 dB", phase_margin="10 deg", delay_margin=f"{part * delay} s")
        assert found.proofs[3].status == expected


def test_a_wire_with_several_values_has_a_disk_margin_and_no_delay() -> None:
    """Of two values in a period one is seen, and held for two steps of the plant: L = 2 a / (z - 1)."""
    text = INTEGRATING.replace("[blocks.hold]", '[blocks.hold]\nrate = "500 Hz"')
    text = text.replace('open_at = "hold', 'open_at = "plant')
    graph = read_graph_text(text)
    figure = margins(graph, at="0 s").disk_margin or 0.0
    assert figure == pytest.approx(2.0 * (2.0 - 0.2) / (2.0 + 0.2))
    for part, expected in ((0.97, "proved"), (1.03, "refuted")):
        found = prove(graph, disk_margin=f"{part * figure}", delay_margin="1 ms", decay_rate="1 1/s")
        assert status(found)[3:] == [expected, "open", "proved"]
        assert "several values" in found.proofs[4].searched.why
    check_certificate(certificate(found))


@pytest.mark.parametrize(
    "limit",
    [
        {"disk_margin": "2"},
        {"disk_margin": "5 V"},
        {"delay_margin": "0 s"},
        {"delay_margin": "2 V"},
        {"decay_rate": "1 s"},
    ],
    ids=str,
)
def test_limits_that_cannot_be_are_refused(limit: dict[str, str]) -> None:
    with pytest.raises(ModelError, match=next(iter(limit))):
        prove(GRAPH, **limit)  # type: ignore[arg-type]


# -- certificates ------------------------------------------------------------------------------------------------------


def _claim(c: Any, kind: str) -> Any:
    return next(one for one in c["claims"] if one["kind"] == kind)


def _larger_disk(c: Any) -> None:
    _claim(c, "disk margin")["limit"] *= 1.001


def _mixed_disk(c: Any) -> None:
    _claim(c, "disk margin")["leaves"][0]["transform"][-1][0] = 0.1


def _longer_delay(c: Any) -> None:
    _claim(c, "delay margin")["limit"] *= 1.001


def _fewer_turns(c: Any) -> None:
    """Without the last leaves, those of the largest turns."""
    claim = _claim(c, "delay margin")
    claim["leaves"] = [leaf for leaf in claim["leaves"] if leaf["box"][-1][1] < claim["ends"][1]]


def _wider_disc(c: Any) -> None:
    for leaf in _claim(c, "delay margin")["leaves"]:
        leaf["disc"][2] *= 1.001


def _lower_disc(c: Any) -> None:
    for leaf in _claim(c, "delay margin")["leaves"]:
        leaf["disc"][1] *= -1.0


def _faster(c: Any) -> None:
    _claim(c, "decay rate")["limit"] *= 1.001


def _no_time(c: Any) -> None:
    _claim(c, "decay rate")["period"] = 0.0


def _no_delay(c: Any) -> None:
    _claim(c, "delay margin")["period"] = -1.0


def _another_kind(c: Any) -> None:
    _claim(c, "stable")["kind"] = "decay"


def _no_circle(c: Any) -> None:
    _claim(c, "stable")["leaves"][0]["disc"] = [0.0, 0.0, 1.1]


FORGERIES = [
    _larger_disk, _mixed_disk, _longer_delay, _fewer_turns, _wider_disc, _lower_disc, _faster, _no_time, _no_delay,
    _another_kind, _no_circle,
]  # fmt: skip


def test_a_certificate_of_other_claims_is_checked(proved: Proofs) -> None:
    text = certificate(proved)
    assert [line.split(":")[0] for line in check_certificate(text)[3:]] == [
        "main, disk margin of at least 1.43318",
        "main, delay margin of at least 0.0110182 s",
        "main, decay rate of at least 75.4485 1/s",
    ]
    for change in FORGERIES:
        with pytest.raises(FalseCertificateError):
            check_certificate(forged(text, change))


# -- going on ----------------------------------------------------------------------------------------------------------


def descents(monkeypatch: pytest.MonkeyPatch) -> list[Norm]:
    """The norms that a search looks for from now on."""
    norms: list[Norm] = []
    improved = Norm.improved

    def counted(norm: Norm) -> Norm:
        norms.append(norm)
        return improved(norm)

    monkeypatch.setattr(Norm, "improved", counted)
    return norms


def test_a_search_goes_on_from_what_is_proved(proved: Proofs, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without some leaves of a delay margin these alone are looked for, and all of them are in the end."""
    content = json.loads(certificate(proved))
    delay = _claim(content, "delay margin")
    content["claims"].remove(delay)
    missing, delay["leaves"] = delay["leaves"][-2:], delay["leaves"][:-2]
    content["unfinished"] = [delay]
    norms = descents(monkeypatch)
    found = proofs(0.8, known=known_proofs(json.dumps(content), graph_digest(GRAPH)))
    assert status(found) == ["proved"] * 6
    assert 0 < len(norms) <= 2 * len(missing)
    assert {leaf.box for leaf in found.proofs[4].searched.leaves} >= {
        tuple(map(tuple, leaf["box"])) for leaf in delay["leaves"]
    }
    check_certificate(certificate(found))


def test_what_a_certificate_says_is_proved_anew(proved: Proofs) -> None:
    content = json.loads(certificate(proved))
    for claim in content["claims"]:
        for leaf in claim["leaves"]:
            leaf["transform"] = np.eye(len(leaf["transform"])).tolist()
    known = known_proofs(json.dumps(content), graph_digest(GRAPH))
    assert len(known.claims) == 6
    found = proofs(0.8, known=known)
    assert status(found) == ["proved"] * 6
    check_certificate(certificate(found))
    assert known_proofs(json.dumps(content), "another") == known_proofs("damaged", "") == KnownProofs(())


@pytest.mark.exhaustive
def test_an_interrupted_search_keeps_what_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """The delay margin has several parts, of which it looks at one."""

    def interrupt(done: int, _: int) -> None:
        if done == 2:
            signal.raise_signal(signal.SIGINT)

    def search(**more: Any) -> Proofs:
        return prove(GRAPH, tolerances=WITHIN, gain_margin="2 dB", phase_margin="45 deg", delay_margin="10 ms", **more)

    first = search(progress=interrupt)
    assert first.interrupted
    assert status(first) == ["proved", "proved", "proved", "open"]
    known = known_proofs(certificate(first), graph_digest(GRAPH))
    norms = descents(monkeypatch)
    again = search(progress=interrupt, known=known)
    assert status(again)[:3] == ["proved", "proved", "proved"]
    assert len(norms) <= 1
    assert search(known=known).proved
