"""The parallel plates against equation 8 of Sarraf et al. in exact arithmetic, and against their linear form."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy.constants import epsilon_0

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


@pytest.mark.derivation(
    GapClosingActuator,
    equation="F = C0 d (Vdc + v)^2 / (2 (d - x)^2), less that of the other plate with Vdc - v and d + x",
    source="virtual work by mpmath; the voltage of pull-in of the textbook, sqrt(8 k d^3 / (27 eps0 A))",
    convention="C0 and d are of one side at rest, x towards the plate; V is not the rms of an alternating one",
)
def test_virtual_work_and_the_pull_in_of_the_textbook() -> None:
    """Plates of 100 um by 100 um, 2 um apart, on 1 N/m: 5.17 V (Senturia, Microsystem Design, section 6.4)."""
    area, gap, spring = 1e-8, 2e-6, 1.0
    c0 = epsilon_0 * area / gap
    pair = GapClosingActuator(bias=4.0, capacitance=c0, gap=gap)

    def energy(x: mpmath.mpf) -> mpmath.mpf:
        return 0.5 * epsilon_0 * area * ((4.0 + 1.5) ** 2 / (gap - x) + (4.0 - 1.5) ** 2 / (gap + x))

    for x in (0.0, 0.6e-6, -1.2e-6):
        assert force(pair, 1.5, x) == pytest.approx(float(mpmath.diff(energy, x)), rel=1e-9)
    ways = np.linspace(0.0, 0.999 * gap, 20_001)[1:]
    one_volt = GapClosingActuator(bias=1.0, capacitance=c0, gap=gap, push_pull=False)
    holds = np.sqrt(spring * ways / [force(one_volt, 0.0, x) for x in ways])
    assert holds.max() == pytest.approx(5.17, abs=5e-3)
    assert ways[holds.argmax()] == pytest.approx(gap / 3.0, rel=1e-3)
