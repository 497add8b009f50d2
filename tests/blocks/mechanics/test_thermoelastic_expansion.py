"""Growth and force against Hooke's law, and the frequency of a clamped beam that warms."""

import numpy as np
import pytest

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
