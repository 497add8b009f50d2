"""The fluxgate against NumPy's hyperbolic tangent: its voltage, its harmonics, and a field that saturates it."""

import numpy as np
import pytest

from proofmass.blocks import Fluxgate
from tests.by_hand.responses import responses

N, RATE = 64, 640_000.0
H = 100.0 * np.sin(2.0 * np.pi * np.arange(3 * N) / N)


def voltages(field: float, part: float = 1.0) -> np.ndarray:
    inputs = {"excitation": (part * H).tolist(), "field": [field] * len(H)}
    return np.array(responses(Fluxgate(), "voltage", period=1.0 / RATE, **inputs))


def test_voltage_of_two_cores() -> None:
    inside = 50e-6 / (1.25663706212e-6 + 2e-3 * 0.6 / 20.0)  # A/m, less what the shape of the core takes off
    flux = 0.6 * (np.tanh((H + inside) / 20.0) - np.tanh((H - inside) / 20.0))
    expected = 500.0 * 1e-6 * np.diff(flux, prepend=0.0) * RATE
    assert voltages(50e-6) == pytest.approx(expected, abs=1e-13 * np.abs(expected).max())


def test_a_field_makes_even_harmonics() -> None:
    lines = np.abs(np.fft.rfft(voltages(20e-6, 0.3)[N : 2 * N]))
    assert lines[1::2].max() < 1e-9 * lines[2]
    assert lines[4] < 0.6 * lines[2]
    assert np.abs(voltages(0.0)).max() == 0.0


def test_the_sign_is_that_of_the_field() -> None:
    assert voltages(-20e-6) == pytest.approx(-voltages(20e-6), abs=1e-15)
