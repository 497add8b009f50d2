"""The beam: frequency by axial force and decay by quality, against the closed form of a damped swing."""

import math

import numpy as np
import pytest
from scipy import linalg

from proofmass.blocks import Constant, ResonantBeam, Step
from proofmass.graphs.model.build import Graph
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


def clamped(axial: float, pieces: int = 8) -> tuple[float, float]:
    """w^2 and Euler's load of a clamped beam with E I = rho A = L = 1, by Hermite's cubic elements."""
    h = 1.0 / pieces
    bend = [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h**2, -6 * h, 2 * h**2]]
    bend += [[-12, -6 * h, 12, -6 * h], [6 * h, 2 * h**2, -6 * h, 4 * h**2]]
    pull = [[36, 3 * h, -36, 3 * h], [3 * h, 4 * h**2, -3 * h, -(h**2)]]
    pull += [[-36, -3 * h, 36, -3 * h], [3 * h, -(h**2), -3 * h, 4 * h**2]]
    mass = [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h**2, 13 * h, -3 * h**2]]
    mass += [[54, 13 * h, 156, -22 * h], [-13 * h, -3 * h**2, -22 * h, 4 * h**2]]
    k, g, m = (np.zeros((2 * pieces + 2,) * 2) for _ in range(3))
    for i in range(0, 2 * pieces, 2):
        place = np.s_[i : i + 4, i : i + 4]
        k[place] += np.divide(bend, h**3)
        g[place] += np.divide(pull, 30.0 * h)
        m[place] += np.multiply(mass, h / 420.0)
    free = np.s_[2:-2, 2:-2]
    square = linalg.eigh((k + axial * g)[free], m[free], eigvals_only=True)[0]
    return float(square), float(linalg.eigh(k[free], g[free], eigvals_only=True)[0])


@pytest.mark.derivation(
    ResonantBeam,
    equation="f = f0 sqrt(1 + N / Nc), Nc = 3.39 E b h^3 / L^2 and f0 = 1.028 h / L^2 sqrt(E / rho) if clamped",
    source="finite elements of a clamped beam under axial force, Hermite's cubics, and Euler's load of the same",
    convention="tension is positive; Nc is that of the slope, 3 % above the load at which the beam buckles",
    wrong="the documents called Nc Euler's force: with that, 3.29, the scale factor is 3.1 % too large",
)
def test_a_clamped_beam_by_finite_elements() -> None:
    """1 mm by 0.2 mm by 6 mm of 78 GPa and 2650 kg/m^3, and 2 % of Nc to either side."""
    width, high, length, modulus, density = 1e-3, 0.2e-3, 6e-3, 78e9, 2650.0
    bending, per_length = modulus * width * high**3 / 12.0, density * width * high
    frequency = 1.028 * high / length**2 * math.sqrt(modulus / density)
    critical = 3.39 * modulus * width * high**3 / length**2
    for axial in (-0.02 * critical, 0.0, 0.02 * critical):
        block = ResonantBeam(frequency=frequency, quality=1e12, axial_force=axial, critical_force=critical)
        push = Step(amplitude=1e-3, duration=1e-6, unit="N")
        wires, probes = ["push.output -> beam.force"], ["beam.displacement"]
        graph = Graph(name="b", rate="1 MHz", blocks={"push": push, "beam": block}, wires=wires, probes=probes)
        x = simulate(graph, samples=200, engine="python")["beam.displacement"].values[1:]
        twice_cosine = np.dot(x[2:] + x[:-2], x[1:-1]) / np.dot(x[1:-1], x[1:-1])
        found = math.acos(0.5 * twice_cosine) * 1e6
        square, euler = clamped(axial * length**2 / bending)
        assert found == pytest.approx(math.sqrt(square * bending / per_length) / length**2, rel=1.5e-4)
    assert euler == pytest.approx(4.0 * math.pi**2, rel=1e-3)
    slope = (clamped(1.0)[0] - clamped(-1.0)[0]) / (2.0 * clamped(0.0)[0])
    assert (1.0 / slope / 12.0, euler / 12.0) == pytest.approx((3.39, 3.29), abs=2e-3)
