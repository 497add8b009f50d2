"""The beam: frequency by axial force and decay by quality, against the closed form of a damped swing."""

import math

import numpy as np
import pytest

from proofmass.blocks import Constant, ResonantBeam, Step
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate

MASS, FREQUENCY, QUALITY, CRITICAL = 2e-9, 1000.0, 50.0, 0.5


def stepped(axial: float, driven: bool) -> np.ndarray:
    """Displacement after a step of 1 uN, the axial force as a parameter or by a wire."""
    blocks = {
        "push": Step(amplitude=1e-6, unit="N"),
        "load": Constant(value=axial, unit="N"),
        "beam": ResonantBeam(
            mass=MASS,
            frequency=FREQUENCY,
            quality=QUALITY,
            axial_force=0.0 if driven else axial,
            critical_force=CRITICAL,
        ),
    }
    wires = ["push.output -> beam.force"] + (["load.output -> beam.axial_force"] if driven else [])
    graph = Graph(name="beam", rate="20 kHz", blocks=blocks, wires=wires, probes=["beam.displacement"])
    return simulate(graph, samples=400, engine="python")["beam.displacement"].values


@pytest.mark.parametrize("driven", [False, True])
@pytest.mark.parametrize("axial", [-0.2, 0.0, 0.35])
def test_a_step_against_the_closed_form(axial: float, driven: bool) -> None:
    w0 = 2.0 * math.pi * FREQUENCY
    square, decay = w0 * w0 * (1.0 + axial / CRITICAL), 0.5 * w0 / QUALITY
    w, t = math.sqrt(square - decay * decay), np.arange(400) / 20_000.0
    swing = np.exp(-decay * t) * (np.cos(w * t) + decay / w * np.sin(w * t))
    expected = 1e-6 / (MASS * square) * (1.0 - swing)
    assert np.abs(stepped(axial, driven) - expected).max() < 1e-12 * expected.max()


def test_a_clamped_beam_has_the_buckling_force_of_its_geometry() -> None:
    """f = f0 sqrt(1 + N / Nc): a hundredth of Nc moves the frequency by half a percent, nearly."""
    assert math.sqrt(1.01) - 1.0 == pytest.approx(0.005, rel=3e-3)
    assert ResonantBeam.drivable("axial_force")
    assert ResonantBeam.linear
