"""Certificates about loops in continuous time: forged ones are refused, and the checker's own arithmetic is exact."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import (
    ONE,
    FalseCertificateError,
    _check_ends,
    _has_disc,
    _holds,
    check_certificate,
)
from tests.runner.design.proof.test_continuous_loops import proofs
from tests.runner.verification.test_certificates import forged


@pytest.fixture(scope="module")
def proved() -> str:
    return certificate(proofs(0.9))


def _claim(c: Any, kind: str) -> Any:
    return next(one for one in c["claims"] if one["kind"] == kind)


def _each(kind: str, change: Any) -> Any:
    def forge(c: Any) -> None:
        for leaf in _claim(c, kind)["leaves"]:
            change(leaf)

    return forge


def _set(kind: str, place: int, value: float) -> Any:
    return _each(kind, lambda leaf: leaf["half_plane"].__setitem__(place, value))


def _claimed(kind: str, key: str, value: Any) -> Any:
    return lambda c: _claim(c, kind).__setitem__(key, value)


def _scaled(kind: str, part: float) -> Any:
    return lambda c: _claim(c, kind).__setitem__("limit", part * _claim(c, kind)["limit"])


def _corners(value: float) -> Any:
    """The rates of an integrator with another one of its own, or with a way around it."""

    def forge(c: Any) -> None:
        for loop in c["loops"]:
            for corner in loop["corners"]["middle"]:
                corner[0][0] = value

    return forge


def _direct(c: Any) -> None:
    for loop in c["loops"]:
        for corner in loop["corners"]["middle"]:
            corner[1][1] = 0.5


def _as_sampled(c: Any) -> None:
    """Rates are no map: their disc would be another claim."""
    for claim in c["claims"]:
        claim["continuous"] = False
        for leaf in claim["leaves"]:
            leaf["disc"] = [0.0, 0.0, 1.0]


def _shorter_delay(c: Any) -> None:
    claim = _claim(c, "delay margin")
    claim["leaves"] = [leaf for leaf in claim["leaves"] if leaf["box"][-1][1] < claim["ends"][1]]


FORGERIES = [
    _scaled("decay rate", 1.2), _scaled("delay margin", 1.2), _scaled("disk margin", 1.2), _shorter_delay,
    _set("decay rate", 0, -2.0), _set("decay rate", 0, -3.5), _set("decay rate", 2, 0.1), _set("decay rate", 1, -0.1),
    _set("stable", 0, 0.1), _set("stable", 1, 0.1), _set("stable", 2, 1.0), _set("delay margin", 2, -1.0),
    _set("delay margin", 1, 1.0), _set("delay margin", 1, -100.0), _set("delay margin", 0, 0.1),
    _set("phase margin", 0, -100.0), _claimed("phase margin", "limit", 91.0), _as_sampled, _corners(3.5), _direct,
    _each("stable", lambda leaf: leaf["beyond"][0].__setitem__(0, 3.0)),
    _each("stable", lambda leaf: leaf["beyond"][0].__setitem__(0, -1.0)),
    _each("stable", lambda leaf: leaf["transform"][0].__setitem__(0, 0.0)),
    _each("disk margin", lambda leaf: leaf["transform"][-1].__setitem__(-1, 2.0)),
    _each("disk margin", lambda leaf: leaf["transform"][-1].__setitem__(0, 0.1)),
    _each("stable", lambda leaf: leaf.pop("half_plane")), _claimed("stable", "continuous", 1),
    _claimed("stable", "kind", "peak"), _claimed("delay margin", "any_change", True),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(FORGERIES)))
def test_forged_half_planes_are_refused(proved: str, number: int) -> None:
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(proved, FORGERIES[number]))


def test_what_is_unforged_is_taken(proved: str) -> None:
    assert len(check_certificate(forged(proved, lambda c: None))) == 6
    assert all("half_plane" in leaf for claim in json.loads(proved)["claims"] for leaf in claim["leaves"])


@pytest.mark.parametrize("off", [1e-12, 0.0, -1e-12])
@pytest.mark.parametrize("fast", [1.0, 1e9])
def test_a_matrix_falls_where_its_symmetric_part_does(off: float, fast: float) -> None:
    """[-1, x; 0, -f] has a determinant of 4 f - x^2, whatever the unit of its second coordinate."""
    x = Fraction(2.0 * float(np.sqrt(fast)) * (1.0 - off))
    m = np.array([[-ONE, int(x * ONE)], [0, -int(fast) * ONE]], dtype=object)
    nothing = np.zeros((2, 2), dtype=object)
    assert _holds((m, nothing), nothing, 0, True, 0) == (x * x < 4 * Fraction(fast))


@pytest.mark.parametrize(("size", "holds"), [(0.2, True), (1.01, False)])
def test_what_is_unknown_counts_in_units_alike(size: float, holds: bool) -> None:
    """diag(-1, -1e12) bears an error of 1e6 beside its diagonal; units are powers of two, so that a part is lost."""
    m = np.diag(np.array([-ONE, -(10**12) * ONE], dtype=object))
    unknown = np.array([[0, int(size * 1e6) * ONE], [int(size * 1e6) * ONE, 0]], dtype=object)
    assert _holds((m, unknown), 0 * m, 0, True, 0) == holds
    assert not _holds((m, 0 * m + 1), np.diag(np.array([ONE, ONE], dtype=object)), 0, True, 0)


@pytest.mark.parametrize("size", [0.9, 1.1])
def test_an_input_and_an_output_keep_the_bounded_real_lemma(size: float) -> None:
    """x' = -x + w, z = g x has a gain of g at rest, and a norm that leaves w and z as they are up to g = 1."""
    m = np.array([[-ONE, ONE], [int(size * ONE), 0]], dtype=object)
    found = []
    for scale in np.linspace(0.3, 3.0, 28):
        turned = m.copy()
        turned[0, 1], turned[1, 0] = int(m[0, 1] / scale), int(m[1, 0] * scale)
        found.append(_holds((turned, 0 * m), 0 * m, 0, True, 1))
    assert any(found) == (size < 1.0)


def test_a_decay_rate_has_a_period_or_is_said_to_have_none() -> None:
    claim = {"kind": "decay rate", "limit": 3.0, "factor": "gain", "ends": [1.0, 1.0]}
    _check_ends({**claim, "continuous": True}, "here")
    for wrong in (False, 1, "yes", None):
        with pytest.raises(FalseCertificateError):
            _check_ends({**claim, "continuous": wrong}, "here")
    delay = {"kind": "delay margin", "limit": 1.0, "factor": "phase", "continuous": True}
    _check_ends({**delay, "ends": [0.0, 6.2832]}, "here")
    with pytest.raises(FalseCertificateError):
        _check_ends({**delay, "ends": [0.0, 6.2831]}, "here")


@pytest.mark.parametrize(
    ("plane", "holds"),
    [
        ([0.0, -2.0, 0.5], True), ([0.0, -2.001, 0.5], False), ([0.0, -1.0, 8.0], True), ([0.0, 0.1, 0.5], False),
        ([0.0, -2.0, -0.1], False), ([0.1, -2.0, 0.5], False), ([-1.0, -2.0, 0.5], True),
    ],
)  # fmt: skip
def test_the_half_plane_of_a_delay_leaves_out_what_is_turned_too_far(plane: list[float], holds: bool) -> None:
    """A turn of 1 rad within 0.5 s is that of 2 rad/s or more: no pole may lie from -2 j on down."""
    claim = {"kind": "delay margin", "limit": 0.5, "continuous": True}
    assert _has_disc(claim, {"half_plane": plane}, (1.0, 1.5)) == holds
    below = [complex(0.0, -2.0 - t) for t in (0.0, 0.1, 10.0, 1e6)]
    outside = all((complex(1.0, plane[2]) * (s - complex(plane[0], plane[1]))).real >= -1e-9 for s in below)
    assert outside or not holds
