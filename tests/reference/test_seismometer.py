"""The seismometer of the gallery against a program of its own: plant by SciPy, the rest in plain Python."""

import math

import numpy as np
import pytest
import scipy.linalg
from scipy import signal

from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.runner.run.simulate import simulate

GRAPH = read_graph(library_file("force_balance_seismometer.toml"))
T, TICKS = 1.0 / 2000.0, 6_001
BITS = 2.0**23 / 5.0  # a volt


def plant() -> tuple[np.ndarray, np.ndarray]:
    """Mass and frame, driven by the ground's force and the coil's."""
    a = np.zeros((4, 4))
    a[0, 1] = a[2, 3] = 1.0
    a[1, :2] = -((2.0 * math.pi * 2.0) ** 2), -0.025 / 0.1
    a[3, 2:] = -((2.0 * math.pi * 600.0) ** 2), -2.0 * math.pi * 600.0 / 500.0
    b = np.array([[0.0, 0.0], [10.0, 10.0], [0.0, 0.0], [0.0, 2.0]])
    whole = scipy.linalg.expm(np.block([[a, b], [np.zeros((2, 6))]]) * T)
    return whole[:4, :4], whole[:4, 4:]


def by_hand() -> tuple[np.ndarray, np.ndarray]:
    """Output at 100 Hz and position at 2 kHz."""
    transition, entry = plant()
    numerator, denominator = signal.iirnotch(560.0, 1.2, 2000.0)
    decay = math.exp(-2.0 * math.pi * 400.0 * T)
    x, delays = np.zeros(4), np.zeros(2)
    derivative = before = integral = held = total = mean = 0.0
    commands, positions = [], []
    for n in range(TICKS):
        position = x[0] + x[2]
        code = float(round(1e4 * position * BITS))
        notched = numerator[0] * code + delays[0]
        delays = np.array([
            numerator[1] * code - denominator[1] * notched + delays[1],
            numerator[2] * code - denominator[2] * notched,
        ])  # fmt: skip
        derivative = decay * derivative - 2.36e-3 / T * (1.0 - decay) * (notched - before)
        before = notched
        if n % 20 == 0:
            held = integral
            integral -= 1.4 * 0.01 * mean
        total += notched
        if n % 20 == 19:
            mean, total = total / 20.0, 0.0
        command = -0.2216 * notched + derivative + held
        coil = round(command) / BITS
        ground = 0.1 * (0.01 + 1e-3 * math.sin(2.0 * math.pi * n * T))
        x = transition @ x + entry @ [ground, coil]
        commands.append(command)
        positions.append(position)
    taps = signal.firwin(240, 0.04, window=("kaiser", 8.0))
    filtered = np.concatenate([[0.0], np.convolve(commands, taps)])[:TICKS:20]
    return -10.0 / BITS * filtered, np.array(positions)


def test_against_a_program_of_its_own() -> None:
    quiet = GRAPH.with_parameters({"amplifier.density": 0.0, "gas.temperature": 0.0})
    result = simulate(quiet, samples=TICKS, engine="compiled")
    output, position = by_hand()
    assert result["output.output"].values == pytest.approx(output, abs=1e-9)
    assert result["position.output"].values == pytest.approx(position[::20], abs=1e-12)
    assert abs(output[-100:].mean() - 0.01) < 1e-5
