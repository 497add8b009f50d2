"""Claims: the factors and discs that stand for them, their limits and words."""

import cmath
import math
from typing import Any

import pytest

from proofmass.runner.design.proof.claim import KINDS, Claim
from proofmass.runner.design.proof.closed_loop import Disc
from proofmass.runner.design.proof.half_plane import HalfPlane

MS = 1e-3


def claim(kind: str, limit: float = 0.0, **more: Any) -> Claim:
    return Claim("main", "error", kind, limit, MS, **more)


def kinds(field: str) -> set[str]:
    return {name for name, row in KINDS.items() if getattr(row, field)}


def test_kinds_of_claims() -> None:
    """A quantity of an output has the unit of this; what lies beside a disc says nothing of a disk margin or a peak."""
    of_output = {"scale factor", "bias", "noise", "peak"}
    assert kinds("of_output") == of_output
    assert {name: row.usual for name, row in KINDS.items() if row.usual is not None} == {
        "gain margin": 6.0, "phase margin": 45.0
    }  # fmt: skip
    assert set(KINDS) - kinds("looks") == {"stable", "gain margin", "phase margin", "decay rate"}
    assert kinds("beside") == {"disk margin", "peak"}
    assert kinds("stays") == {"delay margin", "scale factor", "bias"}
    assert kinds("enters") == {"noise", "peak"}
    assert {name: row.room for name, row in KINDS.items() if row.room != 0.01} == {"scale factor": 1e-6, "bias": 1e-6}
    assert {name: claim(name).unit for name in KINDS if name not in of_output} == {
        "stable": "", "gain margin": "dB", "phase margin": "deg", "disk margin": "1", "delay margin": "s",
        "decay rate": "1/s",
    }  # fmt: skip
    assert claim("peak", unit_of_quantity="V").unit == "V"


def test_factors_of_a_gain_margin_reach_a_little_beyond_it() -> None:
    low, high = claim("gain margin", 6.0).ends
    factor = 10.0**0.3
    assert 0.0 < high / factor - 1.0 < 1e-14
    assert 0.0 < 1.0 - low * factor < 1e-14


@pytest.mark.parametrize(
    ("kind", "limit", "continuous", "ends"),
    [
        ("phase margin", 45.0, False, (0.0, math.nextafter(math.pi / 4.0, 9.0))),
        ("disk margin", 0.5, False, (0.5, 0.5)),
        ("peak", 2.0, False, (2.0, 2.0)),
        ("stable", 0.0, False, (1.0, 1.0)),
        ("decay rate", 7.0, False, (1.0, 1.0)),
        ("delay margin", 0.2 * MS, False, (0.0, 0.2 * math.pi)),
        ("delay margin", 5.0 * MS, False, (0.0, 2.0 * math.pi)),  # further the pole would have turned once
        ("delay margin", 0.2 * MS, True, (0.0, 2.0 * math.pi)),
    ],
)
def test_factors_at_the_wire(kind: str, limit: float, continuous: bool, ends: tuple[float, float]) -> None:
    found = claim(kind, limit, continuous=continuous).ends
    assert found == pytest.approx(ends, rel=1e-14)
    assert found[1] >= ends[1]


def test_discs_of_stable_loops_and_of_those_that_decay() -> None:
    unit = [Disc(0.0, 0.0, 1.0)]
    assert claim("stable").discs((1.0, 1.0)) == unit
    assert claim("delay margin", MS).discs((0.0, 1.0)) == unit
    assert claim("gain margin", 6.0).discs((0.5, 2.0)) == unit
    (disc,) = claim("decay rate", 200.0).discs((1.0, 1.0))
    assert (disc.real, disc.imaginary) == (0.0, 0.0)
    assert 0.0 < 1.0 - disc.radius / math.exp(-0.2) < 2e-14


def test_half_planes_in_continuous_time() -> None:
    assert claim("stable", continuous=True).discs((1.0, 1.0)) == [HalfPlane()]
    assert claim("decay rate", 7.0, continuous=True).discs((1.0, 1.0)) == [HalfPlane(real=-7.0)]
    assert claim("delay margin", 0.25, continuous=True).discs((0.0, 1.0)) == [HalfPlane()]
    planes: Any = claim("delay margin", 0.25, continuous=True).discs((0.5, 1.0))
    assert [plane.tilt for plane in planes] == [0.0, 0.1, 0.5, 1.0, 2.0, 8.0]
    assert all(0.0 < 1.0 + plane.imaginary / 2.0 < 2e-14 for plane in planes)
    assert {plane.real for plane in planes} == {0.0}


def test_discs_of_a_delay_leave_out_the_arc_of_frequencies_that_it_turns() -> None:
    """A delay of half a period that turns by 0.3 turns what has the frequency 0.6 or more: that arc lies outside."""
    discs: Any = claim("delay margin", 0.5 * MS).discs((0.3, 0.4))
    assert [abs(complex(disc.real, disc.imaginary)) for disc in discs] == pytest.approx([0.0, 0.1, 0.5, 1.0, 2.0, 8.0])
    for disc in discs:
        centre = complex(disc.real, disc.imaginary)
        ends = [abs(cmath.exp(-1j * w) - centre) / disc.radius - 1.0 for w in (0.6, math.pi)]
        assert all(0.0 < beyond < 2e-14 for beyond in ends)
        assert abs(cmath.exp(-0.5j * (0.6 + math.pi)) - centre) >= disc.radius
        assert abs(cmath.exp(0.3j) - centre) <= disc.radius * (1.0 + 2e-14)


@pytest.mark.parametrize(
    ("more", "moves", "one_norm", "parts"),
    [
        ({"kind": "stable"}, False, False, False),
        ({"kind": "stable", "any_change": True}, True, True, False),
        ({"kind": "stable", "changes": (1.0,)}, True, False, True),
        ({"kind": "peak", "changes": (1.0,)}, True, True, False),
        ({"kind": "stable", "changes": (1.0,), "continuous": True}, True, True, False),
        ({"kind": "peak"}, False, False, False),
    ],
)
def test_how_parameters_may_move(more: dict[str, Any], moves: bool, one_norm: bool, parts: bool) -> None:
    of = claim(**more)
    assert (of.moves, of.in_one_norm, of.in_parts) == (moves, one_norm, parts)


def test_a_limit_itself_does_not_break_a_claim() -> None:
    least, most = claim("gain margin", 6.0), claim("peak", 6.0, most=True)
    assert [least.broken_by(value) for value in (5.9, 6.0, 6.1)] == [True, False, False]
    assert [most.broken_by(value) for value in (5.9, 6.0, 6.1)] == [False, False, True]
    assert (least.sign, most.sign) == (1.0, -1.0)


@pytest.mark.parametrize(
    ("kind", "limit", "rounded"),
    [
        ("gain margin", 6.789, 6.78),
        ("phase margin", 45.678, 45.67),
        ("decay rate", 1234.567, 1234.0),
        ("decay rate", 0.01234567, 0.01234),
        ("decay rate", 9.9999, 9.999),
        ("decay rate", -1.231, -1.24),
        ("decay rate", 0.0, 0.0),
    ],
)
def test_limits_that_are_looked_for_are_rounded_down(kind: str, limit: float, rounded: float) -> None:
    assert claim(kind).rounded(limit) == pytest.approx(rounded, rel=1e-12)


@pytest.mark.parametrize(
    ("of", "words"),
    [
        (claim("stable"), "stable"),
        (claim("gain margin", 6.5), "gain margin of at least 6.5 dB"),
        (claim("decay rate", 1234.5678), "decay rate of at least 1234.57 1/s"),
        (claim("disk margin", 0.25, at_rest=True), "disk margin of at least 0.25 at rest"),
        (claim("stable", any_change=True), "stable under any change"),
        (claim("stable", changes=(1.0,)), "stable under slow change"),
        (claim("peak", 0.002, most=True, unit_of_quantity="V"), "peak of at most 2 mV"),
        (claim("bias", -0.002, unit_of_quantity="V", at_rest=True), "bias of at least \N{MINUS SIGN}2 mV"),
        (claim("peak", math.inf, most=True), "peak, upper bound"),
        (claim("bias", -math.inf), "bias, lower bound"),
    ],
)
def test_claims_in_words(of: Claim, words: str) -> None:
    assert str(of) == words


def test_what_a_claim_is_about() -> None:
    assert claim("stable").about == "main"
    assert claim("peak").about == "main to error"
    assert Claim("", "error", "noise", 1.0).about == "error"
    assert Claim("", "error", "noise", 1.0).period == 0.0
    assert claim("gain margin").shown(6.78901) == "6.789 dB"
    assert claim("delay margin").shown(0.0123456) == "12.35 ms"
