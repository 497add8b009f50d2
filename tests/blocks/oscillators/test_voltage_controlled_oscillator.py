"""The analog oscillator: its phase is the integral of its frequency, between ticks too."""

import math
from fractions import Fraction

import numpy as np
import pytest

from proofmass.blocks import Constant, LowPass, Step, VoltageControlledOscillator
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.engine_table import EngineName
from proofmass.runner.run.simulate import simulate


@pytest.mark.derivation(
    VoltageControlledOscillator,
    equation="turns' = frequency + gain control, sine = amplitude sin(2 pi turns)",
    source="integral of 500 Hz + 600 Hz (1 - exp(-t / tau)) by hand",
    convention="frequency and gain in Hz, not rad/s; amplitude is the peak; the phase in rad with whole turns",
    wrong="S679: each step rounded the count of all turns, 0.33 rad after 1e8",
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
    assert result["vco.phase"].values == pytest.approx(phase, rel=1e-13)
    assert result["vco.sine"].values == pytest.approx(1.5 * np.sin(phase), abs=1e-11)
    assert result["vco.cosine"].values == pytest.approx(1.5 * np.cos(phase), abs=1e-11)


def test_it_breaks_a_loop() -> None:
    assert VoltageControlledOscillator.feedthrough("sine") == ()


@pytest.mark.defect(
    "S679",
    before="each step rounded the count of all turns: off by 0.33 rad after 1e8 turns in 1e7 steps",
    after="whole turns are counted apart in each tick: each step rounds a part of a turn",
)
@pytest.mark.parametrize("engine", ["python", "compiled"])
def test_many_turns_against_exact_fractions(engine: EngineName) -> None:
    """From 2^31 turns on, of which a step rounds 2^-22; the control of 0.1 V is a double."""
    rate, begun = 1 << 15, 1 << 31
    oscillator = VoltageControlledOscillator(
        frequency=4321.0, gain=999.0, amplitude=2.0, initial_phase=2.0 * math.pi * begun
    )
    graph = Graph(
        name="for long",
        rate=rate,
        blocks={"control": Constant(value=0.1, unit="V"), "vco": oscillator},
        wires=["control.output -> vco.control"],
        probes=["vco.sine", "vco.cosine", "vco.phase"],
    )
    result = simulate(graph, samples=600, engine=engine)
    turns = [(4321 + 999 * Fraction(0.1)) * n / rate for n in range(600)]
    angles = 2.0 * np.pi * np.array([float(turn - round(turn)) for turn in turns])
    assert result["vco.sine"].values == pytest.approx(2.0 * np.sin(angles), abs=1e-12)
    assert result["vco.cosine"].values == pytest.approx(2.0 * np.cos(angles), abs=1e-12)
    whole = 2.0 * np.pi * np.array([float(begun + turn) for turn in turns])
    assert result["vco.phase"].values == pytest.approx(whole, rel=4e-16)


def test_only_a_continuous_block_folds_its_state() -> None:
    class Folded(Block):
        """A block without a derivative."""

    with pytest.raises(TypeError, match="only continuous blocks have one"):
        Folded.fold(lambda p, x: x)
