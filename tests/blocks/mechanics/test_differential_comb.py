"""The comb against charges on a row of fingers, found by the method of moments, and its force against its energy."""

import math

import numpy as np
import pytest

from proofmass.blocks import DifferentialComb
from proofmass.blocks.mechanics.differential_comb import constants, first, force, second

PERMITTIVITY = 8.8541878128e-12


def row(height: float, gap: float, thickness: float, pieces: int = 60) -> float:
    """Capacitance per length of a finger in a row without end, every other finger at 1 V, from charges on its surface.

    A line of charge repeated with the period P has the potential -ln(2 (cosh ky - cos kx)) / (4 pi eps0), k = 2 pi / P.
    """

    def side(length: float, count: int) -> np.ndarray:
        return -0.5 * length * np.cos(np.linspace(0.0, math.pi, count + 1))  # finer towards the corners

    tall, flat, ends = side(height, pieces), side(thickness, pieces // 3), []
    for middle in (0.0, gap + thickness):
        for x in (middle - 0.5 * thickness, middle + 0.5 * thickness):
            ends.append((x + 1j * tall[:-1], x + 1j * tall[1:]))
        for y in (-0.5 * height, 0.5 * height):
            ends.append((middle + flat[:-1] + 1j * y, middle + flat[1:] + 1j * y))
    begin, end = (np.concatenate(z) for z in zip(*ends, strict=True))
    length, k = np.abs(end - begin), math.pi / (gap + thickness)
    places, weights = np.polynomial.legendre.leggauss(4)
    points = 0.5 * (begin + end)[:, None] + 0.5 * (end - begin)[:, None] * places
    apart = 0.5 * (begin + end)[:, None, None] - points[None]
    fall, turn = np.exp(-k * np.abs(apart.imag)), np.exp(1j * k * apart.real)
    logarithms = k * np.abs(apart.imag) + 2.0 * np.log(np.abs(1.0 - fall * turn))
    means = 0.5 * logarithms @ weights
    own = np.arange(len(length))  # of a piece at itself the logarithm is integrated by hand
    smooth = logarithms[own, own] - 2.0 * np.log(k * np.abs(apart[own, own]))
    means[own, own] = 0.5 * smooth @ weights + 2.0 * (np.log(0.5 * k * length) - 1.0)
    bordered = np.ones((len(own) + 1,) * 2)  # no charge in all, and a potential of any size far away
    bordered[:-1, :-1], bordered[-1, :-1], bordered[-1, -1] = means / (-4.0 * math.pi * PERMITTIVITY), 1.0, 0.0
    half = len(own) // 2
    volts = np.concatenate([np.full(half, 0.5), np.full(half, -0.5), [0.0]])
    return float(np.linalg.solve(bordered, volts)[:half].sum())


@pytest.mark.defect(
    "S677",
    before="fringe of two plates by themselves: C' and force 5.6 % too large, 9 % of fingers a third of the gap",
    after="that of a row of fingers of their thickness, to 1e-4",
)
@pytest.mark.derivation(
    DifferentialComb,
    equation="C' = 2 N eps0 (h + e) / g, e = ((g + t) ln(1 + 2 g / t) + g ln(t (2 g + t) / g^2)) / pi",
    source="charges on the surfaces of a periodic row of fingers of finite thickness, by the method of moments",
    convention="N fingers of one comb with two gaps each; e is of both edges; 100 of 25 um by 3 um: 16.6 nF/m",
    wrong="S677: Palmer's fringe of two plates stood for that of a comb; finger thickness did not count",
)
@pytest.mark.parametrize(
    ("height", "gap", "thickness"), [(25e-6, 3e-6, 3e-6), (25e-6, 3e-6, 1e-6), (10e-6, 4e-6, 2e-6), (6e-6, 3e-6, 6e-6)]
)
def test_the_fringe_against_charges_on_a_row_of_fingers(height: float, gap: float, thickness: float) -> None:
    block = DifferentialComb(fingers=7, height=height, gap=gap, thickness=thickness, overlap=10e-6)
    slope = (first(constants(block, 1.0), 1e-6) - first(constants(block, 1.0), 0.0)) / 1e-6
    assert slope == pytest.approx(7.0 * row(height, gap, thickness), rel=1e-4)
    pull = force(constants(block, 1.0), 0.0, 3.0, 1.0)
    assert pull == pytest.approx(0.5 * 7.0 * row(height, gap, thickness) * 8.0, rel=1e-4)


def test_without_fringe_it_is_a_plate() -> None:
    plain = constants(DifferentialComb(fingers=1, height=25e-6, gap=3e-6, fringe=0.0), 1.0)
    assert plain.gradient == pytest.approx(2.0 * PERMITTIVITY * 25.0 / 3.0)


def test_the_force_is_the_slope_of_the_energy() -> None:
    c = constants(DifferentialComb(), 1.0)

    def energy(x: float) -> float:
        return 0.5 * (first(c, x) * 7.0**2 + second(c, x) * 4.0**2)

    for x in (-12e-6, 0.0, 5e-6, 25e-6):
        assert force(c, x, 7.0, 4.0) == pytest.approx((energy(x + 1e-9) - energy(x - 1e-9)) / 2e-9, rel=1e-6)


def test_a_comb_that_is_pulled_out_has_no_capacitance() -> None:
    c = constants(DifferentialComb(), 1.0)
    assert (first(c, -30e-6), second(c, 30e-6)) == (0.0, 0.0)
