"""The ring against SciPy's matrix exponential in turned axes, and its wave on the shell against a ring of its own."""

import math

import numpy as np
import pytest
from scipy import integrate, linalg

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


@pytest.mark.derivation(
    VibratingRing,
    equation="stiffness w^2 -+ w dw about the modal angle t, damping 2/T +- D about the modal angle s",
    source="diagonal matrices in turned axes and SciPy's matrix exponential",
    convention="dw and D are differences between both axes, not deviations from the mean; angles in the modal plane",
)
@pytest.mark.parametrize("driven", [False, True])
def test_against_matrices_of_principal_axes(driven: bool) -> None:
    """Stiffness and damping are diagonal in axes of their own; in the modal plane the rate counts n = 2 times."""
    f, split, t, s = 2000.0, 30.0, 0.3, -0.7
    w = 2.0 * math.pi * f
    d = w * 2.0 * math.pi * split
    stiffness = turned(t) @ np.diag([w * w - d, w * w + d]) @ turned(t).T
    damping = turned(s) @ np.diag([2.0 / 0.02 + 8.0, 2.0 / 0.02 - 8.0]) @ turned(s).T
    damping += 2.0 * 2 * 0.37 * 40.0 * np.array([[0.0, -1.0], [1.0, 0.0]])
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


def turned_on_the_shell(mode_number: int, frequency: float, rotation: float, duration: float) -> float:
    """Angle by which the wave of a thin ring turns on it, from the motion of its material.

    A point at the angle a moves outwards by x cos na + y sin na, and along the ring by (-x sin na + y cos na) / n,
    since the ring does not stretch. In axes that turn at W the Lagrangian of displacements u, over half the mass per
    radian, is the integral over a of u' . u' + 2 W (e_z x u) . u', less the elastic energy. So for q = (x, y)
    M q'' + 2 W G q' + w^2 M q = 0, with M_ij the integral of u_i . u_j, and G_ij that of u_i . (e_z x u_j). Terms in
    W^2 are left out.
    """
    around = np.linspace(0.0, 2.0 * math.pi, 720, endpoint=False)
    c, s = np.cos(mode_number * around), np.sin(mode_number * around)
    outwards, along = np.array([c, s]), np.array([-s, c]) / mode_number
    inertia = outwards @ outwards.T + along @ along.T
    gyroscopic = np.linalg.solve(inertia, along @ outwards.T - outwards @ along.T)
    w = 2.0 * math.pi * frequency

    def rates(_: float, q: np.ndarray) -> np.ndarray:
        return np.concatenate([q[2:], -w * w * q[:2] - 2.0 * rotation * gyroscopic @ q[2:]])

    period = np.linspace(duration - 1.0 / frequency, duration, 40, endpoint=False)
    start = [1.0, 0.0, 0.0, 0.0]
    moved = integrate.solve_ivp(rates, (0.0, duration), start, "DOP853", period, rtol=1e-11, atol=1e-12)
    return wave(moved.y[0], moved.y[1], mode_number)


def wave(x: np.ndarray, y: np.ndarray, mode_number: int) -> float:
    """The angle on the shell, nearest to 0, where it moves outwards the most."""
    around = np.linspace(-0.5, 0.5, 20_001) * math.pi / mode_number
    moves = np.outer(np.cos(mode_number * around), x) + np.outer(np.sin(mode_number * around), y)
    return float(around[np.argmax((moves**2).sum(axis=1))])


@pytest.mark.exhaustive
@pytest.mark.derivation(
    VibratingRing,
    equation="x'' - 2 n k W y' + ... = Fx / m, k = 2 / (n^2 + 1) of a thin ring",
    source="Lagrangian of the inextensional ring, integrated around the shell and over time by SciPy",
    convention="k between angles on the shell, n k in the modal plane",
    wrong="S300: k stood in the modal plane, so that waves turned half as far at n = 2",
)
@pytest.mark.defect("S300", before="a wave turned on the shell by half of Bryan's factor", after="by Bryan's factor")
@pytest.mark.parametrize("mode_number", [2, 3, 4])
def test_the_wave_of_a_thin_ring(mode_number: int) -> None:
    """A ring of 1 kHz that turns by 0.8 rad."""
    expected = turned_on_the_shell(mode_number, 1000.0, 8.0, 0.1)
    assert expected == pytest.approx(-0.8 * 2.0 / (mode_number**2 + 1), abs=3e-3)  # it turns by 3e-3 in a period
    thin = {"angular_gain": 2.0 / (mode_number**2 + 1), "mode_number": mode_number}
    values = run(8.0, driven=False, samples=10_001, frequency=1000.0, time_constant=1e9, **thin)[-100:]
    assert wave(values[:, 0], values[:, 2], mode_number) == pytest.approx(expected, abs=1e-4)


def test_a_ring_that_begins_in_vibration() -> None:
    """Displaced and let go, each mode is a cosine of its own amplitude; a pattern on the shell is at half the angle."""
    start = {"initial_x_displacement": 3e-7, "initial_y_displacement": 4e-7}
    blocks: dict[str, Block] = {
        "none": Constant(unit="N", value=0.0),
        "ring": VibratingRing(time_constant=1e9, **start),
    }
    probes = ["ring.x_displacement", "ring.y_displacement", "ring.x_velocity"]
    graph = Graph(name="ring", rate=RATE, blocks=blocks, wires=["none.output -> ring.x_force"], probes=probes)
    result = simulate(graph, samples=SAMPLES, engine="python")
    w = 2.0 * math.pi * 14_000.0
    t = np.arange(SAMPLES) / RATE
    assert result[probes[0]].values == pytest.approx(3e-7 * np.cos(w * t), abs=1e-15)
    assert result[probes[1]].values == pytest.approx(4e-7 * np.cos(w * t), abs=1e-15)
    assert result[probes[2]].values == pytest.approx(-3e-7 * w * np.sin(w * t), abs=1e-10)
