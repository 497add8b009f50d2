"""The parallel plates against equation 8 of Sarraf et al. in exact arithmetic, and against their linear form."""

import math
from fractions import Fraction

import pytest

from proofmass.blocks.mechanics.gap_closing_actuator import GapClosingActuator, force


def exact(p: GapClosingActuator, v: float, x: float) -> Fraction:
    c0, d, bias = Fraction(p.capacitance), Fraction(p.gap), Fraction(p.bias)
    near = c0 * (bias + Fraction(v)) ** 2 / (2 * d * (1 - Fraction(x) / d) ** 2)
    far = c0 * (bias - Fraction(v)) ** 2 / (2 * d * (1 + Fraction(x) / d) ** 2)
    return near - far if p.push_pull else near


@pytest.mark.parametrize("push_pull", [True, False])
def test_against_exact_arithmetic(push_pull: bool) -> None:
    p = GapClosingActuator(push_pull=push_pull)
    for v in (-7.0, 0.0, 1.694, 30.0):
        for x in (-3e-6, -1e-8, 0.0, 2e-7, 3.5e-6):
            expected = exact(p, v, x)
            scale = exact(GapClosingActuator(push_pull=False), abs(v), abs(x))
            assert abs(Fraction(force(p, v, x)) - expected) <= 2e-15 * scale


def test_gain_and_negative_spring_about_rest() -> None:
    p = GapClosingActuator()
    gain = (force(p, 1e-3, 0.0) - force(p, -1e-3, 0.0)) / 2e-3
    assert gain == pytest.approx(2 * p.capacitance * p.bias / p.gap, rel=1e-9)
    for v in (0.0, 1.7):
        spring = (force(p, v, 1e-10) - force(p, v, -1e-10)) / 2e-10
        assert spring == pytest.approx(2 * p.capacitance * (p.bias**2 + v**2) / p.gap**2, rel=1e-6)


@pytest.mark.defect("S8", before="a force beyond the electrode", after="NaN from the contact on: the run ends")
@pytest.mark.parametrize(("way", "pair", "single"), [(0.999, True, True), (1.0, False, False), (5.0, False, False)])
def test_there_is_no_force_from_the_contact_on(way: float, pair: bool, single: bool) -> None:
    both, one = GapClosingActuator(gap=2e-6), GapClosingActuator(gap=2e-6, push_pull=False)
    assert math.isfinite(force(both, 1.0, way * 2e-6)) == pair
    assert math.isfinite(force(both, 1.0, -way * 2e-6)) == pair
    assert math.isfinite(force(one, 1.0, way * 2e-6)) == single
    assert math.isfinite(force(one, 1.0, -way * 2e-6))
