"""The detector: its current, and shot and intensity noise against their densities."""

import math

import numpy as np
import pytest

from proofmass.blocks import Constant, Photodetector
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate
from tests.by_hand.responses import response


def currents(block: Photodetector, power: float) -> np.ndarray:
    graph = Graph(
        name="light",
        rate="1 MHz",
        blocks={"light": Constant(value=power, unit="W"), "detector": block},
        wires=["light.output -> detector.power"],
        probes=["detector.current"],
        seed=3,
    )
    return simulate(graph, samples=20_000)["detector.current"].values


@pytest.mark.parametrize("relative", [0.0, 1e-13])
def test_noise_against_its_densities(relative: float) -> None:
    found = currents(Photodetector(intensity_noise=relative, dark_current=0.0), 10e-6)
    assert found.mean() == pytest.approx(9e-6, rel=1e-4)
    density = math.sqrt(2.0 * 1.602176634e-19 * 9e-6 + relative * 9e-6**2)
    assert found.std() == pytest.approx(density * math.sqrt(0.5e6), rel=0.02)


def test_without_noise_it_is_a_straight_line() -> None:
    block = Photodetector(responsivity=0.5, dark_current=2e-9, noisy=False)
    assert response(block, [4e-6, 0.0, -1e-6], "current", "power") == [
        pytest.approx(2.002e-6, rel=1e-15),
        2e-9,
        2e-9,
    ]
