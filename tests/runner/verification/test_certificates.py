"""Certificates of proofs: what the checker says of them, and forged ones that it refuses."""

import ast
import json
import random
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from proofmass.runner.design.proof.prove import prove
from proofmass.runner.verification import box_checker, proof_checker
from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate, digest_of
from tests.runner.design.proof.test_prove import GRAPH


@pytest.fixture(scope="module")
def proved() -> str:
    graph = GRAPH.with_parameters({"gain.gain": 500.0})
    return certificate(prove(graph, tolerances={"gain.gain": "30 %", "hold.gain": "20 %"}, gain_margin="2 dB"))


def test_a_certificate_is_what_its_checker_says(proved: str) -> None:
    lines = check_certificate(proved)
    assert [line.split(":")[0] for line in lines] == [
        "main, stable",
        "main, gain margin of at least 2 dB",
        "main, phase margin of at least 45 deg",
    ]


def same_numbers(text: str, other: str) -> bool:
    """Whether two texts are read as the same: a last digit may lead to the same double."""
    try:
        return bool(json.loads(text) == json.loads(other))
    except ValueError:
        return False


def test_a_changed_certificate_is_refused(proved: str) -> None:
    draw, seen = random.Random(1), 0
    digits = [i for i, letter in enumerate(proved) if letter.isalnum()]
    for _ in range(300):
        place = draw.choice(digits)
        letter = draw.choice("0123456789")
        changed = proved[:place] + letter + proved[place + 1 :]
        if not same_numbers(changed, proved):
            seen += 1
            with pytest.raises(FalseCertificateError):
                check_certificate(changed)
    assert seen > 200
    for text in ("", "[]", "{}", "null", '{"format": "proofmass proof 1"}', proved[: len(proved) // 2]):
        with pytest.raises(FalseCertificateError):
            check_certificate(text)


def forged(text: str, change: Any) -> str:
    """A certificate with something changed, and a hash that is right again."""
    content = json.loads(text)
    content.pop("sha256")
    change(content)
    return json.dumps(content | {"sha256": digest_of(content)})


def _wider(c: Any) -> None:
    c["claims"][1]["coordinates"][0]["high"] *= 1.001


def _more(c: Any) -> None:
    c["claims"][1]["limit"] = 2.001


def _other_factor(c: Any) -> None:
    c["claims"][2]["factor"] = "gain"


def _half(c: Any) -> None:
    c["claims"][1]["leaves"] = c["claims"][1]["leaves"][:-1]


def _grown(c: Any) -> None:
    for loop in c["loops"]:
        loop["corners"]["middle"][0][0][0] = 5.0


def _unsure(c: Any) -> None:
    for leaf in c["claims"][0]["leaves"]:
        leaf["beyond"][0][0] = 1.0


def _negative(c: Any) -> None:
    c["claims"][0]["leaves"][0]["beyond"][0][0] = -1.0


def _bent(c: Any) -> None:
    """More beyond the corners, in the norm itself, than there is room."""
    for leaf in c["claims"][0]["leaves"]:
        leaf["bends"] = 1.0


def _bent_inwards(c: Any) -> None:
    c["claims"][0]["leaves"][0]["bends"] = -1e-9


def _flat(c: Any) -> None:
    c["claims"][0]["leaves"][0]["transform"][0][0] = 0.0


def _no_claim(c: Any) -> None:
    c["claims"] = []


def _below_nothing(c: Any) -> None:
    c["claims"][1]["limit"] = -6.0


def _half_a_turn(c: Any) -> None:
    """A triangle about half a turn or more would point the other way."""
    c["claims"][2]["ends"][1] = c["claims"][2]["leaves"][0]["box"][-1][1] = 3.5
    c["claims"][2]["leaves"] = c["claims"][2]["leaves"][:1]


def _fewer_corners(c: Any) -> None:
    for loop in c["loops"]:
        for part in ("middle", "radius"):
            loop["corners"][part] = loop["corners"][part][:-1]


def _narrow_loop(c: Any) -> None:
    for loop in c["loops"]:
        loop["box"] = [[low, low] for low, _ in loop["box"]]


FORGERIES = [
    _wider,
    _more,
    _other_factor,
    _half,
    _grown,
    _unsure,
    _negative,
    _bent,
    _bent_inwards,
    _flat,
    _half_a_turn,
    _no_claim,
    _below_nothing,
    _fewer_corners,
    _narrow_loop,
]


@pytest.mark.parametrize("change", FORGERIES, ids=lambda change: change.__name__)
def test_a_forged_certificate_is_refused(proved: str, change: Any) -> None:
    assert check_certificate(forged(proved, lambda c: None))
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(proved, change))


def test_the_checker_says_what_it_has_checked_not_what_the_file_says(proved: str) -> None:
    def boast(c: Any) -> None:
        c["claims"][1]["claim"] = "gain margin of at least 60 dB"

    line = check_certificate(forged(proved, boast))[1]
    assert line.startswith("main, gain margin of at least 2 dB: ")
    assert "gain.gain from 350 to 650" in line


@pytest.mark.parametrize(
    ("checker", "others"),
    [
        (
            proof_checker,
            {"box_checker", "digital_checker"},
        ),  # fixed point is another theorem, with a checker of its own
        (box_checker, set[str]()),
    ],
)
def test_a_checker_shares_no_code_and_is_short(checker: ModuleType, others: set[str]) -> None:
    text = Path(str(checker.__file__)).read_text(encoding="utf-8")
    names = {
        alias.name if isinstance(node, ast.Import) else node.module
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Import | ast.ImportFrom)
        for alias in node.names
    }
    of_ours = {str(name) for name in names if str(name).startswith("proofmass")}
    assert of_ours == {f"proofmass.runner.verification.{name}" for name in others}
    assert len(text.splitlines()) <= 300
