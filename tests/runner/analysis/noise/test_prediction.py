"""Allan deviations of densities with a closed form: white noise, flicker, and a random walk."""

import numpy as np
import pytest

from proofmass.runner.analysis.noise.prediction import allan_deviation

PERIOD, TAUS = 1e-3, np.array([1.0, 8.0, 300.0])


@pytest.mark.parametrize(("first", "last"), [(1e-6, 500.0), (5.0, 500.0)])
@pytest.mark.parametrize(
    ("power", "square"),
    [
        (0, 1.0 / (2.0 * TAUS)),
        (1, np.full(3, 2.0 * np.log(2.0))),  # the integral of 2 sin^4 u / u^3
        (2, 2.0 * np.pi**2 * TAUS / 3.0),  # the integral of sin^4 u / u^4 is pi / 3
    ],
)
def test_powers_of_the_frequency(power: int, square: np.ndarray, first: float, last: float) -> None:
    """1 / f^n, also where it is known from 5 Hz on alone: below that it goes on as it begins."""
    f = np.geomspace(first, last, 200)
    assert allan_deviation(f, f ** -float(power), PERIOD, TAUS) == pytest.approx(np.sqrt(square), rel=3e-3)


def test_white_noise_of_few_values_in_a_row() -> None:
    """Means of m values, each with the variance S / (2 T)."""
    f = np.geomspace(1.0, 500.0, 50)
    taus = PERIOD * np.array([1, 2, 5])
    assert allan_deviation(f, np.full(50, 4.0), PERIOD, taus) == pytest.approx(np.sqrt(2.0 / taus), rel=3e-3)
