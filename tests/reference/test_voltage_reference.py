"""The part `voltage_reference` against what its data sheet's words mean: coefficients, hysteresis, drift by sqrt(t)."""

import math

import numpy as np
import pytest

from proofmass.blocks import Constant, PiecewiseConstant
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

PART = read_graph(library_file("voltage_reference.toml"))
HOUR = 3600.0


def reference(temperature: Constant | PiecewiseConstant, period: float, **changed: float) -> Graph:
    return Graph(
        name="a reference in a chamber",
        rate=1.0 / period,
        blocks={"chamber": temperature, "reference": PART.with_parameters(changed)},
        wires=["chamber.output -> reference.temperature"],
        probes=["reference.voltage"],
        seed=1,
    )


def test_coefficients_and_hysteresis() -> None:
    """At 25 degrees Celsius after 100, then after -40, and between: half of the hysteresis to either side."""
    steps = (298.15, 373.15, 298.15, 233.15, 298.15)
    chamber = PiecewiseConstant(times=(0.0, 1.0, 2.0, 3.0, 4.0), values=steps, unit="K")
    graph = reference(chamber, 1.0, drift=0.0, hysteresis=40e-6, tc1=5e-6, tc2=-2e-8)
    voltage = simulate(graph, samples=5)["reference.voltage"].values
    lag = [0.0, 1.0, -1.0, -1.0, 1.0]  # of the package, over half of its play
    expected = [
        2.5 * (1.0 + (5e-6 - 2e-8 * (t - 298.15)) * (t - 298.15)) * (1.0 + 20e-6 * side)
        for t, side in zip(steps, lag, strict=True)
    ]
    assert voltage == pytest.approx(expected, rel=1e-12)
    assert voltage[4] - voltage[2] == pytest.approx(2.5 * 40e-6, rel=1e-9)


def test_within_its_play_the_package_stands_still() -> None:
    steps = (298.15, 305.15, 291.15, 298.15)
    graph = reference(PiecewiseConstant(times=(0.0, 1.0, 2.0, 3.0), values=steps, unit="K"), 1.0, drift=0.0, tc1=0.0)
    voltage = simulate(graph, samples=4)["reference.voltage"].values
    assert voltage / 2.5 - 1.0 == pytest.approx([0.0, 7 * 1.25e-6, -7 * 1.25e-6, 0.0], abs=1e-15)


def test_drift_grows_with_the_square_root_of_the_time() -> None:
    """20 ppm after 1000 h, in stretches of one record that have nothing in common."""
    graph = reference(Constant(value=298.15, unit="K"), 25 * HOUR)
    walk = simulate(graph, samples=40_001, engine="compiled")["reference.voltage"].values / 2.5 - 1.0
    for hours in (250, 1000, 4000):
        moved = np.diff(walk[:: hours // 25])
        bound = 4.0 / math.sqrt(2.0 * len(moved))
        assert moved.std() == pytest.approx(20e-6 * math.sqrt(hours / 1000.0), rel=bound), hours
