"""The magnet against exact fractions, its gain and negative spring, and its end at the contact."""

import math
from fractions import Fraction

import mpmath
import pytest
from scipy.constants import mu_0

from proofmass.blocks.mechanics.magnetic_levitation import MagneticLevitation, force


@pytest.mark.parametrize("push_pull", [True, False])
def test_against_fractions(push_pull: bool) -> None:
    p = MagneticLevitation(push_pull=push_pull)
    c, i0, d = Fraction(p.force_constant), Fraction(p.bias), Fraction(p.gap)
    for i in (-0.03, 0.0, 0.2):
        for x in (-4e-5, 0.0, 7e-5):
            near, far = (i0 + Fraction(i)) / (d - Fraction(x)), (i0 - Fraction(i)) / (d + Fraction(x))
            pull, back = c * near * near, c * far * far if push_pull else Fraction(0)
            assert abs(Fraction(force(p, i, x)) - (pull - back)) <= 2e-15 * (pull + back)


def test_gain_and_negative_spring_of_a_pair() -> None:
    p = MagneticLevitation(push_pull=True)
    gain = (force(p, 1e-5, 0.0) - force(p, -1e-5, 0.0)) / 2e-5
    spring = (force(p, 0.0, 1e-8) - force(p, 0.0, -1e-8)) / 2e-8
    assert gain == pytest.approx(4.0 * p.force_constant * p.bias / p.gap**2, rel=1e-6)
    assert spring == pytest.approx(4.0 * p.force_constant * p.bias**2 / p.gap**3, rel=1e-6)


def test_there_is_no_force_from_the_contact_on() -> None:
    pair, single = MagneticLevitation(push_pull=True), MagneticLevitation()
    assert math.isnan(force(single, 0.0, single.gap))
    assert math.isnan(force(pair, 0.0, -pair.gap))
    assert math.isfinite(force(single, 0.0, -single.gap))


@pytest.mark.derivation(
    MagneticLevitation,
    equation="F = C (i0 + i)^2 / (d - x)^2, C = mu0 N^2 A / 4",
    source="magnetic circuit of a horseshoe: F = 1/2 i^2 dL/dx, L = N^2 over the reluctance of two gaps, by mpmath",
    convention="N turns on both legs together, A of one pole, two gaps in one path; the gap d is that of one",
    wrong="the documents did not say that A is of one of two poles: of a pot magnet with one gap C is twice as much",
)
def test_the_force_is_the_slope_of_the_inductance() -> None:
    turns, area, gap, current = 240, 1.2e-4, 0.4e-3, 0.8

    def energy(x: mpmath.mpf) -> mpmath.mpf:
        reluctance = 2 * (gap - x) / (mu_0 * area)
        return 0.5 * current**2 * turns**2 / reluctance

    p = MagneticLevitation(force_constant=mu_0 * turns**2 * area / 4.0, gap=gap, bias=0.5)
    for x in (0.0, 0.15e-3, -0.3e-3):
        assert force(p, 0.3, x) == pytest.approx(float(mpmath.diff(energy, x)), rel=1e-9)
    flux_density = mu_0 * turns * current / (2.0 * gap)
    assert force(p, 0.3, 0.0) == pytest.approx(2.0 * area * flux_density**2 / (2.0 * mu_0), rel=1e-12)
