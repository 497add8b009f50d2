"""The open electrode against the closed form of a high-pass of first order."""

import numpy as np
import pytest

from proofmass.blocks import PiezoelectricSensor, Step
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate


def test_a_constant_velocity_against_the_closed_form() -> None:
    """V = R theta v (1 - e^(-t / (R C))), and theta v into a charge amplifier."""
    graph = Graph(
        name="push",
        rate="1 kHz",
        blocks={
            "motion": Step(amplitude=2e-3, unit="m/s"),
            "sensor": PiezoelectricSensor(coupling=3e-7, capacitance=20e-12, resistance=1e9),
        },
        wires=["motion.output -> sensor.velocity"],
        probes=["sensor.voltage", "sensor.current"],
    )
    result = simulate(graph, samples=60, engine="python")
    t = np.arange(60) * 1e-3
    expected = 3e-7 * 2e-3 * 1e9 * -np.expm1(-t / (1e9 * 20e-12))
    assert result["sensor.voltage"].values == pytest.approx(expected, rel=1e-12)
    assert result["sensor.current"].values == pytest.approx(np.full(60, 6e-10))


@pytest.mark.derivation(
    PiezoelectricSensor,
    equation="C V' = coupling v - V / R",
    source="charge that is not lost: coupling x is on C and has gone through R, by an integral of the voltage",
    convention="coupling x is the charge out of the electrode, its sign against that of PiezoelectricActuator",
    wrong="the documents gave the current no direction: it counts against that of PiezoelectricActuator",
)
def test_no_charge_is_lost() -> None:
    """It moves by 40 um within 20 ms, and rests; the trapezoids of 0.1 ms of a fall of 30 ms are off by 1e-6."""
    graph = Graph(
        name="moved",
        rate="10 kHz",
        blocks={
            "motion": Step(amplitude=2e-3, duration=20e-3, unit="m/s"),
            "sensor": PiezoelectricSensor(coupling=4e-7, capacitance=15e-12, resistance=2e9),
        },
        wires=["motion.output -> sensor.velocity"],
        probes=["sensor.voltage", "sensor.current"],
    )
    result = simulate(graph, samples=401, engine="python")
    volts = result["sensor.voltage"].values
    gone = np.concatenate([[0.0], np.cumsum(0.5 * (volts[1:] + volts[:-1]))]) * 1e-4 / 2e9
    moved = 4e-7 * 2e-3 * np.minimum(np.arange(401) * 1e-4, 20e-3)
    assert 15e-12 * volts + gone == pytest.approx(moved, rel=1e-5, abs=1e-20)
    assert np.sum(result["sensor.current"].values) * 1e-4 == pytest.approx(4e-7 * 40e-6, rel=1e-12)
