"""Certificates of proofs at rest: a search goes on from them, and forged ones are refused."""

from typing import Any

import pytest

from proofmass.runner.design.proof.attempt import known_proofs
from proofmass.runner.design.proof.prove import Proofs
from proofmass.runner.verification.certificates import certificate, graph_digest
from proofmass.runner.verification.proof_checker import FalseCertificateError, check_certificate
from tests.runner.design.proof.test_prove import status
from tests.runner.design.proof.test_rest import LEAST, LOOP, MOST, bias, near_its_ends
from tests.runner.verification.test_certificates import forged


@pytest.fixture(scope="module")
def proved() -> Proofs:
    return near_its_ends()


def test_a_search_goes_on_from_its_certificate(proved: Proofs) -> None:
    known = known_proofs(certificate(proved), graph_digest(LOOP))
    again = bias([0.999 * LEAST, 1.001 * MOST], known=known, gain_margin="17.5 dB", phase_margin="45 deg")
    assert status(again) == ["proved"] * 5
    assert check_certificate(certificate(again)) == check_certificate(certificate(proved))


def _rest_of(c: Any, claim: int = -1) -> Any:
    return c["loops"][c["claims"][claim]["leaves"][0]["loop"]]["rest"]


def _without(c: Any) -> None:
    del c["loops"][c["claims"][-1]["leaves"][0]["loop"]]["rest"]


def _at_the_start(c: Any) -> None:
    c["claims"][0]["at_rest"] = False


def _changing(c: Any) -> None:
    c["claims"][0]["any_change"] = True


def _changed(name: str, change: Any, claim: int = -1) -> Any:
    def forge(c: Any) -> None:
        rest = _rest_of(c, claim)
        rest[name] = change(rest[name])

    return forge


def _nearer(c: Any) -> None:
    claim = c["claims"][-1]
    claim["limit"] = 0.999 * MOST
    claim["ends"] = claim["leaves"][0]["box"][-1] = [claim["limit"]] * 2


FORGERIES = [
    _without, _at_the_start, _changing, _nearer,
    _changed("reach", lambda r: [0.5 * x for x in r]), _changed("reach", lambda r: [-x for x in r]),
    _changed("reach", lambda r: []), _changed("left", lambda m: [[0.0 * x for x in row] for row in m]),
    _changed("left", lambda m: [[-x for x in row] for row in m]),
    _changed("step_radius", lambda b: [x + 10.0 for x in b]),
    _changed("step_radius", lambda b: [-1.0 for _ in b]), _changed("step", lambda b: [[x] for x in b]),
    _changed("matrix", lambda j: [[x + 0.5 for x in row] for row in j]),
    _changed("matrix_radius", lambda j: [[x + 1.0 for x in row] for row in j]),
    _changed("matrix_radius", lambda j: [[-x - 1.0 for x in row] for row in j]),
    _changed("reach", lambda r: [0.1 * x for x in r], 1),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(FORGERIES)))
def test_forged_points_of_rest_are_refused(proved: Proofs, number: int) -> None:
    text = certificate(proved)
    assert [line.split(":")[0] for line in check_certificate(text)][:2] == [
        "main, stable at rest", "main, gain margin of at least 17.5 dB at rest",
    ]  # fmt: skip
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(text, FORGERIES[number]))
