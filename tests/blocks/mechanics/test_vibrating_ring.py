"""The ring against SciPy's matrix exponential in turned axes, and its pattern that lags behind the case."""

import math

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import Constant, Step, VibratingRing
from proofmass.blocks.declaration.declare import Block
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import simulate

RATE, SAMPLES = 100_000, 400
PORTS = ("x_displacement", "x_velocity", "y_displacement", "y_velocity")


def run(rotation: float, driven: bool, samples: int = SAMPLES, **parameters: float) -> np.ndarray:
    blocks: dict[str, Block] = {
        "kick": Step(amplitude=1e-3, duration=20e-6, unit="N"),
        "ring": VibratingRing(**parameters, rotation=0.0 if driven else rotation),
    }
    wires = ["kick.output -> ring.x_force"]
    if driven:
        blocks["rate"] = Constant(value=rotation, unit="rad/s")
        wires.append("rate.output -> ring.rotation")
    probes = [f"ring.{port}" for port in PORTS]
    graph = Graph(name="ring", rate=RATE, blocks=blocks, wires=wires, probes=probes)
    result = simulate(graph, samples=samples, engine="compiled" if samples > SAMPLES else "python")
    return np.column_stack([result[probe].values for probe in probes])


def turned(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


@pytest.mark.parametrize("driven", [False, True])
def test_against_matrices_of_principal_axes(driven: bool) -> None:
    """Stiffness and damping are diagonal in axes of their own, turned by half turns of n = 2: twice the angle."""
    f, split, t, s = 2000.0, 30.0, 0.3, -0.7
    w = 2.0 * math.pi * f
    d = w * 2.0 * math.pi * split
    stiffness = turned(t) @ np.diag([w * w - d, w * w + d]) @ turned(t).T
    damping = turned(s) @ np.diag([2.0 / 0.02 + 8.0, 2.0 / 0.02 - 8.0]) @ turned(s).T
    damping += 2.0 * 0.37 * 40.0 * np.array([[0.0, -1.0], [1.0, 0.0]])
    a = np.block([[np.zeros((2, 2)), np.eye(2)], [-stiffness, -damping]])
    whole = np.zeros((5, 5))
    whole[:4, :4], whole[2, 4] = a, 1e-3 / 1e-7
    forced, free = linalg.expm(whole / RATE), linalg.expm(a / RATE)
    state, expected = np.zeros(4), []
    for n in range(SAMPLES):
        expected.append(state[[0, 2, 1, 3]])
        state = (forced @ [*state, 1.0])[:4] if n < 2 else free @ state
    parameters = {"frequency": f, "time_constant": 0.02, "frequency_split": split, "split_angle": t}
    parameters |= {"damping_split": 8.0, "damping_angle": s}
    values = run(40.0, driven, **parameters)
    assert values == pytest.approx(np.array(expected), abs=1e-10 * np.abs(np.array(expected)[:, 1]).max())


def test_the_pattern_turns_by_bryans_factor() -> None:
    """Of a free ring without loss, -k times the angle of the case: 1 rad in 10,000 ticks."""
    rotation = 10.0
    values = run(rotation, driven=False, samples=10_001, time_constant=1e9)
    x, y = values[-20:, 0], values[-20:, 2]
    angle = math.atan2(float(np.sum(x * y)), float(np.sum(x * x)))
    assert angle == pytest.approx(-0.37 * rotation * 0.1, abs=2e-3)
