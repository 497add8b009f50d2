"""The comb against charges on two strips, found by the method of moments, and its force against its energy."""

import math

import numpy as np
import pytest

from proofmass.blocks.mechanics.differential_comb import DifferentialComb, constants, first, force, second

PERMITTIVITY = 8.8541878128e-12


def strips(height: float, gap: float, pieces: int = 240) -> float:
    """Capacitance per length of two parallel strips: potentials of uniform line charges on short pieces of each."""
    edges = -0.5 * height * np.cos(np.linspace(0.0, math.pi, pieces + 1))
    middle, half = 0.5 * (edges[1:] + edges[:-1]), 0.5 * np.diff(edges)

    def potential(away: float) -> np.ndarray:
        """Of pieces of charge 1 each at the middles of pieces of a strip that is so far away."""
        u = middle[:, None] - middle[None, :]
        x = u[..., None] + half[None, :, None] * np.polynomial.legendre.leggauss(6)[0]
        mean = np.log(np.hypot(x, away)) @ np.polynomial.legendre.leggauss(6)[1] / 2.0
        if away == 0.0:
            near = (u + half) * np.log(np.abs(u + half)) - (u - half) * np.log(np.abs(u - half))
            mean = near / (2.0 * half) - 1.0
        return -mean / (2.0 * math.pi * PERMITTIVITY)

    charges = np.linalg.solve(potential(0.0) - potential(gap), np.full(pieces, 0.5))
    return float(charges.sum())


@pytest.mark.parametrize(("height", "gap", "near"), [(25e-6, 3e-6, 0.01), (10e-6, 4e-6, 0.04)])
def test_the_fringe_against_charges_on_strips(height: float, gap: float, near: float) -> None:
    block = DifferentialComb(fingers=1, height=height, gap=gap, overlap=10e-6)
    slope = (first(constants(block, 1.0), 1e-6) - first(constants(block, 1.0), 0.0)) / 1e-6
    assert slope == pytest.approx(2.0 * strips(height, gap), rel=near)
    plain = constants(DifferentialComb(fingers=1, height=height, gap=gap, fringe=0.0), 1.0)
    assert plain.gradient == pytest.approx(2.0 * PERMITTIVITY * height / gap)


def test_the_force_is_the_slope_of_the_energy() -> None:
    c = constants(DifferentialComb(), 1.0)

    def energy(x: float) -> float:
        return 0.5 * (first(c, x) * 7.0**2 + second(c, x) * 4.0**2)

    for x in (-12e-6, 0.0, 5e-6, 25e-6):
        assert force(c, x, 7.0, 4.0) == pytest.approx((energy(x + 1e-9) - energy(x - 1e-9)) / 2e-9, rel=1e-6)


def test_a_comb_that_is_pulled_out_has_no_capacitance() -> None:
    c = constants(DifferentialComb(), 1.0)
    assert (first(c, -30e-6), second(c, 30e-6)) == (0.0, 0.0)
