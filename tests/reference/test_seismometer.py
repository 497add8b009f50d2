"""The seismometer of the gallery against a program of its own: plant by SciPy, the rest in plain Python."""

import itertools
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


def period(stiffness: float, damping: float, gain: float) -> np.ndarray:
    """Map of 20 ticks: mass, frame, notch, derivative and what was before, what is held, integral, sum and mean."""
    a = np.zeros((4, 4))
    a[0, 1] = a[2, 3] = 1.0
    a[1, :2] = -((2.0 * math.pi * 2.0) ** 2), -0.025 / 0.1
    a[3, 2:] = -stiffness / 0.5, -damping / 0.5
    whole = scipy.linalg.expm(np.block([[a, np.array([[0.0, 10.0, 0.0, 2.0]]).T], [np.zeros((1, 5))]]) * T)
    numerator, denominator = signal.iirnotch(560.0, 1.2, 2000.0)
    decay, own, moved = math.exp(-2.0 * math.pi * 400.0 * T), np.eye(12), np.eye(12)
    for n in range(20):
        code = gain * BITS * (own[0] + own[2])
        notched = numerator[0] * code + own[4]
        derivative = decay * own[6] - 2.36e-3 / T * (1.0 - decay) * (notched - own[7])
        held = own[9] if n == 0 else own[8]
        total = notched + (0.0 if n == 0 else own[10])
        tick = np.array([
            *np.zeros((4, 12)),
            numerator[1] * code - denominator[1] * notched + own[5],
            numerator[2] * code - denominator[2] * notched,
            derivative, notched, held, own[9] - 0.014 * own[11] * (n == 0), total, total / 20.0 if n == 19 else own[11],
        ])  # fmt: skip
        tick[:4, :4] = whole[:4, :4]
        tick[:4] += np.outer(whole[:4, 4], (-0.2216 * notched + derivative + held) / BITS)
        moved = tick @ moved
    return moved


def test_no_frame_of_the_study_takes_the_loop_away() -> None:
    """Three standard deviations: all corners, and random places. `proofmass prove` shows it of all frames."""
    nominal = 0.5 * (2.0 * math.pi * 600.0) ** 2, 0.5 * 2.0 * math.pi * 600.0 / 500.0, 1e4
    draw = np.random.default_rng(3)
    parts = [*itertools.product((-1.0, 1.0), repeat=3), *draw.uniform(-1.0, 1.0, (40, 3))]
    for part in parts:
        values = [value * (1.0 + width * p) for value, width, p in zip(nominal, (0.12, 0.6, 0.15), part, strict=True)]
        assert max(abs(np.linalg.eigvals(period(*values)))) < 0.985
