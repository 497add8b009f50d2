"""Certificates about loops in continuous time: forged ones are refused, and the checker's own arithmetic is exact."""

import json
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from proofmass.runner.verification.certificates import certificate
from proofmass.runner.verification.proof_checker import (
    FORMAT,
    ONE,
    FalseCertificateError,
    _check_ends,
    _disc,
    _holds,
    check_certificate,
    digest_of,
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
    _each("stable", lambda leaf: leaf.__setitem__("bends", 1e-9)),
    _each("stable", lambda leaf: leaf["transform"][0].__setitem__(0, 0.0)),
    _each("disk margin", lambda leaf: leaf["transform"][-1].__setitem__(-1, 2.0)),
    _each("disk margin", lambda leaf: leaf["transform"][-1].__setitem__(0, 0.1)),
    _each("stable", lambda leaf: leaf.pop("half_plane")), _claimed("stable", "continuous", 1),
    _claimed("stable", "kind", "peak"), _claimed("delay margin", "any_change", True),
    _set("disk margin", 0, -0.1), _claimed("delay margin", "changes", [0.1]), _claimed("stable", "changes", [0.1, 0.1]),
    _set("phase margin", 2, -0.1), _set("gain margin", 0, -1.0),
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(FORGERIES)))
def test_forged_half_planes_are_refused(proved: str, number: int) -> None:
    with pytest.raises(FalseCertificateError):
        check_certificate(forged(proved, FORGERIES[number]))


def test_what_is_unforged_is_taken(proved: str) -> None:
    assert len(check_certificate(forged(proved, lambda c: None))) == 6
    assert all("half_plane" in leaf for claim in json.loads(proved)["claims"] for leaf in claim["leaves"])


def holds(matrix: Any, off: Any, still: int = 0, x: Any = None) -> bool:
    """Whether all rates near some fall in the norm |X x|, that of Euclid unless given, which T shows as it is."""
    unit = np.eye(len(matrix), dtype=object) * ONE
    x = unit if x is None else x
    return _holds(np.stack([matrix, off]), unit, (x, x @ unit), 0, True, len(matrix) - still)


@pytest.mark.parametrize("off", [1e-12, 0.0, -1e-12])
@pytest.mark.parametrize("fast", [1.0, 1e9])
def test_a_matrix_falls_where_its_symmetric_part_does(off: float, fast: float) -> None:
    """[-1, x; 0, -f] has a determinant of 4 f - x^2, whatever the unit of its second coordinate."""
    x = Fraction(2.0 * float(np.sqrt(fast)) * (1.0 - off))
    m = np.array([[-ONE, int(x * ONE)], [0, -int(fast) * ONE]], dtype=object)
    assert holds(m, 0 * m) == (x * x < 4 * Fraction(fast))


@pytest.mark.parametrize(("size", "positive"), [(0.2, True), (1.01, False)])
def test_what_is_unknown_counts_in_units_alike(size: float, positive: bool) -> None:
    """diag(-1, -1e12) bears an error of 1e6 beside its diagonal; units are powers of two, so that a part is lost."""
    m = np.diag(np.array([-ONE, -(10**12) * ONE], dtype=object))
    unknown = np.array([[0, int(size * 1e6) * ONE], [int(size * 1e6) * ONE, 0]], dtype=object)
    assert holds(m, unknown) == positive
    assert not holds(m, 0 * m, x=np.array([[ONE, ONE], [ONE, ONE]], dtype=object))  # no norm: (1, -1) has no length


@pytest.mark.parametrize("size", [0.9, 1.1])
def test_an_input_and_an_output_keep_the_bounded_real_lemma(size: float) -> None:
    """x' = -x + w, z = g x has a gain of g at rest, and a norm that leaves w and z as they are up to g = 1."""
    m = np.array([[-ONE, ONE], [int(size * ONE), 0]], dtype=object)
    found = []
    for scale in np.linspace(0.3, 3.0, 28):
        turned = m.copy()
        turned[0, 1], turned[1, 0] = int(m[0, 1] / scale), int(m[1, 0] * scale)
        found.append(holds(turned, 0 * m, still=1))
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
    ("plane", "leaves_out"),
    [
        ([0.0, -2.0, 0.5], True), ([0.0, -2.001, 0.5], False), ([0.0, -1.0, 8.0], True), ([0.0, 0.1, 0.5], False),
        ([0.0, -2.0, -0.1], False), ([0.1, -2.0, 0.5], False), ([-1.0, -2.0, 0.5], False),
    ],
)  # fmt: skip
def test_the_half_plane_of_a_delay_leaves_out_what_is_turned_too_far(plane: list[float], leaves_out: bool) -> None:
    """A turn of 1 rad within 0.5 s is that of 2 rad/s or more: no pole may lie from -2 j on down."""
    claim = {"kind": "delay margin", "factor": "phase", "limit": 0.5, "continuous": True}
    assert (_disc(claim, {"half_plane": plane}, (1.0, 1.5)) == 1) == leaves_out
    below = [complex(0.0, -2.0 - t) for t in (0.0, 0.1, 10.0, 1e6)]
    outside = all((complex(1.0, plane[2]) * (s - complex(plane[0], plane[1]))).real >= -1e-9 for s in below)
    assert outside or not leaves_out


@pytest.mark.defect("S800", before="a disk margin of 1.58 was taken, of a loop that has 1.575", after="refused")
def test_the_half_plane_of_a_disk_margin_is_that_of_the_axis() -> None:
    """x' = p u - q x has a (1 + L) / (1 - L) / 2 = a (s - z) / (s + d) / 2, with z = -p - q and d = q - p.

    It is largest at 0, as z > d. To the left of the axis, at s = -c, what is added to it counts against it.
    """
    z, d, a = 1270.0, 1000.0, 1.58
    q, p = 0.5 * (d - z), -0.5 * (d + z)
    worst = 2.0 * d / z

    def is_taken(limit: float, real: float, scale: float) -> bool:
        leaf = {
            "box": [[limit, limit]], "loop": 0, "half_plane": [real, 0.0, 0.0], "beyond": [[0.0, 0.0], [0.0, 0.0]],
            "transform": [[scale, 0.0], [0.0, 1.0]],
        }  # fmt: skip
        claim = {
            "kind": "disk margin", "limit": limit, "factor": "disk", "loop": "main", "open_at": "plant.output",
            "continuous": True, "coordinates": [], "ends": [limit, limit], "leaves": [leaf],
        }  # fmt: skip
        corners = {"middle": [[[-q, 1.0], [p, 0.0]]], "radius": [[[0.0, 0.0], [0.0, 0.0]]]}
        loop = {"order": 1, "values": 1, "box": [], "interpolated": [], "bounded": [], "corners": corners}
        content = {"format": FORMAT, "graph_sha256": "", "claims": [claim], "loops": [loop | {"inputs": 1}]}
        try:
            return bool(check_certificate(json.dumps(content | {"sha256": digest_of(content)})))
        except FalseCertificateError:
            return False

    scales = np.geomspace(1e-5, 1e3, 200).tolist()
    assert any(is_taken(0.99 * worst, 0.0, scale) for scale in scales)
    assert a > worst
    assert not any(is_taken(a, real, scale) for real in (0.0, -0.1, -0.2) for scale in scales)
