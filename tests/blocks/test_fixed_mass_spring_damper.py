"""The reference model in registers against fractions, bit by bit, and against its sibling in floating point."""

from fractions import Fraction

import pytest

from proofmass.blocks.discrete_mass_spring_damper import DiscreteMassSpringDamper
from proofmass.blocks.fixed_mass_spring_damper import FixedMassSpringDamper
from proofmass.blocks.fixed_point import Fixed
from tests.by_hand import drive
from tests.fixed_by_hand import ROUNDINGS, cast, drive_fixed, value_of, words

LARGE, SMALL, STEP = Fixed(24, 6), Fixed(32, 30), Fixed(24, 30)
PERIOD = 2.0**-12 * 1e-3
METHODS = ["forward_euler", "semi_implicit"]


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
        expected.append({"displacement": x, "velocity": v})
        a, k, c = (value_of(row[name], LARGE) for name in ("acceleration", "stiffness", "damping"))
        at, moving = value_of(x, SMALL), value_of(v, SMALL)
        rest = value_of(cast(a - c * moving - k * at, LARGE, rounding, overflow), LARGE)
        v = cast(moving + step * rest, SMALL, rounding, overflow)
        moving = value_of(v, SMALL) if method == "semi_implicit" else moving
        x = cast(at + step * moving, SMALL, rounding, overflow)
    assert drive_fixed(block, rows, PERIOD) == expected
    assert len({row["displacement"] for row in expected}) > 50


@pytest.mark.parametrize("method", METHODS)
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
