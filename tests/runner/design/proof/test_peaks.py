"""Peaks of responses over tolerances: closed forms, random loops with truth by hand, what has none, certificates.

The integrating loop has L = a / (z - 1), a = g T = 0.1 within 10 %. From step to error it has (z - 1) / (z - 1 + a),
which is largest at z = -1: 2 / (2 - a). To hold it has a / (z - 1 + a), which is largest at rest: 1.
"""

import itertools
import random
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.contraction import Norm
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import chosen
from tests.by_hand.toleranced_loops import random_loop
from tests.runner.design.proof.test_prove import GRAPH, INTEGRATING, status
from tests.runner.design.proof.test_scale_factors import extended
from tests.runner.verification.test_certificates import forged

MOST = 2.0 / (2.0 - 0.11)


def about(limit: Any, output: str = "error.output", graph: Graph = GRAPH, **more: Any) -> Proofs:
    return prove(graph, **{"tolerances": {"gain.gain": "10 %"}, "input": "step.output", "peak": {output: limit}} | more)


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return prove(
        GRAPH,
        tolerances={"gain.gain": "10 %"},
        input="step.output",
        peak={"error.output": 1.001 * MOST, "hold.output": 1.001},
    )


def test_peaks_are_proved_up_to_their_closed_forms(proved: Proofs) -> None:
    assert status(proved) == ["proved", "proved"]
    assert str(proved.proofs[1].claim) == "peak of at most 1.001"


@pytest.mark.exhaustive
def test_peaks_beyond_their_closed_forms_are_refuted_by_a_sensor() -> None:
    beyond = about(0.999 * MOST, peak={"error.output": 0.999 * MOST, "hold.output": 0.999})
    assert status(beyond) == ["refuted", "refuted"]
    refuted = beyond.proofs[0]
    gain = (refuted.counterexample or {})["gain.gain"] * 1e-3
    assert 2.0 / (2.0 - gain) > 0.999 * MOST


def test_without_a_limit_the_least_stands_beside_the_worst_found() -> None:
    found = about("")
    (proof,) = found.proofs
    assert proof.status == "proved"
    assert MOST < proof.claim.limit < 1.02 * MOST
    assert proof.least is not None
    assert proof.least.margin == pytest.approx(MOST)
    text = proofs_text(found)
    assert "1.0582011 found" in text
    assert 'response GRAPH step.output error.output --at "0 s" --set "gain.gain=110.0"' in text


@pytest.mark.exhaustive
def test_a_way_without_memory_has_its_gain() -> None:
    graph = extended("step.output -> twice.input", blocks='[blocks.twice]\nkind = "Gain"\ngain = -2.0\n')
    within = {"twice.gain": "10 %"}
    assert status(about(2.2001, "twice.output", graph, tolerances=within)) == ["proved"]
    assert status(about(2.1999, "twice.output", graph, tolerances=within)) == ["refuted"]


def test_what_does_not_settle_has_no_bound() -> None:
    graph = extended(
        "hold.output -> more.input", blocks='[blocks.more]\nkind = "DiscreteIntegrator"\noutput_unit = "1"\n'
    )
    for limit in (1e9, ""):
        (proof,) = about(limit, "more.output", graph).proofs
        assert (proof.status, proof.shown) == ("refuted", "it has no bound")


def test_a_gain_at_one_frequency_counts_with_what_it_shows_at_others() -> None:
    """Every second value of the input is seen: at rest the gain is 1, and [1 0] has the norm sqrt(2) / 1 beside it."""
    graph = extended("step.output -> seen.input", blocks='[blocks.seen]\nkind = "Gain"\nrate = "500 Hz"\n')
    assert status(about(1.415, "seen.output", graph, tolerances=None)) == ["proved"]
    (between,) = about(1.2, "seen.output", graph, tolerances=None).proofs
    assert (between.status, "several values in a period" in between.searched.why) == ("open", True)
    assert status(about(0.99, "seen.output", graph, tolerances=None)) == ["refuted"]


def test_however_the_gain_changes_the_rms_at_the_output_is_at_most_the_peak() -> None:
    found = about(1.01 * MOST, any_change=True)
    assert status(found) == ["proved"]
    assert "under any change" in check_certificate(certificate(found))[0]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"input": ""}, "needs an input"),
        ({"input": "step.outputt"}, "did you mean output"),
        ({"limit": "2 V"}, "V is"),
        ({"limit": 0.0}, "above zero"),
        ({"limit": "much"}, "much"),
        ({"output": "plan.output"}, "did you mean plant"),
    ],
    ids=str,
)
def test_wrong_words_are_answered(more: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"limit": 2.0} | more
    with pytest.raises(ModelError) as refused:
        about(**given)
    assert words in str(refused.value)


def test_an_output_that_nothing_moves_is_open() -> None:
    graph = extended(
        "other.output -> twice.input",
        blocks='[blocks.other]\nkind = "Step"\nunit = "1"\n[blocks.twice]\nkind = "Gain"\n',
    )
    (proof,) = about(1.0, "twice.output", graph).proofs
    assert proof.status == "open"
    assert "does not move" in proof.searched.why


# -- truth -------------------------------------------------------------------------------------------------------------

SAMPLE = (0, 34)


@pytest.mark.parametrize("seed", chosen(SAMPLE, [seed for seed in range(120) if seed not in SAMPLE]))
def test_no_proof_and_no_refutation_is_false(seed: int) -> None:
    """All corners and random places of a box, at many frequencies, of loops with delays and several rates."""
    loop, draw = random_loop(seed), random.Random(seed)
    element = draw.choice(loop.elements)
    places = list(itertools.product((-1.0, 1.0), repeat=len(loop.tolerances)))
    places += [tuple(draw.uniform(-1.0, 1.0) for _ in loop.tolerances) for _ in range(10)]
    widths = loop.tolerances.items()
    sensors = [
        loop.values | {n: loop.values[n] * (1.0 + width * x) for (n, width), x in zip(widths, place, strict=True)}
        for place in places
    ]
    stable = all(loop.radius(one) < 1.0 for one in sensors)
    worst = max(loop.peak(one, element.name, 300) for one in (sensors if stable else [loop.values]))
    limit = worst * draw.choice((1.5, 1.1, 1.02, 0.999, 0.9))
    found = prove(
        loop.graph(),
        tolerances={name: f"{100.0 * width} %" for name, width in widths},
        input="gain.output",
        peak={element.last: limit},
        seconds=6.0,
    )
    (proof,) = found.proofs
    if proof.status == "proved":
        assert stable
        assert worst <= limit * (1.0 + 1e-9)
        assert check_certificate(certificate(found))
    if proof.status == "refuted":
        broken = loop.values | dict(proof.counterexample or {})
        assert loop.radius(broken) > 1.0 - 1e-9 or loop.peak(broken, element.name) > limit * (1.0 - 1e-3)


# -- certificates ------------------------------------------------------------------------------------------------------


def _leaf(c: Any) -> Any:
    return c["claims"][0]["leaves"][0]


def _nearer(c: Any) -> None:
    c["claims"][0]["limit"] *= 0.999


def _nearer_everywhere(c: Any) -> None:
    """The same proof for a limit beyond the truth."""
    claim = c["claims"][0]
    claim["limit"] *= 0.99
    claim["ends"] = [claim["limit"]] * 2
    for leaf in claim["leaves"]:
        leaf["box"][-1] = [claim["limit"]] * 2


def _louder(c: Any) -> None:
    """An output that counts less."""
    _leaf(c)["transform"][-1][-1] = 2.0


def _mixed(c: Any) -> None:
    _leaf(c)["transform"][-1][0] = 0.1


def _as_disk(c: Any) -> None:
    c["claims"][0]["factor"] = "disk"


def _as_noise(c: Any) -> None:
    c["claims"][0]["kind"], c["claims"][0]["factor"] = "noise", "noise"


def _zero(c: Any) -> None:
    c["claims"][0]["limit"] = 0.0


def _wider_disc(c: Any) -> None:
    _leaf(c)["disc"] = [0.0, 0.0, 1.5]


def _stronger_input(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[0][-1] *= 1.5


def _unsure(c: Any) -> None:
    _leaf(c)["beyond"][-1][-1] = 1.0


FORGERIES = [
    _nearer, _nearer_everywhere, _louder, _mixed, _as_disk, _as_noise, _zero, _wider_disc, _stronger_input, _unsure,
]  # fmt: skip


def test_a_certificate_says_the_limit_and_forged_ones_are_refused(proved: Proofs) -> None:
    text = certificate(proved)
    lines = check_certificate(text)
    assert lines[0].startswith(f"step.output to error.output, peak of at most {1.001 * MOST!r}: ")
    for change in FORGERIES:
        with pytest.raises(FalseCertificateError):
            check_certificate(forged(text, change))


def test_a_search_goes_on_from_its_certificate(proved: Proofs, monkeypatch: pytest.MonkeyPatch) -> None:
    known = known_proofs(certificate(proved), graph_digest(GRAPH))
    monkeypatch.setattr(Norm, "improved", lambda norm: pytest.fail("what is proved is searched again"))
    again = about(1.001 * MOST, known=known)
    assert status(again) == ["proved"]


def test_an_input_with_several_values_and_its_certificate() -> None:
    """The hold ticks every second time: the map has two values of step and of error, and one of hold."""
    graph = read_graph_text(INTEGRATING.replace("[blocks.hold]", '[blocks.hold]\nrate = "500 Hz"'))
    found = prove(graph, input="step.output", peak={"hold.output": 1.5, "error.output": 1.5})
    assert status(found) == ["proved", "proved"]
    assert len(check_certificate(certificate(found))) == 2
