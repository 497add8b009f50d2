"""The capacitor pair against exact fractions, over the whole gap."""

import math
from fractions import Fraction

import pytest
from scipy import integrate

from proofmass.blocks import GapCapacitorPair
from proofmass.blocks.declaration.instance import unit_of
from tests.by_hand.functions import drive


def pair(block: GapCapacitorPair, displacements: list[float]) -> list[tuple[float, float]]:
    return [(row["first"], row["second"]) for row in drive(block, [{"displacement": x} for x in displacements])]


def test_both_capacitances_over_the_gap_against_fractions() -> None:
    angles = [n * 1.25e-5 for n in range(-99, 100)]
    for angle, (first, second) in zip(angles, pair(GapCapacitorPair(), angles), strict=True):
        x = Fraction(10e-3) * Fraction(angle) / Fraction(12.5e-6)
        assert first == pytest.approx(float(Fraction(42.5e-12) / (1 - x)), rel=1e-13)
        assert second == pytest.approx(float(Fraction(42.5e-12) / (1 + x)), rel=1e-13)
        assert first / (first + second) == pytest.approx(float((1 + x) / 2), rel=1e-13)


def test_slope_at_rest_is_k1() -> None:
    """k1 = 2 C0 l / d = 6.8e-8 F/rad with the default parameters [A]."""
    ((first, second),) = pair(GapCapacitorPair(), [1e-9])
    assert (first - second) / 1e-9 == pytest.approx(6.8e-8, rel=1e-6)


@pytest.mark.parametrize("angle", [1.25e-3, 2e-3, -1.25e-3, -26e-3])
def test_a_plate_that_touches_keeps_its_capacitance_a_number(angle: float) -> None:
    ((first, second),) = pair(GapCapacitorPair(), [angle])
    ratio = first / (first + second)
    assert ratio == pytest.approx(1.0 if angle > 0.0 else 0.0, abs=1e-12)
    assert min(first, second) == pytest.approx(42.5e-12 / 2.0, rel=1e-12)


def test_a_plate_that_moves_in_parallel_has_a_lever_of_one() -> None:
    block = GapCapacitorPair(capacitance="1.3 pF", gap="2 um", lever="1 m/m", input_unit="m")
    assert unit_of(block, type(block).inputs["displacement"]) == "m"
    ((first, _),) = pair(block, [1e-6])
    assert first == pytest.approx(2.6e-12, rel=1e-15)


@pytest.mark.derivation(
    GapCapacitorPair,
    equation="C1 = C0 / (1 - x), C2 = C0 / (1 + x), x = lever angle / gap",
    source="eps0 w dr / (d - r angle) integrated over a plate that turns about its flexure, by SciPy",
    convention="gap of one side, not of both; C0 of one side; lever to the plate's centre; angle in rad, to the first",
)
@pytest.mark.parametrize(("half", "angle", "near"), [(0.5e-3, 0.5e-3, 1e-3), (9.9e-3, 1e-6, 1e-5)])
def test_against_an_integral_over_a_tilted_plate(half: float, angle: float, near: float) -> None:
    """A small plate over half of the gap, and one that begins at the flexure for a small angle: 8.854 pF/m."""
    lever, gap, width = 10e-3, 12.5e-6, 6e-3

    def plate(side: float) -> float:
        field = integrate.quad(lambda r: 1.0 / (gap - side * r * angle), lever - half, lever + half)[0]
        return 8.8541878e-12 * width * float(field)

    at_rest = 8.8541878e-12 * width * 2.0 * half / gap
    ((first, second),) = pair(GapCapacitorPair(capacitance=at_rest, gap=gap, lever=lever), [angle])
    assert (first - second) / (plate(1.0) - plate(-1.0)) == pytest.approx(1.0, rel=near)
    assert (first - second) * (plate(1.0) - plate(-1.0)) > 0.0
    assert math.isclose(first, plate(1.0), rel_tol=near)
