"""The bound of the largest eigenvalue, against matrices whose eigenvalues are known."""

import math

import pytest

from proofmass.runner.planning.solvers import spectral_radius

COSINE, SINE = math.cos(0.3), math.sin(0.3)


@pytest.mark.parametrize(
    ("matrix", "radius"),
    [
        ([[-0.5]], 0.5),
        ([[1e6 * COSINE, -1e6 * SINE], [1e6 * SINE, 1e6 * COSINE]], 1e6),
        ([[0.9, 1.0], [0.0, 0.9]], 0.9),
        ([[0.0, 1e8], [1e-8, 0.0]], 1.0),
        ([[2.0, 1.0, 0.0], [0.0, -3.0, 5.0], [0.0, 0.0, 0.1]], 3.0),
    ],
)
def test_it_is_at_most_a_few_per_cent_too_large(matrix: list[list[float]], radius: float) -> None:
    assert radius * (1.0 - 1e-12) <= spectral_radius(matrix) <= 1.03 * radius


def test_without_a_bound() -> None:
    """What is nilpotent has no eigenvalue but 0, and what is not finite no bound."""
    assert spectral_radius([]) == 0.0
    assert spectral_radius([[0.0, 1.0], [0.0, 0.0]]) == 0.0
    assert spectral_radius([[math.inf]]) == math.inf
