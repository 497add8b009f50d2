"""The force against the two sides of the pair by themselves, and its slope in the middle."""

import math

import mpmath
import pytest
from scipy.constants import epsilon_0

from proofmass.blocks import ElectrostaticSoftening
from tests.by_hand.responses import responses

C0, GAP = 0.2e-12, 3e-6


@pytest.mark.parametrize("x", [0.0, 1e-7, -1e-6, 2.5e-6])
def test_against_the_difference_of_two_plates(x: float) -> None:
    """F = C0 V^2 / (2 d (1 - x / d)^2) towards either side."""
    towards, away = (C0 * 9.0 / (2.0 * GAP * (1.0 - side * x / GAP) ** 2) for side in (1.0, -1.0))
    block = ElectrostaticSoftening(capacitance=C0, gap=GAP)
    assert responses(block, "force", voltage=[3.0], displacement=[x])[0] == pytest.approx(towards - away, abs=1e-18)


def test_its_stiffness_in_the_middle() -> None:
    block = ElectrostaticSoftening(capacitance=C0, gap=GAP)
    force = responses(block, "force", voltage=[5.0], displacement=[1e-12])[0]
    assert force / 1e-12 == pytest.approx(2.0 * C0 * 25.0 / GAP**2, rel=1e-9)


def test_there_is_no_force_from_the_contact_on() -> None:
    block = ElectrostaticSoftening(gap=GAP)
    assert all(map(math.isnan, responses(block, "force", voltage=[1.0] * 2, displacement=[GAP, -1.1 * GAP])))


@pytest.mark.derivation(
    ElectrostaticSoftening,
    equation="F = 2 C0 V^2 x / (d^2 (1 - (x / d)^2)^2)",
    source="virtual work: slope of the energy of two plates of 100 um by 80 um at one voltage, by mpmath",
    convention="C0 and d are of one side; the stiffness that it takes off is 2 C0 V^2 / d^2",
)
def test_the_force_is_the_slope_of_the_energy() -> None:
    area, gap, volts = 100e-6 * 80e-6, 2.5e-6, 7.0

    def energy(x: mpmath.mpf) -> mpmath.mpf:
        return 0.5 * volts**2 * epsilon_0 * area * (1 / (gap - x) + 1 / (gap + x))

    places = [1e-9, -0.8e-6, 1.9e-6]
    expected = [float(mpmath.diff(energy, x)) for x in places]
    block = ElectrostaticSoftening(capacitance=epsilon_0 * area / gap, gap=gap)
    assert responses(block, "force", voltage=[volts] * 3, displacement=places) == pytest.approx(expected, rel=1e-9)
