"""The filter: its difference equation, and a phase-locked loop that settles as linear theory says."""

import math

import numpy as np
import pytest
from scipy import signal

from proofmass.blocks import LoopFilter, NumericallyControlledOscillator, PhaseMixer
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import distance, noise, response


def test_against_lfilter() -> None:
    block = LoopFilter(natural_frequency=20.0, damping=0.9, detector_gain=0.5, oscillator_gain=100.0)
    wn, gain, u = 2.0 * math.pi * 20.0, 2.0 * math.pi * 0.5 * 100.0, noise(300)
    kp, ki = 2.0 * 0.9 * wn / gain, wn * wn / gain * 1e-3
    expected = signal.lfilter([kp + ki, -kp], [1.0, -1.0], u)
    assert distance(response(block, u, "control", "error", period=1e-3), expected) < 1e-12


@pytest.mark.parametrize("damping", [0.5, 1.0])
def test_a_locked_loop_takes_a_phase_step_as_linear_theory_says(damping: float) -> None:
    """The oscillator's control, less its ripple, after a step of 0.1 rad."""
    rate, carrier, natural = 200_000, 20_000.0, 50.0
    blocks = {
        "source": NumericallyControlledOscillator(frequency=carrier, initial_phase=0.1),
        "oscillator": NumericallyControlledOscillator(frequency=carrier),
        "detector": PhaseMixer(),
        "filter": LoopFilter(natural_frequency=natural, damping=damping),
    }
    wires = ["source.sine -> detector.first", "oscillator.cosine -> detector.second"]
    wires += ["detector.phase -> filter.error", "filter.control -> oscillator.control"]
    probes = ["oscillator.phase", "source.phase"]
    graph = Graph(name="loop", rate=rate, blocks=blocks, wires=wires, probes=probes)
    result = simulate(graph, samples=8000)
    error = result["source.phase"].values - result["oscillator.phase"].values
    error -= 2.0 * np.pi * np.round(error / (2.0 * np.pi))
    wn = 2.0 * np.pi * natural
    t, expected = signal.step(([1.0, 0.0, 0.0], [1.0, 2.0 * damping * wn, wn * wn]), T=np.arange(8000) / rate)
    assert np.abs(error - 0.1 * expected)[t > 0.0].max() < 0.1 * 0.06
