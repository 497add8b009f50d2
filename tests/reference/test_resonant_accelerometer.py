"""The resonant accelerometer of the gallery: f0 sqrt(1 + N / Nc) of both beams, and the noise of the gas."""

import math

import numpy as np
import pytest

from proofmass import noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("resonant_accelerometer.toml"))
F0, PROOF_MASS, G0 = 40_000.0, 1e-4, 9.80665


@pytest.mark.exhaustive("-2.0")
@pytest.mark.parametrize("acceleration", [-2.0, 1.0])
def test_frequencies_of_the_beams(acceleration: float) -> None:
    quiet = {
        f"{beam}.{name}": 0.0 for beam in ("pulled", "pushed") for name in ("gas.temperature", "amplifier.density")
    }
    result = simulate(GRAPH.with_parameters(quiet | {"acceleration.amplitude": acceleration * G0}), engine="compiled")
    force, warm = PROOF_MASS * acceleration * G0, F0 * (1.0 - 30e-6 * 2.0)
    pulled, pushed = (warm * math.sqrt(1.0 + sign * force) for sign in (1.0, -1.0))
    measured = {name: measure.value for name, measure in result.measures.items()}
    assert measured["difference"] == pytest.approx(pulled - pushed, rel=3e-4)
    assert measured["warming"] == pytest.approx(pulled + pushed - 2.0 * F0, abs=5e-3)
    assert measured["acceleration"] == pytest.approx(0.25 * measured["difference"], rel=1e-12)


@pytest.mark.exhaustive
@pytest.mark.defect("S22", before="refused: the phase of an oscillation counted as slow", after="it counts as neutral")
def test_noise_of_the_gas() -> None:
    """The phase turns by force / (2 m X) a second, twice the density for one component, and two beams."""
    still = GRAPH.with_parameters({"temperature.amplitude": 0.0, "acceleration.amplitude": 0.0})
    budget = noise(still, "reading.output", input="acceleration.output", at="0.065 s", frequencies=[0.05])
    gas = sum(source.density[0] for source in budget.sources if source.block.endswith("gas"))
    w = 2.0 * math.pi * F0
    force = math.sqrt(8.0 * 1.380649e-23 * 300.0 * 1e-9 * w / 10_000.0)
    per_beam = force / (2.0 * 1e-9 * w * 1e-6) / (2.0 * math.pi)  # Hz/sqrt(Hz)
    expected = math.sqrt(2.0) * per_beam * np.sinc(1.0 / 8.0) / (F0 * PROOF_MASS)
    assert math.sqrt(gas) / abs(budget.gain[0]) == pytest.approx(expected, rel=1e-3)
