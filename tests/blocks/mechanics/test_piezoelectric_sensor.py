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
