"""The magnetic encoder of the gallery: a program of its own, bit by bit, and closed forms of its errors.

Units are turns and volts. Bridges follow from vectors of their layers, the observer is written in plain integers.
"""

import functools
import math
from typing import Any

import numpy as np
import pytest
import scipy.linalg

from proofmass import margins, noise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.graph import Graph
from proofmass.runner.run.simulate import simulate
from tests.blocks.registers.test_fixed_cordic_angle import by_hand as angle_by_hand

GRAPH = read_graph(library_file("magnetic_encoder.toml"))
T = 2e-5  # of the converters
KP, KI = 4.0 * math.pi * 0.8 * 500.0, (2.0 * math.pi * 500.0) ** 2
LEFT = math.exp(-2e-6 / (3e3 * 100e-12))
CHANNELS = ("cosine", "sine")
NONE = {"ratio": 0.4, "imbalance": 0.0, "bridge_noise": 0.0, "white": 0.0, "amplifier.flicker.level": 0.0}
QUIET = {f"{c}.{key}": 0.0 for c in CHANNELS for key in ("bridge_noise", "white", "amplifier.flicker.level")}
IDEAL = {f"{c}.{key}": value for c in CHANNELS for key, value in NONE.items()} | {
    "orthogonality": 0.0,
    **{f"{c}.reference_field": 1e9 for c in CHANNELS},
}


def steady(speed: float, changes: dict[str, Any], acceleration: float = 0.0) -> Graph:
    """The encoder at a speed from the start, and with an acceleration."""
    motion = {"start.offset": speed, "start.start_time": 0.0, "steady.start_time": 1e6, "acceleration": acceleration}
    return GRAPH.with_parameters(motion | changes)


def bridge(angle: np.ndarray, direction: float, ratio: float, imbalance: float) -> np.ndarray:
    """Diagonal voltage at 3.3 V, of a magnet of 30 mT: references point along the sum of two vectors."""
    magnet = np.exp(1j * angle)
    ways = [sign * 0.6 * np.exp(1j * direction) + 0.03 * magnet for sign in (1.0, -1.0)]
    first, second = (1.0 + ratio * np.real(magnet * np.conj(way / np.abs(way))) for way in ways)
    return 3.3 * ((first - second) / (first + second) + imbalance)


def words(voltage: np.ndarray) -> list[int]:
    """Words of the converter in sixteenths: mean over 8 samples, what the capacitor keeps, 12 bits to 2.5 V."""
    means = np.concatenate([[0.0], 1.5 * voltage.reshape(-1, 8).mean(axis=1)])
    held, kept = 0.0, []
    for mean in means:
        held = (1.0 - LEFT) * mean + LEFT * held
        kept.append(16 * min(max(round(held / 2.5 * 2048.0), -2048), 2047))
    return kept


def rounded(value: int, bits: int) -> int:
    """value / 2^bits to the nearest, ties to even."""
    low, rest = value >> bits, value & ((1 << bits) - 1)
    half = 1 << (bits - 1)
    return low + (rest > half or (rest == half and low & 1))


def wrapped(value: int, bits: int) -> int:
    return (value + (1 << (bits - 1))) % (1 << bits) - (1 << (bits - 1))


@functools.cache
def cordic(real: int, imaginary: int) -> int:
    return angle_by_hand(real, imaginary, 20, 18, 12)


def observed(angles: list[int]) -> list[int]:
    """Angles of 20 bits behind the observer: speeds have 16 bits below the point, the sums 24 and 36."""
    kp, ki, step, ahead = round(KP * 2**8), round(KI * T * 2**12), round(T * 2**38), round(11.275e-6 * 2**36)
    total = speed_sum = 0
    out = []
    for angle in angles:
        estimate, speed = wrapped(rounded(total, 16), 20), rounded(speed_sum, 8)
        error = wrapped(angle - estimate, 20)
        out.append(wrapped(estimate + wrapped(rounded(speed * ahead, 32), 20), 20))
        command = rounded(kp * error, 12) + speed
        speed_sum += rounded(ki * error, 8)
        total = wrapped(rounded((total << 18) + step * command, 18), 36)
    return out


@pytest.mark.exhaustive
def test_bit_by_bit() -> None:
    samples = 2_000
    result = simulate(GRAPH.with_parameters(QUIET), samples=8 * (samples - 1) + 1, engine="compiled")
    t = np.arange(8 * (samples - 1)) / 400e3
    after = np.clip(t - 0.03, 0.0, 0.02)
    turns = 0.1 + 2500.0 * (0.5 * after**2 + after * np.clip(t - 0.05, 0.0, None))
    angle = 2.0 * math.pi * turns
    pairs = zip(
        words(bridge(angle, 0.0, 0.4, 1e-3)),
        words(bridge(angle, math.pi / 2.0 - math.radians(0.3), 0.402, -5e-4)),
        strict=True,
    )
    angles = [cordic(*pair) for pair in pairs]
    assert result["cordic.angle"].mantissas.tolist() == angles
    assert result["observer.angle"].mantissas.tolist() == observed(angles)


def closed_loop(frequency: float) -> complex:
    """Angle per angle of CORDIC: (Kp + Ki T / (z - 1)) T / (z - 1), and the way ahead by the speed."""
    d = np.exp(2j * math.pi * frequency * T) - 1.0
    loop = (KP + KI * T / d) * T / d
    return (loop + 11.275e-6 * KI * T / d) / (1.0 + loop)


@pytest.mark.exhaustive("150")
@pytest.mark.parametrize("speed", [50.0, 150.0])
def test_harmonics(speed: float) -> None:
    """Offsets o, amplitudes 1 + a, phase f, third harmonic h: errors -o sin, a / 2 sin 2, f cos^2, -h sin 4.

    The first, second and fourth harmonic go through the observer as any angle of their frequencies does.
    """
    result = simulate(steady(speed, QUIET | {"turns_per_second": speed}), engine="compiled")
    found = {name: math.degrees(result.measures[name].value) for name in ("first", "second", "fourth", "mean")}
    phase, pull = math.radians(0.3), 0.03 / 0.6
    h = (0.4 * pull + 1.5 * pull**2) / 4.0
    amplitude = 1.0 - 3.0 * h  # of the fundamental, less than that of a cosine
    ratio = 0.4 * amplitude
    first = math.hypot(1e-3, -5e-4) / ratio
    second = 0.5 * math.hypot(0.402 / 0.4 - 1.0, phase)
    for name, size, times in (("first", first, 1), ("second", second, 2), ("fourth", h, 4)):
        expected = math.degrees(size) * abs(closed_loop(times * speed))
        assert found[name] == pytest.approx(expected, rel=0.03), name
    assert found["mean"] == pytest.approx(math.degrees(phase / 2.0), abs=0.003)
    assert result.measures["speed"].value == pytest.approx(speed, rel=1e-4)


@pytest.mark.parametrize("acceleration", [1000.0, 4000.0])
def test_lag_under_acceleration(acceleration: float) -> None:
    """The speed grows by Ki T e a tick: e = acceleration / Ki, and none at a constant speed."""
    result = simulate(steady(10.0, IDEAL, acceleration), engine="compiled")
    lag = result["lag.output"].values[2000:].mean() / (2.0 * math.pi)
    assert lag == pytest.approx(acceleration / KI, rel=0.01)


def test_latency() -> None:
    """Without the way ahead: 4.5 samples of 2.5 us of the mean, and LEFT / (1 - LEFT) samples of the capacitor."""
    late = []
    for speed in (50.0, 250.0):
        graph = steady(speed, IDEAL | {"latency": 0.0, "turns_per_second": speed})
        error = simulate(graph, engine="compiled")["error.output"].values
        late.append(error[3000:4000].mean() / (2.0 * math.pi))
    seconds = -(late[1] - late[0]) / 200.0
    assert seconds == pytest.approx(4.5 * 2.5e-6 + T * LEFT / (1.0 - LEFT), abs=5e-8)


@pytest.mark.exhaustive
def test_margins() -> None:
    loop = margins(GRAPH)
    grid = np.geomspace(100.0, 24e3, 200_001)
    d = np.exp(2j * math.pi * grid * T) - 1.0
    response = (KP + KI * T / d) * T / d
    crossing = int(np.argmin(np.abs(np.abs(response) - 1.0)))
    assert loop.phase_margin == pytest.approx(math.pi + np.angle(response[crossing]), abs=2e-4)
    at_half = (KP * T - KI * T * T / 2.0) / 2.0  # where z = -1 the loop is negative
    assert loop.gain_margin == pytest.approx(1.0 / at_half, rel=1e-4)


@pytest.mark.exhaustive
def test_noise_budget() -> None:
    """White noise of amplifiers at rest: covariance of capacitor, observer and way ahead, by Lyapunov's equation."""
    budget = noise(GRAPH, "error.output", at="10 ms")
    found = sum(source.rms**2 for source in budget.sources if source.block.endswith("amplifier.white"))
    rest = np.array([0.2 * math.pi])
    sides = bridge(rest, 0.0, 0.4, 1e-3), bridge(rest, math.pi / 2.0 - math.radians(0.3), 0.402, -5e-4)
    length = math.hypot(*(float(side[0]) for side in sides))
    sample = 50e-9**2 * 200e3 / 8.0 / length**2  # of the mean, in rad^2
    step = np.array([[LEFT, 0.0, 0.0], [KP * T * LEFT, 1.0 - KP * T, T], [KI * T * LEFT, -KI * T, 1.0]])
    entry = np.array([[1.0 - LEFT], [KP * T * (1.0 - LEFT)], [KI * T * (1.0 - LEFT)]])
    covariance = scipy.linalg.solve_discrete_lyapunov(step, sample * entry @ entry.T)
    read = np.array([0.0, 1.0, 11.275e-6])
    assert math.sqrt(found) == pytest.approx(math.sqrt(read @ covariance @ read), rel=0.01)
