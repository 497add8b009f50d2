"""Runs of the self-calibration graphs of the library, and what theory says of them: for tables, pictures and tests."""

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache
from importlib.resources import as_file
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import expm
from scipy.optimize import least_squares

from proofmass.blocks import DiscreteMassSpringDamper, LowPass, Step, WhiteNoise
from proofmass.graphs.files.library import library_file
from proofmass.graphs.files.toml_reader import read_graph
from proofmass.graphs.model.build import Graph
from proofmass.graphs.studies.build import Study
from proofmass.graphs.studies.study_reader import read_study
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate
from proofmass.runner.studies.whole.study import run_study

CHIPS = 1023
G0 = 9.80665
IDEAL = {"amplifier.density": 0.0, "adc.bits": 32, "volts.gain": 10.0 / 2**31}  # no noise, no visible rounding
NOISE = math.hypot(5e-3, 20.0 / 4096 / math.sqrt(12.0))  # of the amplifier, and of rounding to codes
WANDER = 0.1 * G0 / math.sqrt(5.0 * math.pi)  # density that makes 0.1 g rms behind a low-pass of 10 Hz
DEVICES = {"accelerometer": ("accelerometer", 51.48, 4.57e-3), "gyroscope": ("sense", 137.7, 7.12e-5)}
RULES = {"forward_euler": (0.0, 0.0), "semi_implicit": (0.0, 1.0), "tustin": (0.5, 0.5)}


class Device(NamedTuple):
    """A device as the reference model sees it; volts per metre are those of its readout."""

    mass: float
    stiffness: float
    damping: float
    rate: float
    readout: float
    designed: tuple[float, float]  # stiffness and damping a priori


ACCELEROMETER = Device(50.43e-9, 51.48, 4.57e-3, 4800.0, 3.5301e8, (49.5627, 3.4e-3))
GYROSCOPE = Device(48.67e-9, 137.7, 7.12e-5, 8750.0, 3.4069e8, (132.0, 5.57e-5))


class Calibration(NamedTuple):
    """Relative errors of the reference model's parameters after each period."""

    stiffness: Any
    damping: Any
    result: Result

    def periods_to(self, tolerance: float) -> tuple[int, int]:
        """Periods after which stiffness and damping stay within the tolerance."""
        late = [np.flatnonzero(np.abs(error) > tolerance) for error in (self.stiffness, self.damping)]
        stiffness, damping = (int(n[-1]) + 2 if len(n) else 1 for n in late)
        return stiffness, damping


def library(name: str) -> Graph:
    """A graph of the library."""
    with as_file(library_file(name)) as path:
        return read_graph(path)


def calibrate(graph: Graph, periods: int, seed: int | None = None) -> Calibration:
    """Run a self-calibration for so many periods and compare its parameters with those of its device."""
    device: Any = next(graph.blocks[name] for name, _, _ in DEVICES.values() if name in graph.blocks)
    chip = graph.rate or Fraction(1)
    result = simulate(graph, duration=CHIPS * periods / chip, seed=seed, engine="compiled")
    stiffness, damping = (
        next(
            result[name].values
            for name in (f"{value}.{value}", f"fit.{value}", f"controller.{value}")
            if name in result
        )
        for value in ("stiffness", "damping")
    )
    every = (len(stiffness) - 1) // periods
    return Calibration(stiffness[every::every] / device.stiffness - 1.0, damping[1:] / device.damping - 1.0, result)


def at_rate(graph: Graph, rate: float) -> Graph:
    """A graph at another chip rate, all rates of its blocks in proportion."""
    factor = Fraction(rate) / (graph.rate or Fraction(1))
    return replace(graph, rate=rate, rates={name: own * factor for name, own in graph.rates.items()})


def wandering(graph: Graph) -> Graph:
    """The paper's loop on an accelerometer that feels noise below 10 Hz, 0.1 g rms."""
    wander = WhiteNoise(density=WANDER, unit="m/s^2")
    felt = LowPass(corner_frequency=10.0, input_unit="m/s^2", output_unit="m/s^2")
    wires = [*map(str, graph.wires), "wander.output -> acceleration.input"]
    return replace(graph, blocks={**graph.blocks, "wander": wander, "acceleration": felt}, wires=wires)


@cache
def integrator_bias(device: Device, rule: str, steps: int) -> float:
    """Relative error of the damping of the integrators whose h[1] to h[15] fit those of the device best.

    Of integrators that take so many steps a chip; the device moves exactly. The responses are a graph's.
    """
    rate, count = int(device.rate) * steps, 15
    graph = Graph(
        name="a chip",
        rate=rate,
        blocks={
            "push": Step(amplitude=1e-6, duration=(steps - 0.5) / rate, unit="N"),
            "model": integrators(device, rule),
        },
        wires=["push.output -> model.force"],
        probes=[{"signal": "model.displacement", "every": steps}],
    )
    joined, state, exact = one_chip(device), np.array([0.0, 0.0, 1.0]), []
    for _ in range(count):
        state = joined @ state
        exact.append(state[0])
        state[2] = 0.0
    largest = max(map(abs, exact))

    def rest(logarithms: Any) -> Any:
        k, c = device.stiffness * math.exp(logarithms[0]), device.damping * math.exp(logarithms[1])
        moved = graph.with_parameters({"model.stiffness": k, "model.damping": c})
        found = simulate(moved, samples=count * steps + 1, engine="compiled")["model.displacement"].values[1:]
        return (found - exact) / largest

    taken = math.log1p(device.stiffness / rate / device.damping) if rule == "forward_euler" else 0.0
    return math.expm1(least_squares(rest, [0.0, taken], xtol=1e-12, ftol=1e-12, gtol=1e-12).x[1])


def integrators(device: Device, rule: str) -> DiscreteMassSpringDamper:
    """A reference model of two digital integrators."""
    acceleration, velocity = RULES[rule]
    return DiscreteMassSpringDamper(mass=device.mass, acceleration_at_end=acceleration, velocity_at_end=velocity)


def sense_amplitude(graph: Graph) -> float:
    """Amplitude of the sense mode in the steady state: least squares of sine and cosine at the drive's frequency."""
    trace = simulate(graph, engine="compiled")["sense.displacement"]
    drive: Any = graph.blocks["drive_velocity"]
    settled = len(trace.values) * 2 // 3
    angle = 2.0 * np.pi * drive.frequency * float(trace.period) * np.arange(settled, len(trace.values))
    waves = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    return float(np.hypot(*np.linalg.lstsq(waves, trace.values[settled:])[0]))


class Outcome(NamedTuple):
    """A population of devices after their calibration."""

    converged: int  # which the graph says itself
    worst: float  # largest relative error of these
    told: int  # wrong by more than 1 %, and not among these


@cache
def population(file: str, axis: str = "", runs: int = 200, lanes: int | None = None) -> Outcome:
    """What becomes of devices within 10 % of stiffness and 40 % of damping; of a unit, of one of its axes."""
    with as_file(library_file(file)) as path:
        study = read_study(path)
    measures, device = studied(file, runs, lanes), f"{axis}.device" if axis else "sense"
    drawn = [study.drawn(number)[0] for number in range(runs)]
    truths = np.array([[parameters[f"{device}.{name}"] for name in ("stiffness", "damping")] for parameters in drawn])
    prefix = f"{axis}_" if axis else ""
    error = np.abs(np.column_stack([measures[f"{prefix}{n}"] for n in ("stiffness", "damping")]) / truths - 1.0).max(
        axis=1
    )
    if axis:
        converged = (measures[f"{axis}_settled"][:, 0] > 0.0) & (measures[f"{axis}_residual"][:, 0] < 8e-3)
    else:
        converged = measures["converged"][:, 0] > 0.0
    return Outcome(int(converged.sum()), float(error[converged].max()), int((error[~converged] > 1e-2).sum()))


@cache
def studied(file: str, runs: int, lanes: int | None = None) -> Any:
    """The study of a file of the library."""
    with as_file(library_file(file)) as path:
        return run_study(read_study(path), runs=runs, engine="compiled", lanes=lanes)


def tested(periods: int, runs: int) -> Any:
    """The study of self_test_population.toml, with a test of so many periods."""
    graph = replace(library("self_test_population.toml"), samples=CHIPS * periods + 1)
    spread = {
        "true_stiffness.value": {"normal": "3 %", "relative": True, "truncated": 3},
        "true_damping.value": {"normal": "12 %", "relative": True, "truncated": 3},
    }
    return run_study(Study(graph, runs=runs, seed=7, spread=spread), engine="compiled")


def scatter(file: str, runs: int, lanes: int | None = None) -> tuple[float, float]:
    """Deviations of stiffness and damping over calibrations of one device with other noise, absolute."""
    found = run_study(Study(library(file), runs=runs, seed=3), engine="compiled", lanes=lanes)
    return float(found["stiffness"].std()), float(found["damping"].std())


def one_chip(device: Device) -> Any:
    """Displacement and velocity a chip later, from both and from +1 (uN), by SciPy's exponential."""
    mass, stiffness, damping = device.mass, device.stiffness, device.damping
    joined = np.array([[0.0, 1.0, 0.0], [-stiffness / mass, -damping / mass, 1e-6 / mass], [0.0, 0.0, 0.0]])
    return expm(joined / device.rate)


def response(device: Device) -> Any:
    """Volts at each chip of a period in the steady state, by the transfer function."""
    (a, b, e), (c, d, f) = one_chip(device)[:2]
    z = np.exp(2j * np.pi * np.arange(CHIPS // 2 + 1) / CHIPS)
    transfer = (e * (z - d) + b * f) / ((z - a) * (z - d) - b * c)
    return device.readout * np.fft.irfft(transfer * np.fft.rfft(chips()), CHIPS)


@cache
def chips() -> Any:
    """A period of chips, +1 and -1: a[n] = a[n-7] xor a[n-10], ten ones first."""
    bits = [1] * 10
    while len(bits) < CHIPS:
        bits.append(bits[-7] ^ bits[-10])
    return 2.0 * np.array(bits) - 1.0


def by_logarithms(seen: Any, device: Device) -> Any:
    """Derivatives of what is seen of a device by ln k and ln c, as columns."""
    up, down = math.exp(1e-5), math.exp(-1e-5)
    moved = [
        [device._replace(stiffness=device.stiffness * factor) for factor in (up, down)],
        [device._replace(damping=device.damping * factor) for factor in (up, down)],
    ]
    return np.stack([(seen(more) - seen(less)) / 2e-5 for more, less in moved], axis=-1)


def cramer_rao(device: Device) -> Any:
    """Least deviations of stiffness and damping, relative, from the noise of all samples of one period."""
    jacobian = by_logarithms(response, device)
    return NOISE * np.sqrt(np.diag(np.linalg.inv(jacobian.T @ jacobian)))


def seen_by_controllers(device: Device) -> Any:
    """What the paper's two controllers look at: the sum over the window, and h[1]."""
    volts = response(device)
    return np.array([volts[1:11].sum(), np.roll(chips(), 1) @ volts / (CHIPS + 1)])


def natural_gains(device: Device) -> tuple[float, float]:
    """Half of what would remove the error of each parameter of the a priori device alone: N/m/V and kg/s/V."""
    stiffness, damping = device.designed
    slopes = by_logarithms(seen_by_controllers, device._replace(stiffness=stiffness, damping=damping))
    return float(-0.5 * stiffness / slopes[0, 0]), float(-0.5 * damping / slopes[1, 1])


def eigenvalues(device: Device) -> Any:
    """Of the map of both errors over a period, close to the device: the stiffness moves first, the damping last."""
    gains = np.array(natural_gains(device)) / (device.stiffness, device.damping)
    slopes = by_logarithms(seen_by_controllers, device) * gains[:, None]
    first, second = np.eye(2), np.eye(2)
    first[0] += slopes[0]
    second[1] += slopes[1]
    return np.linalg.eigvals(second @ first)
