"""The reference model in registers against fractions, bit by bit, and against its sibling in floating point."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks import DiscreteMassSpringDamper, FixedMassSpringDamper
from proofmass.blocks.arithmetic.fixed_point import Fixed
from tests.by_hand.fixed_point import ROUNDINGS, cast, drive_fixed, value_of, words
from tests.by_hand.functions import drive

LARGE, SMALL, STEP = Fixed(24, 6), Fixed(32, 30), Fixed(24, 30)
PERIOD = 2.0**-12 * 1e-3
METHODS = ["forward_euler", "semi_implicit", "leapfrog"]


@pytest.mark.exhaustive(but=4)
@pytest.mark.parametrize("overflow", ["saturate", "wrap"])
@pytest.mark.parametrize("rounding", ROUNDINGS)
@pytest.mark.parametrize("method", METHODS)
def test_against_fractions(method: str, rounding: str, overflow: str) -> None:
    block = FixedMassSpringDamper(method=method, rounding=rounding, overflow=overflow)
    rows = [
        {"acceleration": a, "stiffness": k, "damping": c}
        for a, k, c in zip(*(words(LARGE, 200, seed=seed) for seed in (1, 2, 3)), strict=True)
    ]
    step, x, v, expected = Fraction(1, 2**12), 0, 0, []
    for row in rows:
        seen = cast(value_of(x, SMALL) - step / 2 * value_of(v, SMALL), SMALL, rounding, overflow)
        expected.append({"displacement": seen if method == "leapfrog" else x, "velocity": v})
        a, k, c = (value_of(row[name], LARGE) for name in ("acceleration", "stiffness", "damping"))
        at, moving = value_of(x, SMALL), value_of(v, SMALL)
        rest = value_of(cast(a - c * moving - k * at, LARGE, rounding, overflow), LARGE)
        v = cast(moving + step * rest, SMALL, rounding, overflow)
        moving = moving if method == "forward_euler" else value_of(v, SMALL)
        x = cast(at + step * moving, SMALL, rounding, overflow)
    assert drive_fixed(block, rows, PERIOD) == expected
    assert len({row["displacement"] for row in expected}) > 50


@pytest.mark.exhaustive
@pytest.mark.parametrize("method", METHODS[:2])
def test_against_its_sibling_in_floating_point(method: str) -> None:
    """One g: 0.01 um. The words of k/m, c/m and the acceleration are those of the registers in both."""
    acceleration, stiffness, damping = (round(64 * value) for value in (9.80665, 982.8, 67.42))
    steps = [{"acceleration": acceleration, "stiffness": stiffness, "damping": damping}] * 1500
    found = [row["displacement"] * 2.0**-30 for row in drive_fixed(FixedMassSpringDamper(method=method), steps, PERIOD)]
    sibling = DiscreteMassSpringDamper(
        velocity_at_end=float(method == "semi_implicit"),
        mass=1.0,
        stiffness=stiffness / 64 * 1e6,
        damping=damping / 64 * 1e3,
    )
    expected = [1e6 * row["displacement"] for row in drive(sibling, [{"force": acceleration / 64}] * 1500, PERIOD)]
    assert expected[-1] == pytest.approx(0.00998, rel=1e-2)
    assert found == pytest.approx(expected, abs=1e-3 * 0.00998)


def test_leapfrog_is_of_second_order() -> None:
    """Without damping 1 um/ms^2 from rest makes (1 - cos(2 t)) / 4 um; half the step, a fourth of the error."""
    block = FixedMassSpringDamper(method="leapfrog", large_format=Fixed(24, 16), damping_format=Fixed(24, 16))
    errors = []
    for steps in (64, 128):
        rows = [{"acceleration": 1 << 16, "stiffness": 4 << 16, "damping": 0}] * (2 * steps + 1)
        found = [row["displacement"] * 2.0**-30 for row in drive_fixed(block, rows, 1e-3 / steps)]
        exact = [(1.0 - math.cos(2.0 * n / steps)) / 4.0 for n in range(len(rows))]
        errors.append(max(abs(x - e) for x, e in zip(found, exact, strict=True)))
    assert errors[0] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
