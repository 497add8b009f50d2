"""The Michelson accelerometer of the gallery: a program of its own, bit by bit, closed forms of ellipse and noise.

Densities are one-sided, amplitudes are peaks, angles are radians unless a name says turns. Constants are CODATA's.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from scipy import constants as si

from proofmass import noise, read_graph, simulate
from proofmass.graphs.files.library import library_file
from proofmass.graphs.model.graph import Probe
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.studies.outcome.result import StudyResult
from proofmass.runner.studies.whole.study import run_study
from tests.blocks.registers.test_fixed_cordic_angle import by_hand as angle_by_hand

GRAPH = read_graph("library:michelson_accelerometer")
QUIET: dict[str, object] = {
    **dict.fromkeys(("laser.linewidth", "laser.flicker", "laser.intensity_noise", "element.temperature"), 0.0),
    **{f"interferometer.{side}.temperature": 0.0 for side in ("cosine", "sine")},
    **{f"interferometer.{side}.noisy": False for side in ("cosine", "sine")},
}
RATE, WAVELENGTH, MASS, RESONANCE = 20_000, 1550e-9, 1e-3, 2.0 * math.pi * 300.0
HALF = 0.5e-3  # W on each detector where the waves are in phase
VOLTS = 0.9 * 4000.0  # a watt
PER_TURN = WAVELENGTH / 2.0 * RESONANCE**2  # m/s^2 at rest
AMPLIFIED = 1.0 - (5.0 / 300.0) ** 2  # of 5 Hz, the inverse


NAMES = ("stiffness.nominal", "wavelength", "thermometer.reference_voltage")
ELLIPSE = ("retardance = {", '"interferometer.sine_visibility" = {')


def lot(path: Path) -> StudyResult:
    return run_study(read_study(path), runs=12)


def even(value: int, bits: int) -> int:
    """value / 2^bits to the nearest, ties to even."""
    low, rest = value >> bits, value & ((1 << bits) - 1)
    half = 1 << (bits - 1)
    return low + (rest > half or (rest == half and low & 1))


def plant(stiffness: float) -> np.ndarray:
    """Displacement and velocity after a tick, by both and a held force."""
    damping = RESONANCE * MASS / 30.0
    joined = np.zeros((3, 3))
    joined[0, 1] = 1.0
    joined[1] = -stiffness / MASS, -damping / MASS, 1.0 / MASS
    return scipy.linalg.expm(joined / RATE)[:2]


def turns(samples: int) -> list[int]:
    """Count of 24 bits below the point: fringes, receivers, converters of 18 bits, a circle of the ellipse, CORDIC."""
    step = plant(MASS * RESONANCE**2)
    kept = math.exp(-2.0 * math.pi * 8e3 / RATE)
    x, volts, total, found = np.zeros(2), [0.0, 0.0], 0, []
    offset, gain, cross = 4 * 58982.75, round(1.02166 * 2**18), round(0.0174551 * 2**18)
    for n in range(samples):
        words = [4 * min(round(v / 2.0 * 2**17), 2**17 - 1) - int(offset) for v in volts]
        circle = even(gain * words[1], 18) + even(cross * words[0], 18)
        angle = angle_by_hand(words[0], circle, 24, 24, 12)
        found.append(total)
        total += (angle - total + 2**23) % 2**24 - 2**23
        phase = 4.0 * math.pi / WAVELENGTH * x[0]
        powers = (
            0.5 * HALF * (1.0 + 0.95 * math.cos(phase)),
            0.5 * HALF * (1.0 + 0.93 * math.sin(phase - math.radians(1.0))),
        )
        volts = [kept * v + (1.0 - kept) * (VOLTS * p + 4000.0 * 1e-9) for v, p in zip(volts, powers, strict=True)]
        tilt = 2.0 * math.pi * 5.0 * max(n / RATE - 0.01, 0.0)
        x = step @ [*x, MASS * 9.80665 * math.sin(tilt)]
    return found


@pytest.mark.parametrize("samples", [1_300, pytest.param(10_000, marks=pytest.mark.exhaustive)])
def test_bit_by_bit(samples: int) -> None:
    """Three and a half turns, counted from registers that start at zero."""
    quiet = replace(GRAPH.with_parameters({**QUIET, "tilt.start_time": 0.01}), probes=(Probe("counter.turns"),))
    found = simulate(quiet, samples=samples, engine="compiled")["counter.turns"].mantissas.tolist()
    assert found == turns(samples)
    assert max(found) > 3 * 2**24


@pytest.mark.exhaustive
def test_scale_and_temperature() -> None:
    """Half a wavelength a turn; 10 K above, the flexure is compensated and 20 ppm of the wavelength are left."""
    measures = simulate(GRAPH.with_parameters(QUIET)).measures
    assert measures["scale_error"].value == pytest.approx(2.752855 / (PER_TURN * AMPLIFIED) - 1.0, abs=2e-6)
    assert measures["warm_error"].value == pytest.approx(-20e-6, abs=2e-6)
    assert measures["gain"].value == pytest.approx(0.95 / 0.93 / math.cos(math.radians(1.0)), rel=1e-4)
    assert measures["cross"].value == pytest.approx(math.tan(math.radians(1.0)), rel=2e-3)
    assert measures["sine_centre"].value == pytest.approx((0.5 * HALF * VOLTS + 4e-6) * 2**16, abs=1.0)


@pytest.mark.exhaustive
def test_an_ellipse_that_is_left() -> None:
    """Amplitudes apart by a and a right angle off by e make sqrt(a^2 + e^2) / 2 of the second harmonic of a turn."""
    graph = GRAPH.with_parameters({**QUIET, "counter.gain": 1.0, "counter.cross": 0.0})
    ripple = simulate(graph).measures["ripple"].value
    harmonic = math.hypot(0.95 / 0.93 - 1.0, math.radians(1.0)) / 2.0
    assert ripple == pytest.approx(harmonic / (2.0 * math.pi) * PER_TURN / math.sqrt(2.0), rel=0.05)
    corrected = simulate(GRAPH.with_parameters(QUIET)).measures["ripple"].value
    assert corrected < 0.02 * ripple


@pytest.mark.exhaustive
def test_noise_budget() -> None:
    """At rest and 20 Hz: gas sqrt(4 k T w0 / (m Q)); light and laser as phases over 2 pi, PER_TURN each."""
    budget = noise(GRAPH, "acceleration.output", at="10 ms", frequencies=[20.0])
    found = {f"{s.block} {s.kind}": math.sqrt(s.density[0]) for s in budget.sources}
    gas = math.sqrt(4.0 * si.k * 300.0 * RESONANCE / (MASS * 30.0))
    per_radian = 2.752855 / (2.0 * math.pi)
    level, swing = 0.5 * HALF * VOLTS, 0.5 * HALF * VOLTS * 0.93  # V; the sine is in the middle, the cosine on top
    tangent = math.tan(math.radians(1.0))
    arms = 4.0 * math.pi * 1e-3 / si.c  # rad/Hz
    bright = level * (1.0 - 0.93 * math.sin(math.radians(1.0)))
    intensity = math.sqrt(1e-15) * (bright + tangent * 0.93 / 0.95 * level * 1.95)  # with what the circle adds of it
    current = bright / 4000.0 + 1e-9
    expected = {
        "element.brownian BrownianForce": gas / (1.0 - (20.0 / 300.0) ** 2) * 2.752855 / PER_TURN,
        "laser.white WhiteNoise": arms * math.sqrt(1e5 / math.pi) * per_radian,
        "laser.flicker FlickerNoise": arms * 1e4 / math.sqrt(20.0) * per_radian,
        "laser.intensity WhiteNoise": intensity / swing * per_radian,
        "interferometer.sine.diode Photodetector": math.sqrt(2.0 * si.e * current) * 4000.0 / swing * per_radian,
        "interferometer.sine.resistor WhiteNoise": math.sqrt(4.0 * si.k * 300.0 * 4000.0) / swing * per_radian,
        "sine_converter quantisation": 2.0**-16 / math.sqrt(12.0 * RATE / 2.0) / swing * per_radian,
    }
    for name, value in expected.items():
        assert found[name] == pytest.approx(value, rel=0.02), name
    assert gas == pytest.approx(3.3e-9 * 9.80665, rel=0.01)


def moved(frequency: float, **changes: float) -> tuple[float, float]:
    """Displacement by an acceleration, and the acceleration that the gas is like, of another mass."""
    graph = GRAPH.with_parameters(
        {**changes, "stiffness.nominal": changes["element.mass"] * (2.0 * math.pi * changes["resonance"]) ** 2}
    )
    budget = noise(graph, "element.displacement", input="gravity.output", at="10 ms", frequencies=[frequency])
    gas = next(source for source in budget.sources if source.block == "element.brownian")
    return abs(budget.gain[0]), math.sqrt(gas.density[0]) / abs(budget.gain[0])


@pytest.mark.exhaustive
def test_published_figures() -> None:
    """Figures that follow from what authors state, through the mass of the library.

    Guzman Cervantes and others, Appl. Phys. Lett. 104, 221111 (2014): 200 am/sqrt(Hz) are 100 ng/sqrt(Hz) for a
    bandwidth of 10 kHz; its preprint, arXiv 1303.1188v1: a mass times its quality of 5 kg makes nano-g/sqrt(Hz).
    Hines and others, Remote Sensing 14, 4389 (2022): 2.6 g, 4.715 Hz and a quality of 4.76e5 make some
    5e-11 m/s^2/sqrt(Hz) at 1 Hz. The loss of glass is the same at all frequencies, so its damping at 1 Hz is 4.715
    times that at resonance.
    """
    metres, gas = moved(100.0, **{"resonance": 10e3, "element.mass": 25e-6, "element.quality": 2e5})
    assert 100e-9 * 9.80665 * metres == pytest.approx(200e-18, rel=0.25)
    assert 1e-9 < gas / 9.80665 < 2e-9
    _, slow = moved(1.0, **{"resonance": 4.715, "element.mass": 2.6e-3, "element.quality": 4.76e5 / 4.715})
    assert slow == pytest.approx(5e-11, rel=0.2)


@pytest.mark.exhaustive
def test_a_year_with_and_without_calibrations(tmp_path: Path) -> None:
    """Of ellipses that stay as they are: stiffness, wavelength and thermometer since the last calibration."""
    lines = library_file("michelson_accelerometer.toml").read_text("utf-8").splitlines()
    path = tmp_path / "same_ellipse.toml"
    path.write_text("\n".join(line for line in lines if not line.startswith(ELLIPSE)), "utf-8")
    result = lot(path)
    drawn = [result.study.drawn(run) for run in result.numbers.tolist()]
    left = []
    for place, calibrated in ((0, [0] * 13), (1, [0, *range(12)])):
        part = slice(place, None, 2)
        stiffness, wavelength, volts = (np.array([[at[name] for at in run] for run in drawn])[part] for name in NAMES)
        for epoch, last in enumerate(calibrated[1:], start=1):
            moved = stiffness[:, last] * wavelength[:, last] / (stiffness[:, epoch] * wavelength[:, epoch])
            expected = moved * (1.0 + 190e-6 * 100.0 * (volts[:, epoch] - volts[:, last])) - 1.0
            assert result["scale_error"][part, epoch] == pytest.approx(expected, abs=1e-6), (place, epoch)
        left.append(float(np.std(result["scale_error"][part, 12])))
    assert left[1] < 0.2 * left[0]


@pytest.mark.exhaustive
def test_calibrations_make_circles() -> None:
    """Never calibrated again, ellipses of a year bend the reading; calibrated each month they do a quarter of that."""
    result = lot(library_file("michelson_accelerometer.toml"))
    never, monthly = (result["ripple"][place::2, 12] for place in range(2))
    assert np.mean(monthly) < 0.4 * np.mean(never)
