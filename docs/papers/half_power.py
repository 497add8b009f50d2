"""Damping by the half-power method beside that by pseudorandom sequences, on one simulated sensor.

    python -m docs.papers.half_power

Sarraf et al. 2012 take stiffness and damping of their devices from swept responses (section 3.3, Fig. 4):
k = m (2 pi f0)^2 at the peak f0, and from the width Df between half the power Df / f0 = 1 / Q, which is a damping of
2 pi m Df.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from docs.papers.pn_runs import ACCELEROMETER, CHIPS, GYROSCOPE, IDEAL, Device, calibrate, library
from proofmass.runner.run.simulate import simulate

QUIET = {"amplifier.density": 0.0, "adc.bits": 32, "volts.gain": 10.0 / 2**31}  # no noise, no visible rounding
SWEEP = np.arange(8256.0, 8677.0, 15.0)  # Hz, 1.8 half-power widths
FINE = np.arange(8256.0, 8677.0, 5.0)
STRETCH = 1200  # samples at 100 kHz: 12 ms to settle, 12 ms for each amplitude
WIDE = np.geomspace(100.0, 10e3, 41)  # of the accelerometer
OF_ACCELEROMETER = {  # the same sweep on the other device, with 1 V of its comb
    "mass": ACCELEROMETER.mass,
    "stiffness": ACCELEROMETER.stiffness,
    "damping": ACCELEROMETER.damping,
    "readout.gain": ACCELEROMETER.readout,
    "comb.bias": 20.0,
    "signal.amplitude": 1.694,
}


class Estimate(NamedTuple):
    """What a swept response says of a device."""

    stiffness: float
    damping: float


def amplitudes(frequencies: Any, sweeps: int = 1, changes: Mapping[str, object] | None = None) -> Any:
    """Amplitudes over the frequencies, one row a sweep: least squares over stretches of 12 ms, one after the other."""
    graph, columns = library("half_power_sweep.toml").with_parameters(changes or {}), []
    for number, frequency in enumerate(map(float, frequencies)):
        there = graph.with_parameters({"frequency": frequency})
        trace = simulate(there, samples=STRETCH * (sweeps + 1), seed=number, engine="compiled")["volts.output"]
        angles = 2.0 * np.pi * frequency * trace.times[:STRETCH]
        waves = np.stack([np.sin(angles), np.cos(angles), np.ones(STRETCH)], axis=1)
        parts = np.linalg.lstsq(waves, trace.values.reshape(sweeps + 1, STRETCH).T)[0]
        columns.append(np.hypot(parts[0, 1:], parts[1, 1:]))
    return np.stack(columns, axis=1)


def half_power(frequencies: Any, response: Any, mass: float) -> Estimate:
    """Stiffness and damping from the peak, a parabola's, and both frequencies of half the power, interpolated.

    Raises `ValueError` where the response has no peak, or does not fall to half the power on both sides.
    """
    top = int(np.argmax(response))
    if not 0 < top < len(response) - 1:
        raise ValueError("no peak within the sweep")
    a, b, c = np.polyfit(frequencies[top - 1 : top + 2] - frequencies[top], response[top - 1 : top + 2], 2)
    peak, level = frequencies[top] - b / (2.0 * a), (c - b * b / (4.0 * a)) / np.sqrt(2.0)
    above = np.flatnonzero(response > level)
    first, last = above[0], above[-1]
    if first == 0 or last == len(response) - 1:
        raise ValueError("half the power is not reached on both sides")
    low = np.interp(level, response[first - 1 : first + 1], frequencies[first - 1 : first + 1])
    high = np.interp(-level, -response[last : last + 2], frequencies[last : last + 2])
    return Estimate(mass * (2.0 * np.pi * peak) ** 2, 2.0 * np.pi * mass * (high - low))


def errors(frequencies: Any, sweeps: int, changes: Mapping[str, object] | None = None) -> tuple[Estimate, Estimate]:
    """Mean and standard deviation of the relative errors, of the gyroscope's sense mode."""
    rows = amplitudes(frequencies, sweeps, changes)
    found = np.array([half_power(frequencies, row, GYROSCOPE.mass) for row in rows])
    relative = found / (GYROSCOPE.stiffness, GYROSCOPE.damping) - 1.0
    spread = np.std(relative, axis=0, ddof=1) if sweeps > 1 else np.zeros(2)
    return Estimate(*np.mean(relative, axis=0).tolist()), Estimate(*spread.tolist())


def sequences(periods: int, changes: Mapping[str, object]) -> tuple[Estimate, Estimate]:
    """Mean and standard deviation of the relative errors of the paper's loop, once settled, period by period."""
    found = calibrate(library("self_calibration_gyroscope.toml").with_parameters(changes), periods)
    settled = np.stack([found.stiffness[16:], found.damping[16:]])
    return Estimate(*settled.mean(axis=1).tolist()), Estimate(*settled.std(axis=1, ddof=1).tolist())


def both(errors: Estimate) -> str:
    """Errors of stiffness and damping."""
    return "{:.1e} and {:.1e}".format(*errors)


def rows() -> Iterator[tuple[str, ...]]:
    """The table: method, how long it takes, mean errors, scatter at two noises."""
    yield "Sense mode, 137.7 N/m and 7.12e-5 kg/s", "takes", "errors without noise", "scatter, 5 mV", "scatter, 50 mV"
    quiet, loud = {"amplifier.density": 0.0}, {"amplifier.density": 0.7559289e-3}
    for frequencies, step in ((SWEEP, 15), (FINE, 5)):
        exact = errors(frequencies, 1, quiet | {"adc.bits": 32, "volts.gain": 10.0 / 2**31})[0]
        noisy = (errors(frequencies, 20, changes)[1] for changes in ({}, loud))
        spent = f"{24e-3 * len(frequencies):.2f} s"
        yield f"half power, every {step} Hz", spent, both(exact), *(both(scatter) for scatter in noisy)
    exact = sequences(40, IDEAL)[0]
    noisy = (sequences(200, changes)[1] for changes in ({}, loud))
    spent = f"{11 * CHIPS / GYROSCOPE.rate:.2f} s"
    yield "the paper's loop, a period each", spent, both(exact), *(both(scatter) for scatter in noisy)


def overdamped(device: Device = ACCELEROMETER) -> tuple[float, float]:
    """Frequency of the accelerometer's largest amplitude in Hz, and 2 pi m f at half the power over its damping."""
    response = amplitudes(WIDE, 1, OF_ACCELEROMETER)[0]
    down = float(np.interp(-response[0] / np.sqrt(2.0), -response, WIDE))
    return float(WIDE[np.argmax(response)]), 2.0 * np.pi * device.mass * down / device.damping


if __name__ == "__main__":
    for row in rows():
        print("".join(f"{cell:42}" if n == 0 else f"{cell:24}" for n, cell in enumerate(row)).rstrip())
    largest, share = overdamped()
    print(f"accelerometer: largest amplitude at {largest:.0f} Hz; half power would give {share:.2f} of its damping")
