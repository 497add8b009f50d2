"""Growth and force against Hooke's law, and the frequency of a clamped beam that warms."""

import numpy as np
import pytest
from scipy import integrate

from proofmass.blocks import ResonantBeam, ThermoelasticExpansion
from proofmass.blocks.mechanics import resonant_beam
from proofmass.blocks.mechanics.thermoelastic_expansion import elongation, force


def test_growth_and_force_against_polynomials() -> None:
    p = ThermoelasticExpansion(length=2e-3, expansion=2.6e-6, quadratic=4e-9, frame_expansion=1e-6, stiffness=20.0)
    for warmer in (-60.0, 0.0, 35.0):
        strain = np.polyval([4e-9, 1.6e-6, 0.0], warmer)
        assert elongation(p, 298.15 + warmer) == pytest.approx(2e-3 * strain, rel=1e-10)
        assert force(p, 298.15 + warmer) == pytest.approx(-20.0 * strain, rel=1e-10)


def test_a_warm_beam_in_a_cold_frame_is_slower() -> None:
    """f = f0 sqrt(1 - E A alpha dT / Nc)."""
    push = force(ThermoelasticExpansion(), 398.15)
    square = resonant_beam.constants(ResonantBeam(axial_force=push), 1.0).square
    assert np.sqrt(square) / (2.0 * np.pi) == pytest.approx(40_000.0 * np.sqrt(1.0 - 16.9 * 2.6e-4), rel=1e-12)


@pytest.mark.derivation(
    ThermoelasticExpansion,
    equation="elongation = length s, s = (expansion - frame_expansion) D + quadratic D^2, force = -E A s",
    source="textbook: a rail of steel between two walls has 72 MPa of pressure 30 K warmer; integral of a(T) over T",
    convention="tension is positive; quadratic is half the slope of the coefficient; coefficients are those at T0",
    wrong="the equation of the documents took the quadratic term from both sides, so that it fell out",
)
def test_a_rail_between_two_walls_and_a_coefficient_that_grows() -> None:
    """12 ppm/K and 200 GPa (Gere and Goodno, Mechanics of Materials, section 2.5); 5 ppm/K that grow by 8e-9 per K."""
    rail = ThermoelasticExpansion(expansion=12e-6, stiffness=200e9 * 6e-3)
    assert force(rail, 298.15 + 30.0) / 6e-3 == pytest.approx(-72e6, rel=1e-9)
    slope = 8e-9
    part = ThermoelasticExpansion(
        length=0.3, expansion=5e-6, frame_expansion=1e-6, quadratic=slope / 2.0, reference_temperature=300.0
    )
    grown, _ = integrate.quad(lambda t: 5e-6 + slope * (t - 300.0) - 1e-6, 300.0, 280.0)
    assert elongation(part, 280.0) == pytest.approx(0.3 * grown, rel=1e-9)
