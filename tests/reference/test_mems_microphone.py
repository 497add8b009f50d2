"""The MEMS microphone of the gallery: bits and samples of an independent program, noise and harmonics in closed form.

Boltzmann's constant and the permittivity of the vacuum are CODATA's. The acoustic model is that of a piston in front of
a closed volume with a leak: pressure in the volume C p' = A v + (outside - p) / R, C = V / (1.4 x 101325 Pa).
"""

import math
from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg
from scipy import signal

from proofmass import design_modulator, noise, read_graph, simulate
from proofmass.graphs.model.graph import Probe

GRAPH = read_graph("library:mems_microphone")
SILENT = GRAPH.with_parameters({"sound.amplitude": 0.0})
QUIET = {"gas.temperature": 0.0, "vent_noise.density": 0.0, "amplifier_noise.density": 0.0}
CLOCK, TICKS = 3.072e6, 16_000
AREA, MASS, DAMPING, GAP, BIAS, VOLUME, BULK = 0.7e-6, 2e-9, 3.6e-4, 2.2e-6, 8.0, 2e-9, 1.4 * 101325.0
CAPACITANCE = 8.8541878128e-12 * AREA / GAP
SHUNTED = 1e-12 / (1e-12 + CAPACITANCE)
STIFFNESS = 60.0 - CAPACITANCE * SHUNTED * BIAS**2 / GAP**2
LEAK = BULK / (VOLUME * 2.0 * math.pi * 20.0)
COMPLIANCE = VOLUME / BULK
PER_PASCAL = AREA / (STIFFNESS + AREA**2 / COMPLIANCE)  # displacement
SENSITIVITY = BIAS * (1.0 - SHUNTED) * PER_PASCAL / GAP
A, C, G = (1.29164, 0.745086, 0.978356), (0.584742, 0.717084, 0.154377), 0.00650348
RATES = np.array([[0.0, 0, 0, C[0], -C[0]], [C[1], 0, -G, 0, 0], [0, C[2], 0, 0, 0], [0] * 5, [0] * 5])


def bits(amplitude: float) -> np.ndarray:
    """Return the levels for a tone of 1 kHz, by exact steps of the acoustics and of the loop filter."""
    a = np.array([[0.0, 1.0, 0.0], [-STIFFNESS / MASS, -DAMPING / MASS, -AREA / MASS], [0.0, AREA, -1.0 / LEAK]])
    a[2] /= COMPLIANCE
    entry = np.array([0.0, AREA / MASS, 1.0 / (LEAK * COMPLIANCE)])
    joined = np.zeros((4, 4))
    joined[:3] = np.column_stack([a, entry])
    acoustic, electric = scipy.linalg.expm(joined / CLOCK)[:3], scipy.linalg.expm(RATES)[:3]
    x, s, out = np.zeros(3), np.zeros(3), []
    for n in range(TICKS):
        part = x[0] / GAP
        voltage = BIAS * (1.0 - SHUNTED) * part / (1.0 - SHUNTED * part)
        level = 1.0 if s @ A >= 0.0 else -1.0
        s = electric @ [*s, voltage / 1.1, level]
        x = acoustic @ [*x, amplitude * math.sin(2.0 * math.pi * 1000.0 * n / CLOCK)]
        out.append(level)
    return np.array(out)


def measured(level: float) -> dict[str, float]:
    """Return the measures of a run at a level in dB SPL."""
    result = simulate(GRAPH.with_parameters({"level": level}))
    return {name: float(measure.value) for name, measure in result.measures.items()}


@pytest.mark.exhaustive
def test_bits_and_samples() -> None:
    """A microphone without noise at 94 dB SPL, 1 Pa rms within 0.24 %."""
    quiet = replace(GRAPH.with_parameters(QUIET), probes=(Probe("converter.sign"), Probe("output.output")))
    result = simulate(quiet, samples=TICKS)
    expected = bits(math.sqrt(2.0) * 20e-6 * 10.0 ** (94.0 / 20.0))
    assert (result["converter.sign"].values == expected).all()
    comb = np.ones(16)
    for _ in range(3):
        comb = np.convolve(comb, np.ones(16))
    slow = np.concatenate([[0.0], np.convolve(expected, comb / 16.0**4)])[:TICKS:16]
    taps = signal.firwin(160, 0.23, window=("kaiser", 8.0))
    filtered = np.concatenate([[0.0], np.convolve(slow, taps)])[: len(slow) : 4]
    assert result["output.output"].values == pytest.approx(1.1 / SENSITIVITY * filtered, abs=1e-9)


def test_the_converter_is_the_designed_one() -> None:
    """The analog filter of the part answers a decision as the designed discrete loop does (impulse invariance)."""
    design = design_modulator(3, 76.8, gain=1.6, form="CRFF", swing=None, samples=4096)
    step = scipy.linalg.expm(RATES)[:3]
    x, seen = step[:, 4], []
    for _ in range(30):
        seen.append(x @ A)
        x = step[:, :3] @ x
    assert seen == pytest.approx(design.transfer.loop_response(30), rel=1e-4)


@pytest.mark.exhaustive
def test_noise_of_gas_vent_and_amplifier() -> None:
    """The spectrum of silence from 100 Hz to 5 kHz, where next to nothing of it is the quantiser's."""
    values = np.asarray(simulate(SILENT)["output.output"].values)[3840:]
    window = signal.windows.hann(len(values), sym=False)
    lines = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2 * 2.0 / (48e3 * np.sum(window**2))
    f = np.fft.rfftfreq(len(values), 1.0 / 48e3)
    inside = (f >= 100.0) & (f <= 5000.0)
    s = 2j * math.pi * f[inside]
    chamber = 1.0 / (COMPLIANCE * s + 1.0 / LEAK)  # pressure by volume flow
    motion = 1.0 / (MASS * s**2 + DAMPING * s + STIFFNESS + AREA**2 * s * chamber)  # displacement by force
    kelvin = 4.0 * 1.380649e-23 * 300.0
    by_force = np.abs(motion) ** 2 * kelvin * DAMPING
    by_vent = np.abs(motion * AREA * chamber) ** 2 * kelvin / LEAK
    expected = (by_force + by_vent) / PER_PASCAL**2 + (20e-9 / SENSITIVITY) ** 2
    assert np.mean(lines[inside]) == pytest.approx(np.mean(expected), rel=0.12)
    assert math.sqrt(np.mean(expected)) == pytest.approx(4.4e-6, rel=0.2)  # Pa/sqrt(Hz): some 30 dB SPL in all


@pytest.mark.exhaustive(but=1)
@pytest.mark.parametrize("level", [114, 120])
def test_harmonics_are_those_of_the_parasitic_capacitance(level: int) -> None:
    """y / (1 - b y) has a second harmonic of b / 2 times the peak of y."""
    pascals = math.sqrt(2.0) * 20e-6 * 10.0 ** (level / 20.0)
    measures = measured(level)
    motion = pascals * PER_PASCAL / GAP
    assert measures["tone"] == pytest.approx(pascals, rel=0.01)
    assert measures["distortion"] == pytest.approx(100.0 * SHUNTED * motion / 2.0, rel=0.03)


@pytest.mark.exhaustive
def test_signal_to_noise_and_overload() -> None:
    """62 dB at 94 dB SPL, a working loop at 121 dB SPL, and a lost one at 123."""
    ratio, swing = (dict[int, float]() for _ in range(2))
    for level in (94, 121, 123):
        measures = measured(level)
        ratio[level], swing[level] = measures["ratio"], measures["swing"]
    assert ratio[94] == pytest.approx(62.4, abs=1.0)
    assert ratio[121] > 85.0
    assert swing[121] < 6.0
    assert swing[123] > 20.0


def spectrum_of_silence(changes: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return frequencies, and the mean square of a tone in each line, of a second of silence."""
    values = np.asarray(simulate(SILENT.with_parameters(changes), duration="1.1 s")["output.output"].values)[4800:]
    window = signal.windows.blackmanharris(len(values), sym=False)
    lines = np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2 * 2.0 / np.sum(window) ** 2
    return np.fft.rfftfreq(len(values), 1.0 / 48e3), lines


@pytest.mark.exhaustive
def test_idle_tones() -> None:
    """A mean level of u comes as a pattern that repeats u times the clock a second; noise of the mass breaks it."""
    apart = 1e-3 / 1.1 * CLOCK
    tones = apart * np.arange(1, 5)
    f, quiet = spectrum_of_silence({**QUIET, "offset.value": 1e-3})
    strongest = f[np.argsort(quiet * (f > 20.0) * (f < 20e3))[-4:]]
    assert {int(np.argmin(np.abs(tones - found))) for found in strongest} <= {1, 2, 3}
    assert np.min(np.abs(strongest[:, None] - tones), axis=1).max() < 2.0
    assert math.sqrt(np.max(quiet[f > 20.0])) == pytest.approx(0.17e-3, rel=0.05)
    f, noisy = spectrum_of_silence({"offset.value": 1e-3})
    near = np.abs(f - strongest[-1]) < 150.0
    assert math.sqrt(np.max(noisy[near])) < 0.3 * math.sqrt(np.max(quiet[near]))
    assert np.max(spectrum_of_silence(QUIET)[1]) == 0.0


@pytest.mark.exhaustive
def test_budget_of_silence() -> None:
    """From 20 Hz to 20 kHz, as a run of silence has it; a tone of 94 dB SPL makes the bit's part a little larger."""
    f, lines = spectrum_of_silence({})
    window = signal.windows.blackmanharris(2 * (len(f) - 1), sym=False)
    inside = (f >= 20.0) & (f <= 20e3)
    power = np.sum(lines[inside]) * np.sum(window) ** 2 / np.sum(window**2) / len(window)
    assert noise(GRAPH, "output.output", band=(20.0, 20e3)).rms == pytest.approx(math.sqrt(power), rel=0.06)
