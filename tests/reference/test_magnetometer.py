"""The fluxgate of the gallery: slope by NumPy's harmonics, scale factor of the coil, crossover and noise."""

import math

import numpy as np
import pytest

from proofmass import margins, noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("closed_loop_fluxgate.toml"))
N = 64


def slope() -> float:
    """Second harmonic in phase per tesla."""
    n = np.arange(2 * N)
    h = 60.0 * np.sin(2.0 * np.pi * n / N) / 20.0
    small = 1e-9 / (1.25663706212e-6 * 20.0 + 2e-3 * 0.6)
    flux = 0.6 * 1e-6 * 500.0 * (np.tanh(h + small) - np.tanh(h - small))
    volts = np.diff(flux, prepend=0.0) * 640e3
    return float(2.0 * np.mean(volts[N:] * np.sin(4.0 * np.pi * n[N:] / N)) / 1e-9)


def test_the_scale_factor_is_that_of_the_coil() -> None:
    quiet = GRAPH.with_parameters({"noise.density": 0.0, "fluxgate.saturation": 0.7, "excitation.amplitude": 70.0})
    result = simulate(quiet, duration="30 ms", engine="compiled")
    assert result["reading.output"].values[-1] == pytest.approx(50e-6, rel=1e-9)


@pytest.mark.exhaustive
def test_loop_and_noise() -> None:
    turns = abs(slope()) * 5e-3 * 29.0 * 1e-4  # loop gain a period of 100 us
    found = margins(GRAPH, "field", at="9 ms")
    crossover = math.asin(0.5 * turns) / (math.pi * 1e-4)  # |turns / (z - 1)| = 1
    assert found.gain_crossovers[0] == pytest.approx(crossover, rel=5e-3)
    budget = noise(GRAPH, "reading.output", input="earth.output", at="9 ms", frequencies=[1.0])
    referred = math.sqrt(budget.referred_density[0])
    assert referred == pytest.approx(math.sqrt(2.0) * 1e-6 / abs(slope()), rel=5e-3)
