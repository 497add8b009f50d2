"""Scale factors over tolerances: closed forms, random loops with truth by hand, what is no scale factor, certificates.

The integrating loop settles to hold.output = step.output: the plant, before a gain h, to 1 / h of it.
"""

import itertools
import json
import random
from typing import Any

import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.graphs.files.toml_reader import read_graph_text
from proofmass.graphs.model.graph import Graph
from proofmass.runner.design.proof import rest_norm
from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs, prove
from proofmass.runner.design.proof.text import proofs_text
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.by_hand.amounts import amounts, chosen
from tests.by_hand.toleranced_loops import random_loop
from tests.runner.design.proof.test_prove import GRAPH, INTEGRATING, status
from tests.runner.verification.test_certificates import forged

WITHIN = {"hold.gain": "10 %"}
LEAST, MOST = 1.0 / 1.1, 1.0 / 0.9


def about(limits: Any, output: str = "plant.output", graph: Graph = GRAPH, **more: Any) -> Proofs:
    more = {"tolerances": WITHIN, "input": "step.output"} | more
    return prove(graph, scale_factor={output: limits}, **more)


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return about([0.999 * LEAST, 1.001 * MOST])


def extended(*wires: str, blocks: str) -> Graph:
    more = "".join(f', "{wire}"' for wire in wires)
    return read_graph_text(
        INTEGRATING.replace('hold.output -> error.second"', f'hold.output -> error.second"{more}') + blocks
    )


def test_limits_are_proved_up_to_the_closed_form(proved: Proofs) -> None:
    assert [str(one.claim) for one in proved.proofs] == [
        "scale factor of at least 0.908181818182",
        "scale factor of at most 1.11222222222",
    ]
    assert status(proved) == ["proved", "proved"]
    found = about([1.01 * LEAST, 0.99 * MOST])
    assert status(found) == ["refuted", "refuted"]
    for proof, end in zip(found.proofs, (1.1, 0.9), strict=True):
        assert proof.counterexample == {"hold.gain": pytest.approx(end)}
    assert status(about(f"{0.99 * LEAST}..")) == ["proved"]
    assert status(about(f"..{0.99 * MOST}")) == ["refuted"]


def test_a_negative_scale_factor_has_both_limits() -> None:
    graph = extended("plant.output -> turned.input", blocks='[blocks.turned]\nkind = "Negation"\n')
    assert status(about([-1.001 * MOST, -0.999 * LEAST], "turned.output", graph)) == ["proved", "proved"]
    assert status(about([-0.99 * MOST, -1.01 * LEAST], "turned.output", graph)) == ["refuted", "refuted"]


def test_bounds_come_near_what_is_found_and_do_not_pass_it() -> None:
    found = about("")
    least, most = found.proofs
    assert (least.status, most.status) == ("proved", "proved")
    assert 0.995 * LEAST < least.claim.limit < LEAST
    assert MOST < most.claim.limit < 1.005 * MOST
    assert least.least is not None
    assert least.least.margin == pytest.approx(LEAST)
    text = proofs_text(found)
    assert "0.90909091 found" in text
    assert 'response GRAPH step.output plant.output --at "0 s" --set "hold.gain=1.1"' in text


@pytest.mark.exhaustive
def test_given_limits_may_be_tightened() -> None:
    for proof, bound in zip(about([0.5, 2.0], bounds=True).proofs, about("").proofs, strict=True):
        assert proof.claim.limit == bound.claim.limit


@pytest.mark.exhaustive
def test_what_stays_as_it_is_has_bounds_next_to_it() -> None:
    for output, value in (("hold.output", 1.0), ("error.output", 0.0)):
        for proof in about("", output).proofs:
            assert proof.status == "proved"
            assert abs(proof.claim.limit - value) < 2e-6
            assert proof.claim.sign * (value - proof.claim.limit) > 0.0


def test_an_output_that_does_not_follow_the_input_has_zero() -> None:
    graph = extended(
        "other.output -> doubled.input",
        blocks='[blocks.other]\nkind = "Step"\nunit = "1"\n[blocks.doubled]\nkind = "Gain"\n',
    )
    assert status(about([-1e-9, 1e-9], "doubled.output", graph)) == ["proved", "proved"]
    assert status(about([1e-9, 1.0], "doubled.output", graph)) == ["refuted", "proved"]
    found = about([0.0, 0.0], "doubled.output", graph, tolerances=None)
    assert status(found) == ["open", "open"]
    assert "too near the limit" in found.proofs[0].searched.why


@pytest.mark.exhaustive
def test_an_integrator_on_the_way_has_no_scale_factor() -> None:
    graph = extended(
        "hold.output -> more.input", blocks='[blocks.more]\nkind = "DiscreteIntegrator"\noutput_unit = "1"\n'
    )
    for limits in ([-1e9, 1e9], ""):
        found = about(limits, "more.output", graph)
        assert status(found) == ["refuted", "refuted"]
        assert found.proofs[0].shown == "it does not settle"
        assert json.loads(json.dumps(found.as_data(), allow_nan=False))["proved"] is False
    unstable = about([-1e9, 1e9], tolerances={"gain.gain": ["90", "2500"]})
    assert status(unstable) == ["refuted", "refuted"]
    assert (unstable.proofs[0].counterexample or {})["gain.gain"] > 2000.0


def test_what_does_not_show_may_stay() -> None:
    """A difference of an integrator and itself settles, but the integrator does not: this has no proof."""
    graph = extended(
        "hold.output -> more.input", "more.output -> none.first", "more.output -> none.second",
        "none.output -> seen.first", "hold.output -> seen.second",
        blocks='[blocks.more]\nkind = "DiscreteIntegrator"\noutput_unit = "1"\n[blocks.none]\nkind = "Difference"\n'
        '[blocks.seen]\nkind = "Sum"\n',
    )  # fmt: skip
    found = about([-2.0, 2.0], "seen.output", graph)
    assert set(status(found)) <= {"open", "proved"}


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"input": "step.outputt"}, "did you mean output"),
        ({"input": ""}, "needs an input"),
        ({"input": "plant.output"}, "is the input itself"),
        ({"output": "plan.output"}, "did you mean plant"),
        ({"limits": "2 V..3 V"}, "V is"),
        ({"limits": "3..2"}, "no value lies between"),
        ({"limits": "3"}, "not two limits"),
        ({"limits": [None, "much"]}, "much"),
        ({"limits": [float("nan"), 1.0]}, "no value lies between"),
    ],
    ids=str,
)
def test_wrong_words_are_answered(more: dict[str, Any], words: str) -> None:
    given: dict[str, Any] = {"limits": [0.5, 2.0]} | more
    with pytest.raises(ModelError) as refused:
        about(**given)
    assert words in str(refused.value)


# -- truth -------------------------------------------------------------------------------------------------------------

SAMPLE = (0, 3, 7, 34)


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
    stable = all(loop.radius(one) < 1.0 for one in sensors)
    values = [loop.scale_factor(one, element.name) for one in (sensors if stable else [loop.values])]
    room = max(max(values) - min(values), 1e-3 * max(map(abs, values)), 1e-9)
    off = draw.choice((0.3, 0.1, 0.03, -0.01, -0.1))
    limits = sorted((min(values) - off * room, max(values) + off * room))
    found = prove(
        loop.graph(),
        tolerances={name: f"{100.0 * width} %" for name, width in widths},
        input="gain.output",
        scale_factor={element.last: limits},
        seconds=6.0,
    )
    for proof in found.proofs:
        limit, sign = proof.claim.limit, proof.claim.sign
        if proof.status == "proved":
            assert stable
            assert all(sign * (value - limit) > -1e-9 * abs(limit) for value in values)
        if proof.status == "refuted":
            broken = loop.values | dict(proof.counterexample or {})
            value = loop.scale_factor(broken, element.name)
            assert loop.radius(broken) > 1.0 - 1e-9 or sign * (value - limit) < 1e-9 * abs(limit)
    if any(proof.status == "proved" for proof in found.proofs):
        assert check_certificate(certificate(found))


@pytest.mark.exhaustive
def test_the_accelerometer_has_bounds_by_its_closed_form() -> None:
    """At rest the torque of the code balances that of the acceleration: N = -m 2^20 R / (2 V k)."""
    found = prove(
        "library:closed_loop_accelerometer",
        tolerances={"torquer.gain": "5 %", "pendulosity.gain": "2 %"},
        input="acceleration.output",
        scale_factor={"dac.code": ""},
    )
    ends = [-8.0e-6 * m * 2.0**20 * 342.0 / (2.0 * 2.5 * 0.065 * k) for m, k in ((1.02, 0.95), (0.98, 1.05))]
    for proof, end, widened in zip(found.proofs, ends, (1.01, 0.99), strict=True):
        assert proof.status == "proved"
        assert proof.least is not None
        assert proof.least.margin == pytest.approx(end, rel=1e-6)
        assert 0.0 < proof.claim.sign * (end - proof.claim.limit) <= proof.claim.sign * end * (1.0 - widened)


# -- certificates ------------------------------------------------------------------------------------------------------


def _leaf(c: Any, claim: int = 0) -> Any:
    return c["claims"][claim]["leaves"][0]


def _nearer(c: Any) -> None:
    c["claims"][0]["limit"] *= 1.001


def _nearer_everywhere(c: Any) -> None:
    """The same proof for a limit beyond the truth."""
    claim = c["claims"][0]
    claim["limit"] *= 1.01
    claim["ends"] = claim["leaves"][0]["box"][-1] = [claim["limit"]] * 2


def _other_side(c: Any) -> None:
    c["claims"][0]["most"] = True


def _upper_as_lower(c: Any) -> None:
    c["claims"][1]["most"] = False


def _unknown_side(c: Any) -> None:
    del c["claims"][0]["most"]


def _turned_around(c: Any) -> None:
    """An R with another sign has another side, and no norm."""
    c["claims"][0]["most"] = True
    _leaf(c)["left"] = [[-value for value in row] for row in _leaf(c)["left"]]


def _one_row(c: Any) -> None:
    _leaf(c)["left"] = _leaf(c)["left"][:1]


def _no_left(c: Any) -> None:
    del _leaf(c)["left"]


def _no_inverse(c: Any) -> None:
    _leaf(c)["left"] = [[0.0 for _ in row] for row in _leaf(c)["left"]]


def _unstable(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[0][0] = 1.5


def _wider_disc(c: Any) -> None:
    _leaf(c)["disc"] = [0.0, 0.0, 1.5]


def _moved_disc(c: Any) -> None:
    _leaf(c)["disc"] = [1.0, 0.0, 1.0]


def _another_factor(c: Any) -> None:
    c["claims"][0]["factor"] = "disk"


def _wider_box(c: Any) -> None:
    c["claims"][0]["coordinates"][0]["low"] *= 0.99


def _unsure(c: Any) -> None:
    _leaf(c)["beyond"][-1][-1] = 1.0


FORGERIES = [
    _nearer, _nearer_everywhere, _other_side, _upper_as_lower, _unknown_side, _turned_around, _one_row, _no_left,
    _no_inverse, _unstable, _wider_disc, _moved_disc, _another_factor, _wider_box, _unsure,
]  # fmt: skip


def test_a_certificate_says_both_limits_and_forged_ones_are_refused(proved: Proofs) -> None:
    text = certificate(proved)
    assert [line.split(":")[0] for line in check_certificate(text)] == [
        f"step.output to plant.output, scale factor of at least {0.999 * LEAST!r}",
        f"step.output to plant.output, scale factor of at most {1.001 * MOST!r}",
    ]
    for change in FORGERIES:
        with pytest.raises(FalseCertificateError):
            check_certificate(forged(text, change))


def test_a_search_goes_on_from_its_certificate(proved: Proofs, monkeypatch: pytest.MonkeyPatch) -> None:
    known = known_proofs(certificate(proved), graph_digest(GRAPH))
    monkeypatch.setattr(rest_norm, "_descended", lambda *_: pytest.fail("what is proved is searched again"))
    again = about([0.999 * LEAST, 1.001 * MOST], known=known)
    assert status(again) == ["proved", "proved"]
    assert check_certificate(certificate(again))


@pytest.mark.parametrize("kind", amounts("several rates", "no tolerance"))
def test_loops_and_quantities_are_claimed_together(kind: str) -> None:
    graph = GRAPH.with_parameters({"gain.gain": 50.0})
    if kind == "several rates":
        text = INTEGRATING.replace("[blocks.hold]", '[blocks.hold]\nrate = "500 Hz"')
        graph = read_graph_text(text.replace('open_at = "hold', 'open_at = "plant'))
    found = about([0.99, 1.01], "hold.output", graph, tolerances=None, gain_margin="6 dB")
    assert [one.claim.kind for one in found.proofs] == [
        "stable", "gain margin", "phase margin", "scale factor", "scale factor",
    ]  # fmt: skip
    assert status(found) == ["proved"] * 5
    assert len(check_certificate(certificate(found))) == 5
