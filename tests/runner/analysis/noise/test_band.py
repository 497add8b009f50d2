"""Integrals over a band against closed forms."""

import math

import numpy as np
import pytest

from proofmass.blocks.declaration.problem import ModelError
from proofmass.runner.analysis.noise.band import rule


def test_points_and_weights_integrate_a_resonance_and_a_straight_line() -> None:
    """w / (w^2 + (f - 3)^2) has the integral atan((f - 3) / w), and f has f^2 / 2."""
    width = 0.01

    def density(f: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        return np.column_stack([width / (width**2 + (f - 3.0) ** 2), f])

    points, weights, both = rule(density, np.array([1.0, 2.9, 3.0, 3.2, 7.0]))
    resonance = math.atan(4.0 / width) + math.atan(2.0 / width)
    assert both == pytest.approx([resonance, 24.0], rel=1e-9)
    assert weights @ density(points) == pytest.approx([resonance, 24.0], rel=1e-9)
    assert (points > 1.0).all()
    assert (points < 7.0).all()


def test_a_pole_has_no_integral() -> None:
    with pytest.raises(ModelError, match="Hz"), np.errstate(all="ignore"):
        rule(lambda f: 1.0 / np.abs(f[:, None] - math.sqrt(2.0)), np.array([1.0, 2.0]))
