"""Noise of the capacitor, and of the jitter of a sampled sine, against their closed forms."""

import math

import numpy as np
import pytest

from proofmass.blocks import SamplingNoise, Sine
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.functions import drive


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


@pytest.mark.derivation(
    SamplingNoise,
    equation="s^2 = k T / C + (jitter slope)^2",
    source="equipartition, C <v^2> = k T: 64.4 uV of 1 pF at 300 K; textbook: -20 lg(2 pi f jitter) of a sine",
    convention="rms of one sample, whatever the rate; jitter is rms; of a sine its slope is rms too",
    wrong="S676: in tick 0 the slope was that of a jump from zero",
)
def test_half_a_boltzmann_energy_and_the_ratio_of_a_sine() -> None:
    """Of 4 pF at 400 K; a sine of 40 kHz with 30 ps of jitter has 20 lg(2 pi 40e3 30e-12) of noise: 102.5 dB."""
    (volts,) = (drive(SamplingNoise(capacitance=4e-12, temperature=400.0), [{"voltage": 0.0}], normal=1.0),)
    assert 0.5 * 4e-12 * volts[0]["output"] ** 2 == pytest.approx(0.5 * 1.380649e-23 * 400.0, rel=1e-12)
    sine = [1.7 * math.sin(2.0 * math.pi * 4e4 * n / 50e6) for n in range(1251)]
    rows = drive(SamplingNoise(temperature=0.0, jitter=30e-12), [{"voltage": v} for v in sine], 1.0 / 50e6, normal=1.0)
    error = [row["output"] - v for row, v in zip(rows, sine, strict=True)][1:]
    ratio = 20.0 * math.log10(1.7 / math.sqrt(2.0) / math.sqrt(np.mean(np.square(error))))
    assert ratio == pytest.approx(-20.0 * math.log10(2.0 * math.pi * 4e4 * 30e-12), abs=0.01)
    assert ratio == pytest.approx(102.45, abs=0.02)


@pytest.mark.defect(
    "S676", before="jitter of a constant volt in tick 0: 1 mV at 1 ns and 1 MHz", after="none: it does not move"
)
def test_a_constant_voltage_has_no_jitter() -> None:
    block = SamplingNoise(temperature=0.0, jitter=1e-9)
    rows = drive(block, [{"voltage": 1.0}] * 3, 1e-6, normal=1.0)
    assert [row["output"] for row in rows] == [1.0, 1.0, 1.0]
