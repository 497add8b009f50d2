"""The short graphs of the library that stand for longer ones: against SciPy, plain programs and closed forms."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy import linalg, optimize, signal

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate

ROOT = Path(__file__).parents[2]


def graph(name: str) -> Graph:
    return read_graph(library_file(f"{name}.toml"))


def run(name: str, **options: object) -> Result:
    return simulate(graph(name), engine="compiled", **options)  # type: ignore[arg-type]


def test_filters_against_scipy() -> None:
    result = run("filters_by_name", samples=2000)
    u = result["noise.output"].values
    sections = {
        "low_pass.output": signal.butter(6, 800.0, fs=10e3, output="sos"),
        "notch.output": signal.tf2sos(*signal.iirnotch(500.0, 30.0, fs=10e3)),
        "all_pass.output": np.array([[0.5, -0.9, 1.0, 1.0, -0.9, 0.5]]),
        "band.output": signal.ellip(3, 0.5, 40.0, [900.0, 1100.0], "bandpass", fs=10e3, output="sos"),
    }
    for name, sos in sections.items():
        assert result[name].values == pytest.approx(signal.sosfilt(sos, u), abs=1e-11 * np.abs(u).max()), name
    mean = signal.lfilter(np.full(32, 1.0 / 32.0), 1.0, u)
    assert result["average.mean"].values == pytest.approx(mean, abs=1e-13)
    taps = signal.firwin(64, 0.2, window=("kaiser", 8.0))
    before = np.concatenate([[0.0], u[:-1]])  # the samples before the tick
    assert result["linear_phase.output"].values == pytest.approx(signal.lfilter(taps, 1.0, before), abs=1e-12)


def test_modulators_bit_by_bit() -> None:
    result = run("sigma_delta_modulators", samples=20_000)
    x = y = z = 0.0
    first, second = [], []
    for u in result["input.output"].values:
        v, w = (1.0 if state >= 0.0 else -1.0 for state in (x, z))
        first.append(v)
        second.append(w)
        x += u - v
        y, z = y + (u - w), z + (y - 2.0 * w)
    assert result["first.output"].values.tolist() == first
    assert result["second.output"].values.tolist() == second


def test_averaged_loop_against_a_program() -> None:
    """Two averages over eight samples, which end before the tick of the controller; a PID without derivative."""
    result = run("averaged_loop")
    decay = math.exp(-2.0 * math.pi * 200.0 / 64e3)
    triangle = np.convolve(np.ones(8), np.ones(8)) / 64.0
    past, x, u, total = [0.0] * 15, 0.0, 0.0, 0.0
    plant, decimated = [], []
    for n in range(len(result["plant.output"].values)):
        plant.append(x)
        if n % 8 == 0:
            decimated.append(float(np.dot(triangle, past)))
            error = 1.0 - decimated[-1]
            total += 1000.0 / 8e3 * error
            u = error + total
        past = [x, *past[:14]]
        x = decay * x + (1.0 - decay) * u
    assert result["decimator.output"].values == pytest.approx(decimated, abs=1e-12)
    assert result["plant.output"].values == pytest.approx(plant, abs=1e-12)


def test_drive_loop_finds_the_resonance() -> None:
    result = run("drive_loop")
    resonance = math.sqrt(126.5 / 50e-9) / (2.0 * math.pi)
    assert result.measures["amplitude"].value == pytest.approx(0.5, rel=1e-4)
    assert 8000.0 + result.measures["frequency"].value == pytest.approx(resonance, abs=0.05)
    drive = result["loop.drive"].values[-200:].mean()
    force = drive * 2.0 * 1.4756979688e-8 * 20.0 * math.sin(math.pi / 16.0) / (math.pi / 16.0)
    assert force == pytest.approx(3.14e-7 * 2.0 * math.pi * resonance * 1e-6, rel=0.02)  # c v at 1 um


def test_force_to_rebalance_reads_the_rate() -> None:
    result = run("force_to_rebalance")
    assert result.measures["rate"].value == pytest.approx(math.radians(10.0), rel=0.01)
    assert result.measures["start_up"].value < 0.03
    still = simulate(graph("force_to_rebalance").with_parameters({"rotation.value": 0.0}), engine="compiled")
    assert abs(still.measures["rate"].value) < math.radians(0.1)


def test_noise_of_a_data_sheet_has_its_allan_deviation() -> None:
    """At 1 s angle random walk alone: N / sqrt(tau) of 0.1 deg/sqrt(h)."""
    values = run("gyroscope_noise", duration="400 s")["axis.output"].values[:40_000]
    means = values.reshape(-1, 100).mean(axis=1)
    deviation = math.sqrt(0.5 * np.mean(np.diff(means) ** 2))
    assert deviation == pytest.approx(math.radians(0.1) / 60.0, rel=0.12)


def test_lines_of_the_page_are_those_of_the_files() -> None:
    page = (ROOT / "docs/fewer-lines.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| .* \| (\d+) \| \[`(\w+)`\].* \| (\d+) \|$", page, re.MULTILINE)
    assert len(rows) >= 8
    for before, name, after in rows:
        assert len(library_file(f"{name}.toml").read_text(encoding="utf-8").splitlines()) == int(after), name
        assert int(before) > 0


def test_coupled_axes_against_the_matrix_exponential() -> None:
    """The plant under the forces that the loops make, and where the loops bring it."""
    result = run("coupled_axes", duration="0.2 s")
    mass, damping = np.diag([50e-6, 60e-6]), np.diag([0.02, 0.01])
    stiffness, entry = np.array([[50.0, -20.0], [-20.0, 80.0]]), np.array([[1.0, 0.0], [0.2, 1.0]])
    inverse, zero = np.linalg.inv(mass), np.zeros((2, 2))
    a = np.block([[zero, np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    step = linalg.expm(np.block([[a, np.vstack([zero, inverse @ entry])], [np.zeros((2, 6))]]) * 1e-4)
    forces = np.column_stack([result[f"{name}_delay.output"].values for name in ("first", "second")])
    x, expected = np.zeros(4), []
    for force in forces:
        expected.append(x[:2])
        x = step[:4, :4] @ x + step[:4, 4:] @ force
    found = np.column_stack([result[f"axes.{name}"].values for name in ("one", "two")])
    assert found == pytest.approx(np.array(expected), abs=1e-15)
    assert found[-1] == pytest.approx([1e-6, 0.0], abs=1e-9)


def test_the_accelerometer_in_a_chamber_against_its_data_sheet() -> None:
    quiet = graph("chamber_accelerometer").with_parameters({"noise.density": 0.0})
    result = simulate(quiet, engine="compiled")
    warmer = result["chamber.temperature"].values - 298.15
    sign = np.where(np.arange(len(warmer)) * 10 % 400 < 200, 1.0, -1.0)
    senses = (1.0 - 100e-6 * warmer + 2e-7 * warmer**2) * sign * 9.80665 + 0.15 + 5e-4 * warmer
    codes = np.round(0.1 * senses / (2.5 * (1.0 + 5e-6 * warmer)) * 2.0**19)
    assert (result["adc.code"].values == codes).all()
    error = np.mean((codes * sign)[:1440]) * 2.5 / 2.0**19 / 0.1 / 9.80665 - 1.0
    assert result.measures["found"].value == pytest.approx(error, abs=1e-9)
    assert result.measures["kept"].value == pytest.approx(1.0 / (1.0 + error), rel=1e-9)


def test_cantilever_against_the_beam_of_euler_and_bernoulli() -> None:
    """Under a step of force at the tip each mode has 4 F / (m w^2) at rest, w from cos(k) cosh(k) = -1."""
    found = run("finite_element_cantilever", samples=200)["tip.output"].values
    length, width, height, young, density = 1e-3, 50e-6, 10e-6, 169e9, 2330.0
    mass = density * width * height * length
    t, expected, slowest = np.arange(200) * 1e-6, np.zeros(200), 0.0
    for guess in (1.9, 4.7, 7.9):
        k = optimize.brentq(lambda x: math.cos(x) * math.cosh(x) + 1.0, guess - 0.1, guess + 0.1)
        w = k * k * math.sqrt(young * width * height**3 / 12.0 / (mass / length)) / length**2
        slowest = slowest or w
        decay = 0.5 * w * w / (100.0 * slowest)
        expected += 4e-6 / (mass * w * w) * (1.0 - np.exp(-decay * t) * np.cos(math.sqrt(w * w - decay**2) * t))
    assert np.abs(found - expected).max() < 0.01 * 1e-6 * length**3 / (3.0 * young * width * height**3 / 12.0)
