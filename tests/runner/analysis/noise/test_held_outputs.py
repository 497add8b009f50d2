"""An output that holds its values, against the response of all of them, one by one."""

import numpy as np
import pytest

from proofmass.runner.analysis.noise.noise_map import NoiseMap
from proofmass.runner.derivatives.dual_noise import DEVIATE


@pytest.mark.parametrize("held", [1, 3, 12])
def test_each_value_counts(held: int) -> None:
    """h(f) = sum over i of exp(-2 pi j f i T / r) (C (z - A)^-1 B + D)[i], of 12 values of which some are alike."""
    draw, period = np.random.default_rng(held), 2e-3
    a, b = 0.2 * draw.normal(size=(3, 3)), draw.normal(size=(3, 5))
    c, d = (np.repeat(draw.normal(size=(12 // held, columns)), held, axis=0) for columns in (3, 5))
    inputs = tuple(("white", DEVIATE, number) for number in range(5))
    frequencies = np.array([0.0, 17.0, 333.3, 1000.0, 2999.0])
    real, imaginary = np.split(NoiseMap((a, b, c, d), period, inputs, {}).heard(frequencies), 2)
    for row, f in zip(real + 1j * imaginary, frequencies, strict=True):
        whole = c @ np.linalg.solve(np.exp(2j * np.pi * f * period) * np.eye(3) - a, b) + d
        turns = np.exp(-2j * np.pi * f * np.arange(12) * period / 12)
        assert row == pytest.approx(turns @ whole, rel=1e-9, abs=1e-12)
