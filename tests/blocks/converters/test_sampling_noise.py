"""Noise of the capacitor, and of the jitter of a sampled sine, against their closed forms."""

import math

import numpy as np
import pytest

from proofmass.blocks import SamplingNoise, Sine
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate


def errors(block: SamplingNoise, sine: Sine, samples: int) -> np.ndarray:
    graph = Graph(
        name="sampled",
        rate="1 MHz",
        blocks={"sine": sine, "switch": block},
        wires=["sine.output -> switch.voltage"],
        probes=["sine.output", "switch.output"],
        seed=5,
    )
    result = simulate(graph, samples=samples)
    return result["switch.output"].values - result["sine.output"].values


def test_a_picofarad_has_64_microvolts() -> None:
    found = errors(SamplingNoise(), Sine(amplitude=0.0, unit="V"), 20_000)
    assert found.std() == pytest.approx(math.sqrt(1.380649e-23 * 300.0 / 1e-12), rel=0.02)
    assert found.std() == pytest.approx(64.36e-6, rel=0.02)


def test_jitter_of_a_sine() -> None:
    """2 pi f A jitter / sqrt(2) rms."""
    sine = Sine(amplitude=2.0, frequency=1234.0, unit="V")
    found = errors(SamplingNoise(temperature=0.0, jitter=1e-9), sine, 20_000)
    assert found.std() == pytest.approx(2.0 * math.pi * 1234.0 * 2.0 * 1e-9 / math.sqrt(2.0), rel=0.02)
