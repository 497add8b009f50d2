"""The chopped accelerometer of the gallery: offsets, and noise by Enz and Temes's sums over aliases."""

import math

import numpy as np
import pytest

from proofmass import noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("chopped_accelerometer.toml"))
PER_VOLT = 2.0 * 50.0 * 2e-6 / (2.0 * 50e-9)  # m/s^2 per volt of the bridge: 2 k d / (U m)


def test_means() -> None:
    still = {f"{way}.white": 0.0 for way in ("plain", "chopped", "sampled")} | {"gas.temperature": 0.0}
    still |= {f"{way}.flicker.level": 0.0 for way in ("plain", "chopped", "sampled")}
    result = simulate(GRAPH.with_parameters(still), engine="compiled")
    means = {name: measure.value for name, measure in result.measures.items()}
    assert means["plain"] == pytest.approx(9.80665 + 1e-3 * PER_VOLT, rel=1e-9)
    assert means["chopped"] == pytest.approx(9.80665, rel=1e-9)
    assert means["sampled"] == pytest.approx(9.80665, rel=1e-9)


def flicker(f: float) -> float:
    """Density of power of the amplifier's 1/f noise, V^2/Hz."""
    return 1e-12 / abs(f)


def chopped(f: float) -> float:
    """White noise keeps its density; 1/f noise comes from odd harmonics of 16 kHz, of a square wave of four samples."""
    lines = (1.0 / 2.0, 1.0 / 2.0)  # of power at 16 kHz and -16 kHz: samples 1, 1, -1, -1
    return sum(part * flicker(f + shift) for part, shift in zip(lines, (16e3, -16e3), strict=True))


def sampled(f: float) -> float:
    """Differences of samples 15.6 us apart, taken at 32 kHz: aliases at multiples of it."""
    step = 1.0 / 64e3
    return sum(
        4.0 * math.sin(math.pi * (f + 32e3 * n) * step) ** 2 * flicker(f + 32e3 * n) for n in (-1, 0) if f + 32e3 * n
    )


@pytest.mark.exhaustive
@pytest.mark.parametrize("way", ["plain", "chopped", "sampled"])
def test_noise_budget(way: str) -> None:
    f = 10.0
    budget = noise(GRAPH, f"{way}_output.output", input="acceleration.output", frequencies=[f])
    found = {source.block.rpartition(".")[2]: source.density[0] / abs(budget.gain[0]) ** 2 for source in budget.sources}
    white = (2.0 if way == "sampled" else 1.0) * 50e-9 * PER_VOLT
    assert math.sqrt(found["white"]) == pytest.approx(white, rel=1e-3)
    assert math.sqrt(found["gas"]) == pytest.approx(math.sqrt(4.0 * 1.380649e-23 * 300.0 * 5e-4) / 50e-9, rel=1e-3)
    expected = {"plain": flicker, "chopped": chopped, "sampled": sampled}[way](f)
    assert np.sqrt(found["flicker"]) == pytest.approx(math.sqrt(expected) * PER_VOLT, rel=0.03)
