"""The filter: its difference equation, and a phase-locked loop that settles as linear theory says."""

import math

import numpy as np
import pytest
from scipy import integrate, signal

from proofmass.blocks import LoopFilter, NumericallyControlledOscillator, PhaseMixer
from proofmass.graphs.model.build import Graph
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


@pytest.mark.derivation(
    LoopFilter,
    equation="Kp = 2 damping wn / K, Ki = wn^2 / K, K = 2 pi detector_gain oscillator_gain",
    source="poles of the closed loop by NumPy's roots, and its noise bandwidth by an integral of |H|^2 over f",
    convention="detector gain per rad, oscillator gain in Hz: the factor 2 pi; the bandwidth is one-sided, in Hz",
)
def test_poles_and_noise_bandwidth_of_the_closed_loop() -> None:
    """From the control alone: its first value and its slope under a constant error of 1."""
    detector, oscillator, natural, damping, period = 0.3, 250.0, 40.0, 0.6, 1e-6
    block = LoopFilter(natural_frequency=natural, damping=damping, detector_gain=detector, oscillator_gain=oscillator)
    first, second = response(block, [1.0, 1.0], "control", "error", period=period)
    integral = (second - first) / period
    proportional = first - integral * period
    loop = detector * 2.0 * math.pi * oscillator  # rad/s of the oscillator per rad of error, per part of the filter
    poles = np.roots([1.0, loop * proportional, loop * integral])
    assert np.abs(poles) == pytest.approx(2.0 * math.pi * natural, rel=1e-6)
    assert -poles.real / np.abs(poles) == pytest.approx(damping, rel=1e-6)

    def passed(f: float) -> float:
        s = 2j * math.pi * f
        return float(abs(loop * (proportional * s + integral) / (s * s + loop * (proportional * s + integral))) ** 2)

    wn = 2.0 * math.pi * natural
    bandwidth = integrate.quad(passed, 0.0, 400.0, limit=200)[0] + integrate.quad(passed, 400.0, math.inf)[0]
    assert bandwidth == pytest.approx(wn * (damping + 1.0 / (4.0 * damping)) / 2.0, rel=1e-5)
