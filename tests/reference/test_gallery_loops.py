"""Margins, bandwidths and noise of sensors of the gallery against closed forms.

An oscillating mode answers to the amplitude of its force by an envelope of the first order, 1 / (s + w / (2 Q)); the
phase of a mode in resonance follows that of its force likewise. Controllers read means of 125 us, in the tick after.
"""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy import optimize, signal

from proofmass import margins, noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph

SLOW = 125e-6
COMB = 1.4756979688e-8  # F/m
Loop = Callable[[complex], complex]  # of z


def figures(loop: Loop, period: float, low: float, high: float) -> tuple[float, float, float]:
    """Crossover and bandwidth in Hz, and phase margin in degrees, of a loop that falls between two frequencies."""

    def at(frequency: float) -> complex:
        return loop(complex(np.exp(2j * np.pi * frequency * period)))

    crossover = optimize.brentq(lambda f: abs(at(f)) - 1.0, low, high)
    grid = np.geomspace(crossover, high, 4000)
    wide = next(f for f in grid if abs(at(f) / (1.0 + at(f))) < math.sqrt(0.5))
    return crossover, wide, 180.0 + math.degrees(np.angle(at(crossover)))


def envelope(gain: float, decay: float, proportional: float, integral: float) -> Loop:
    """PI controller, a mode's envelope under what is held over 125 us, its mean over these, and a tick of delay."""
    kept = math.exp(-decay * SLOW)

    def loop(z: complex) -> complex:
        return (proportional + integral * SLOW * z / (z - 1.0)) * gain * SLOW * (1.0 / (z - kept) + 0.5) / z

    return loop


def amplitude(mass: float, frequency: float, quality: float, force: float, volts: float, held: float) -> Loop:
    """Loop of an amplitude with a PI controller of 1, 125 1/s: N and V/m, and how many ticks a period has."""
    w = 2.0 * math.pi * frequency
    return envelope(force * volts / (2.0 * mass * w) * np.sinc(1.0 / held), 0.5 * w / quality, 1.0, 125.0)


def phase(frequency: float, quality: float) -> Loop:
    """Phase-locked loop of 60 Hz and a damping of 1 about a mode in resonance."""
    wn = 2.0 * math.pi * 60.0
    return envelope(1.0, math.pi * frequency / quality, 2.0 * wn, wn * wn)


GYROSCOPE, ACCELEROMETER = "closed_loop_gyroscope", "resonant_accelerometer"
LOOPS = [
    (GYROSCOPE, "rate", "0.15 s", amplitude(50e-9, 8000.0, 1000.0, 4.28 * 4.0 * COMB, 10e6, 16.0)),
    (GYROSCOPE, "quadrature", "0.15 s", amplitude(50e-9, 8000.0, 1000.0, 4.28 * 4.0 * COMB, 10e6, 16.0)),
    (GYROSCOPE, "drive_amplitude", "0.15 s", amplitude(50e-9, 8000.0, 2000.0, 8.56 * 40.0 * COMB, 0.5e6, 16.0)),
    (GYROSCOPE, "drive_phase", "0.15 s", phase(8000.0, 2000.0)),
    (ACCELEROMETER, "amplitude", "0.065 s", amplitude(1e-9, 40e3, 1e4, 8.42 * 60e-9, 0.5e6, 8.0)),
    (ACCELEROMETER, "phase", "0.065 s", phase(40e3, 1e4)),
]


@pytest.mark.exhaustive(
    "closed_loop_gyroscope-rate",
    "closed_loop_gyroscope-quadrature",
    "closed_loop_gyroscope-drive_amplitude",
    "resonant_accelerometer-amplitude",
    "closed_loop_gyroscope-drive_phase",
)
@pytest.mark.parametrize(("name", "loop", "at", "expected"), LOOPS, ids=[f"{row[0]}-{row[1]}" for row in LOOPS])
def test_loops_of_oscillators(name: str, loop: str, at: str, expected: Loop) -> None:
    crossover, wide, margin = figures(expected, SLOW, 20.0, 1500.0)
    found = margins(read_graph(library_file(f"{name}.toml")), loop, at=at)
    assert found.gain_crossovers[0] == pytest.approx(crossover, rel=0.01)
    assert found.bandwidth == pytest.approx(wide, rel=0.01)
    assert math.degrees(found.phase_margin) == pytest.approx(margin, abs=0.5)


def test_the_loop_of_the_fluxgate() -> None:
    """g / (z (z - 1)): an integrator that answers a period of 100 us late."""
    found = margins(read_graph(library_file("closed_loop_fluxgate.toml")), "field", at="9 ms")
    gain = 2.0 * math.sin(math.pi * 1e-4 * found.gain_crossovers[0])
    _, wide, margin = figures(lambda z: gain / (z * (z - 1.0)), 1e-4, 100.0, 4000.0)
    assert math.degrees(found.phase_margin) == pytest.approx(margin, abs=0.1)
    assert found.bandwidth == pytest.approx(wide, rel=0.01)
    assert found.gain_margin == pytest.approx(1.0 / gain, rel=0.01)


@pytest.mark.exhaustive
def test_the_loop_of_the_seismometer() -> None:
    """Plant, notch and controller by SciPy; the slow integral without the images of its ticks."""
    period, rate = 1.0 / 2000.0, 2000.0
    notch = signal.iirnotch(560.0, 1.2, rate)
    decay = math.exp(-2.0 * math.pi * 400.0 * period)
    modes = []
    for mass, frequency, damping in ((0.1, 2.0, 0.025), (0.5, 600.0, 0.5 * 2.0 * math.pi * 600.0 / 500.0)):
        w = 2.0 * math.pi * frequency
        numerator, denominator, _ = signal.cont2discrete(([1.0 / mass], [1.0, damping / mass, w * w]), period)
        modes.append((numerator[0], denominator))

    def loop(z: complex) -> complex:
        position = sum(np.polyval(top, z) / np.polyval(low, z) for top, low in modes)
        filtered = np.polyval(notch[0], z) / np.polyval(notch[1], z)
        derivative = 2.36e-3 * rate * (1.0 - decay) * (z - 1.0) / (z - decay)
        window = sum(z**-i for i in range(20)) / 20.0
        slow = 0.014 / (z**20 - 1.0) * window * window / z
        return complex(1e4 * position * filtered * (0.2216 + derivative + slow))

    crossover, wide, margin = figures(loop, period, 20.0, 300.0)
    found = margins(read_graph(library_file("force_balance_seismometer.toml")), "balance")
    assert found.gain_crossovers[0] == pytest.approx(crossover, rel=0.01)
    assert found.bandwidth == pytest.approx(wide, rel=0.01)
    assert math.degrees(found.phase_margin) == pytest.approx(margin, abs=0.5)


def referred(name: str, output: str, input: str, at: str, frequency: float) -> dict[str, float]:
    """Densities of the sources of noise of a sensor, referred to what it measures."""
    budget = noise(read_graph(library_file(f"{name}.toml")), output, input=input, at=at, frequencies=[frequency])
    found: dict[str, float] = {}
    for source in budget.sources:
        key = f"{source.block} quantisation" if source.kind == "quantisation" else source.block
        found[key] = math.sqrt(source.density[0]) / abs(budget.gain[0])
    return found


@pytest.mark.exhaustive
def test_noise_of_the_open_loop_gyroscope() -> None:
    """Gas: Leland's sqrt(8 k T c) / (2 m w A). Amplifier: both sidebands, over the motion that a rate makes."""
    found = referred("open_loop_gyroscope", "output.output", "rotation.output", "0.15 s", 0.1)
    wd, ws, mass, motion = 2.0 * math.pi * 8000.0, 2.0 * math.pi * 8200.0, 50e-9, 1e-6
    gas = math.sqrt(8.0 * 1.380649e-23 * 300.0 * mass * ws / 1000.0) / (2.0 * mass * wd * motion)
    volts = 100e6 * 2.0 * wd * motion / (ws * ws - wd * wd)  # a rad/s
    assert found["gas"] == pytest.approx(gas, rel=0.01)
    assert found["amplifier"] == pytest.approx(math.sqrt(2.0) * 2e-6 / volts, rel=0.01)


@pytest.mark.exhaustive
@pytest.mark.parametrize("frequency", [0.1, 10.0])
def test_noise_of_the_seismometer(frequency: float) -> None:
    """Brownian force, the amplifier over the motion of the free mass, and the steps of the converter of the coil."""
    found = referred("force_balance_seismometer", "output.output", "ground.output", "0 s", frequency)
    w, w0 = 2.0 * math.pi * frequency, 2.0 * math.pi * 2.0
    free = abs(w0 * w0 - w * w + 1j * w * 0.025 / 0.1)
    step = 5.0 / 2.0**23 / 0.1
    assert found["gas"] == pytest.approx(math.sqrt(4.0 * 1.380649e-23 * 300.0 * 0.025) / 0.1, rel=0.01)
    assert found["amplifier"] == pytest.approx(1e-7 / 1e4 * free, rel=0.01)
    assert found["dac quantisation"] == pytest.approx(step / math.sqrt(12.0 * 1000.0), rel=0.01)
