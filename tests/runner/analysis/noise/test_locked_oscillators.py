"""Oscillators that a mixer locks: their noise by the closed forms of phase-locked loops.

With wn and damping z the noise bandwidth of the loop is wn (z + 1 / (4 z)) / 2 (Gardner, Phaselock Techniques,
2005, chapter 2).
"""

import math
from typing import Any

import pytest

from proofmass import Graph, noise
from proofmass.blocks import (
    LoopFilter,
    MovingAverage,
    NumericallyControlledOscillator,
    PhaseMixer,
    Sum,
    VoltageControlledOscillator,
    WhiteNoise,
)
from proofmass.blocks.declaration.declare import Block
from proofmass.runner.planning.plan import plan
from proofmass.runner.targets.native_slopes import has_slopes

RATE, CARRIER, NATURAL = 200e3, 20e3, 100.0
DAMPING = 0.5 * math.sqrt(2.0)
BANDWIDTH = math.pi * NATURAL * (DAMPING + 0.25 / DAMPING)  # Hz, one-sided


def locked(signal: float, frequency: float, oscillator: Block | None = None, **integration: Any) -> Graph:
    """An oscillator that follows another one, with noise in the signal or in the frequency."""
    return Graph(
        name="",
        rate=RATE,
        blocks={
            "moving": WhiteNoise(density=frequency, unit="Hz"),
            "reference": NumericallyControlledOscillator(frequency=CARRIER),
            "noise": WhiteNoise(density=signal),
            "signal": Sum(),
            "detector": PhaseMixer(),
            "filter": LoopFilter(natural_frequency=NATURAL, damping=DAMPING),
            "oscillator": oscillator or NumericallyControlledOscillator(frequency=CARRIER + 10.0),
        },
        wires=[
            "moving.output -> reference.control",
            "reference.sine -> signal.first",
            "noise.output -> signal.second",
            "signal.output -> detector.first",
            "oscillator.cosine -> detector.second",
            "detector.phase -> filter.error",
            "filter.control -> oscillator.control",
        ],
        probes=["oscillator.phase"],
        integration=integration,
    )


def test_noise_in_the_signal_is_that_of_the_noise_bandwidth() -> None:
    """The phase has twice the density of the signal of amplitude one, up to the bandwidth."""
    density = 1e-6
    budget = noise(locked(density, 1e-9), "oscillator.phase", band=(1.0, 20e3), at="periodic")
    assert budget.rms == pytest.approx(math.sqrt(2.0 * BANDWIDTH) * density, rel=0.01)
    assert budget.sources[0].block == "noise"


@pytest.mark.parametrize("at", ["periodic", "60 ms"])
def test_noise_in_the_frequency_is_followed(at: str) -> None:
    """The control has the density of the other oscillator's frequency, up to the bandwidth."""
    budget = noise(locked(1e-12, 0.1), "filter.control", band=(1.0, 15e3), at=at)
    assert budget.rms == pytest.approx(0.1 * math.sqrt(BANDWIDTH), rel=0.02)


ANALOG = VoltageControlledOscillator(frequency=CARRIER + 10.0, gain=1.0, control_unit="Hz", unit="1")


STEPPED = locked(1e-6, 1e-9, ANALOG, method="dormand_prince", accuracy=1e-12)


def test_slopes_of_an_analog_oscillator_are_in_machine_code() -> None:
    assert has_slopes(plan(locked(1e-6, 1e-9, ANALOG)))
    assert not has_slopes(plan(STEPPED))


@pytest.mark.exhaustive
@pytest.mark.parametrize("other", [STEPPED, locked(1e-6, 1e-9)], ids=["stepped", "digital"])
def test_noise_of_an_analog_oscillator_that_is_held_exactly(other: Graph) -> None:
    """It is that of slopes along steps, and that of the loop with a digital oscillator."""
    options = {"band": (1.0, 20e3), "at": "periodic"}
    found, expected = (noise(g, "filter.control", **options).rms for g in (locked(1e-6, 1e-9, ANALOG), other))
    assert found == pytest.approx(expected, rel=1e-8)


@pytest.mark.defect("S30", before="a ValueError of NumPy", after="the budget")
def test_average_whose_places_turn() -> None:
    """A ring of numbers has another map in each tick, and others states between its ends."""
    graph = Graph(
        name="",
        rate=1000.0,
        blocks={"noise": WhiteNoise(density=0.1), "average": MovingAverage(length=32)},
        wires=["noise.output -> average.input"],
        probes=["average.mean"],
    )
    assert noise(graph, "average.mean").rms == pytest.approx(0.1 * math.sqrt(500.0 / 32.0))
