"""The fluxgate against NumPy's hyperbolic tangent: its voltage, its harmonics, and a field that saturates it."""

import numpy as np
import pytest
from scipy import integrate

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


@pytest.mark.derivation(
    Fluxgate,
    equation="voltage = turns area d(flux)/dt, flux = Bs (tanh((H + h) / Hs) - tanh((H - h) / Hs))",
    source="permeability of the cores at each instant, times a small field: its second Fourier line by SciPy",
    convention="peak of the line; area of one core, flux of both; H and Hs are peaks in A/m, the field in T",
    wrong="the documents did not say that the area is that of one of the two cores, nor what is before tick 0",
)
def test_the_second_harmonic_by_the_permeability() -> None:
    """Without a shape factor h is field / mu0; 2 h dB/dH is the flux, and dB/dH = Bs / Hs cosh(H / Hs)^-2."""
    saturation, knee, turns, area, field, n = 0.7, 25.0, 300.0, 2e-6, 1e-9, 1024
    block = Fluxgate(saturation=saturation, knee=knee, demagnetisation=0.0, turns=turns, area=area)
    excitation = 60.0 * np.sin(2.0 * np.pi * np.arange(2 * n) / n)
    signals = {"excitation": excitation.tolist(), "field": [field] * (2 * n)}
    found = np.array(responses(block, "voltage", period=1.0 / (1000.0 * n), **signals))[n:]
    line = 2.0 / n * abs(np.fft.rfft(found)[2])

    def part(t: float) -> float:
        return saturation / knee / np.cosh(60.0 * np.sin(t) / knee) ** 2 * np.cos(2.0 * t)

    flux = 2.0 * field / (4e-7 * np.pi) * integrate.quad(part, 0.0, 2.0 * np.pi)[0] / np.pi
    assert line == pytest.approx(turns * area * 2.0 * 2.0 * np.pi * 1000.0 * abs(flux), rel=1e-4)


@pytest.mark.derivation(
    Fluxgate,
    equation="h = field / (mu0 (1 + demagnetisation Bs / (mu0 Hs)))",
    source="textbook: a sphere of high permeability gathers three times the flux density around it",
    convention="SI factor of the shape, 1/3 of a sphere, not 4 pi / 3",
)
def test_a_sphere_gathers_three_times_the_field() -> None:
    sphere = Fluxgate(saturation=0.7, knee=1e-3, demagnetisation=1.0 / 3.0, turns=1.0, area=1.0)
    voltages = responses(sphere, "voltage", period=1.0, excitation=[0.0, 0.0], field=[0.0, 1e-6])
    assert voltages[1] == pytest.approx(2.0 * 3.0 * 1e-6, rel=1e-4)
