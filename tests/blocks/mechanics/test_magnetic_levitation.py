"""The magnet against exact fractions, its gain and negative spring, and its end at the contact."""

import math
from fractions import Fraction

import pytest

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
