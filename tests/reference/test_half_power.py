"""Damping by half power: the estimate against closed forms of the response, and the graph behind it."""

import math

import numpy as np
import pytest

from docs.papers import half_power
from docs.papers.pn_runs import GYROSCOPE

MASS = GYROSCOPE.mass


def response(frequencies: np.ndarray, stiffness: float, damping: float) -> np.ndarray:
    w = 2.0 * math.pi * frequencies
    return 1.0 / np.abs(stiffness - MASS * w**2 + 1j * w * damping)


@pytest.mark.parametrize("quality", [5.0, 36.0, 400.0])
def test_width_of_an_exact_response(quality: float) -> None:
    """w^2 = w0^2 (1 - 2 z^2) +- 2 z w0^2 sqrt(1 - z^2) at half the power, the peak between; z = 1 / 2Q."""
    stiffness, zeta = 137.7, 0.5 / quality
    w0 = math.sqrt(stiffness / MASS)
    middle = w0 / (2.0 * math.pi)
    frequencies = middle * np.linspace(1.0 - 2.0 / quality, 1.0 + 2.0 / quality, 4001)
    found = half_power.half_power(frequencies, response(frequencies, stiffness, stiffness / w0 / quality), MASS)
    edges = [w0 * math.sqrt(1 - 2 * zeta**2 + sign * 2 * zeta * math.sqrt(1 - zeta**2)) for sign in (1, -1)]
    assert found.damping == pytest.approx(MASS * (edges[0] - edges[1]), rel=1e-5)
    assert found.stiffness == pytest.approx(stiffness * (1 - 2 * zeta**2), rel=1e-6)


def test_overdamped_and_cut_responses_are_refused() -> None:
    frequencies = np.linspace(100.0, 9000.0, 100)
    with pytest.raises(ValueError, match="no peak"):
        half_power.half_power(frequencies, response(frequencies, 51.48, 4.57e-3), MASS)
    near = np.linspace(8430.0, 8500.0, 15)
    with pytest.raises(ValueError, match="half the power"):
        half_power.half_power(near, response(near, 137.7, 7.12e-5), MASS)


def test_the_graph_has_the_closed_form() -> None:
    """Three frequencies without noise: force 2 C' Vdc v on the mode, held over 10 us."""
    frequencies = np.array([8346.0, 8466.0, 8586.0])
    found = half_power.amplitudes(frequencies, 1, half_power.QUIET)[0]
    force = 2.0 * 14.757e-9 * 15.0 * 0.2 * np.sinc(frequencies / 1e5)
    assert found == pytest.approx(GYROSCOPE.readout * force * response(frequencies, 137.7, 7.12e-5), rel=5e-4)


@pytest.mark.exhaustive
def test_both_methods_scatter_alike_in_the_same_time() -> None:
    """0.70 s of sweeps beside six periods of the loop."""
    _, swept = half_power.errors(half_power.SWEEP, 20)
    _, loop = half_power.sequences(200, {})
    assert swept.damping == pytest.approx(loop.damping / math.sqrt(6.0), rel=0.4)
    _, louder = half_power.errors(half_power.SWEEP, 20, {"amplifier.density": 0.7559289e-3})
    assert louder.damping == pytest.approx(10.0 * swept.damping, rel=0.3)
