"""The analog oscillator: its phase is the integral of its frequency, between ticks too."""

import math

import numpy as np
import pytest

from proofmass.blocks import LowPass, Step, VoltageControlledOscillator
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate


@pytest.mark.derivation(
    VoltageControlledOscillator,
    equation="turns' = frequency + gain control, sine = amplitude sin(2 pi turns)",
    source="integral of 500 Hz + 600 Hz (1 - exp(-t / tau)) by hand",
    convention="frequency and gain in Hz, not rad/s; amplitude is the peak; the phase in rad with whole turns",
)
def test_its_frequency_follows_a_voltage_that_rises_exponentially() -> None:
    graph = Graph(
        name="pulled",
        rate="10 kHz",
        blocks={
            "step": Step(amplitude=2.0, unit="V"),
            "filter": LowPass(corner_frequency=100.0, input_unit="V", output_unit="V"),
            "vco": VoltageControlledOscillator(frequency=500.0, gain=300.0, amplitude=1.5, initial_phase=0.4),
        },
        wires=["step.output -> filter.input", "filter.output -> vco.control"],
        probes=["vco.sine", "vco.cosine", "vco.phase"],
    )
    result = simulate(graph, samples=500, engine="python")
    t, w = np.arange(500) * 1e-4, 200.0 * math.pi
    phase = 0.4 + 2.0 * math.pi * (500.0 * t + 600.0 * (t - (1.0 - np.exp(-w * t)) / w))
    assert result["vco.phase"].values == pytest.approx(phase, rel=1e-7)
    assert result["vco.sine"].values == pytest.approx(1.5 * np.sin(phase), abs=1e-5)
    assert result["vco.cosine"].values == pytest.approx(1.5 * np.cos(phase), abs=1e-5)


def test_it_breaks_a_loop() -> None:
    assert VoltageControlledOscillator.feedthrough("sine") == ()
