"""Quotients on the unit circle against complex arithmetic: with delays, and with too many zeros for a product."""

import cmath

import flint
import numpy as np
import pytest

from proofmass.runner.analysis.linearisation.on_circle import OnCircle
from proofmass.runner.analysis.linearisation.rational import LARGEST_CERTIFIED, Transfer
from proofmass.runner.analysis.linearisation.real_roots import zeros

LONG = LARGEST_CERTIFIED + 6
ABOVE = {
    "a zero": [-1, 2],
    "a zero, ahead": [0, 0, 0, 0, -1, 2],
    "a negative gain": [1, -2],
    "an average": [1] * (LONG + 1),
}
BELOW = [0, 0, 0, 3, -7, 4]  # z^3 (4 z - 3) (z - 1)
ANGLES = np.array([1e-9, 0.02, 0.7, 1.9, 3.1])


def at(coefficients: list[int], z: complex) -> tuple[complex, complex]:
    """Value and derivative."""
    value = sum(c * z**k for k, c in enumerate(coefficients))
    return value, sum(k * c * z ** (k - 1) for k, c in enumerate(coefficients) if k)


@pytest.mark.parametrize("name", ABOVE)
def test_values_and_slopes(name: str) -> None:
    """L, the direction of D / z^3, and (log L)' = j z (N' / N - D' / D), next to the pole at 1 less closely."""
    above = ABOVE[name]
    on_circle = OnCircle(Transfer(flint.fmpz_poly(above), flint.fmpz_poly(BELOW)))
    values, turns = on_circle.values_and_turns(ANGLES)
    assert np.array_equal(values, on_circle.values(ANGLES))
    for w, value, turn in zip(ANGLES.tolist(), values, turns, strict=True):
        z, near = cmath.exp(1j * w), 1e-6 if w < 1e-3 else 1e-12
        (n, n_slope), (d, d_slope) = at(above, z), at(BELOW, z)
        assert value == pytest.approx(n / d, rel=near)
        assert turn == pytest.approx(d / z**3 / abs(d), rel=near)
        assert on_circle.turning(w) == pytest.approx(1j * z * (n_slope / n - d_slope / d), rel=near)


def test_at_a_pole_and_at_a_zero() -> None:
    """Next to the pole at 1 all digits are right: (2 z - 1) / (z^3 (4 z - 3) (z - 1)) is 1 / (j w) there."""
    on_circle = OnCircle(Transfer(flint.fmpz_poly(ABOVE["a zero"]), flint.fmpz_poly(BELOW)))
    w = 1e-13
    assert on_circle.values(np.array([w]))[0] == pytest.approx(1.0 / (1j * w), rel=1e-12)
    silent = OnCircle(Transfer(flint.fmpz_poly([0]), flint.fmpz_poly(BELOW)))
    assert silent.values(ANGLES).tolist() == [0.0] * len(ANGLES)


def test_how_often_zero_is_a_root() -> None:
    assert [zeros(flint.fmpz_poly(c)) for c in ([5], [0, 2], [0, 0, 0, 1, 1], [])] == [0, 1, 3, 0]
