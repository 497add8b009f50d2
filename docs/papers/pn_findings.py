"""What graphs and closed forms say of the claims of Sarraf et al. 2012; docs/papers/pn_claims.py has the rows."""

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from docs.papers import half_power, occupancy, pn_runs, pn_self_calibration
from docs.papers.pn_runs import ACCELEROMETER, CHIPS, G0, GYROSCOPE, IDEAL, Device, at_rate, calibrate, library
from docs.papers.pn_self_calibration import both
from proofmass.blocks import MassSpringDamper, ShiftRegister, Step
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.result import Result
from proofmass.runner.run.simulate import simulate

LOOPS = {"accelerometer": "self_calibration_accelerometer", "gyroscope": "self_calibration_gyroscope"}
FIXED = {"accelerometer": "self_calibration_fixed", "gyroscope": "self_calibration_gyroscope_fixed"}


@functools.cache
def table(of: Callable[[], pn_self_calibration.Rows]) -> dict[str, tuple[str, ...]]:
    """A table of the page of the paper: its rows by their names."""
    return {name: tuple(cells) for name, *cells in of()}


@functools.cache
def ideal(device: str) -> Any:
    """The paper's loop without noise."""
    return calibrate(library(f"{LOOPS[device]}.toml").with_parameters(IDEAL), 32)


@functools.cache
def noisy(device: str) -> tuple[float, float]:
    """Errors of the loop with a converter of 12 bits and 5 mV of noise, mean of 32 periods."""
    return pn_self_calibration.settled(calibrate(library(f"{LOOPS[device]}.toml"), 64))


def percent(share: float, digits: int) -> str:
    """A share in per cent."""
    return f"{100.0 * share:.{digits}f} %"


def identified(device: str, number: int) -> str:
    """Stiffness (0) or damping (1) that the noisy loop finds."""
    _, *truths = pn_runs.DEVICES[device]
    return f"{truths[number] * (1.0 + noisy(device)[number]):.4g} {('N/m', 'kg/s')[number]}"


def impulse_response(device: Device) -> Any:
    """Volts k chips after one of +1, k = 0 to 31, by SciPy's exponential."""
    step, state, found = pn_runs.one_chip(device), np.array([0.0, 0.0, 1.0]), [0.0]
    for _ in range(31):
        state = step @ state
        found.append(device.readout * state[0])
        state[2] = 0.0
    return np.array(found)


def correlated() -> str:
    """How far the cells are from the impulse response of the device."""
    worst = 0.0
    for name, device in (("accelerometer", ACCELEROMETER), ("gyroscope", GYROSCOPE)):
        found = ideal(name).result["cells.impulse_response"].values[-1]
        exact = impulse_response(device)[: len(found)]
        worst = max(worst, float(np.abs(found - exact).max() / np.abs(exact).max()))
    return f"within {100.0 * worst:.1g} % of the largest"


def autocorrelation() -> str:
    """Of a period of the generator of the library."""
    blocks = {"chips": ShiftRegister()}
    graph = Graph(name="chips", rate=1, blocks=blocks, wires=[], probes=["chips.bit"], samples=CHIPS)
    chips = 2.0 * simulate(graph)["chips.bit"].values - 1.0
    values = [round(float(chips @ np.roll(chips, lag))) for lag in range(CHIPS)]
    ones = int(np.argmin(chips))
    return f"{values[0]} at lag 0, {min(values[1:])} to {max(values[1:])} at all others; {ones} ones first"


def energy(device: Device, first: int) -> float:
    """Part of the energy of an impulse response in its first coefficients."""
    squares = impulse_response(device) ** 2
    return float(squares[: first + 1].sum() / squares.sum())


def first_coefficients() -> str:
    """The energy in the first 3 and in the first 15."""
    fast, slow = percent(energy(ACCELEROMETER, 3), 2), percent(energy(GYROSCOPE, 15), 1)
    return f"accelerometer: {fast} in 3; gyroscope: {slow} in 15"


def pushed(device: Device, seconds: float, damping: float = 1.0) -> float:
    """Displacement under a constant micronewton, over the static one."""
    graph = Graph(
        name="a push",
        rate=1_000_000,
        blocks={
            "push": Step(amplitude=1e-6, unit="N"),
            "mass": MassSpringDamper(mass=device.mass, stiffness=device.stiffness, damping=damping * device.damping),
        },
        wires=["push.output -> mass.force"],
        probes=["mass.displacement"],
        duration=seconds,
    )
    return float(simulate(graph, engine="compiled")["mass.displacement"].values[-1]) * device.stiffness / 1e-6


def static() -> str:
    """A constant force at two dampings, long after it began."""
    return " and ".join(f"{pushed(ACCELEROMETER, 0.01, damping):.4f}" for damping in (1.0, 2.0)) + " of F / k"


def ten_clocks() -> str:
    """How far each device is from rest in ten clocks."""
    cells = (
        f"{name}: {percent(abs(pushed(device, 10.0 / rate) - 1.0), 1)}"
        for name, device, rate in (("accelerometer", ACCELEROMETER, 4800.0), ("gyroscope", GYROSCOPE, 8500.0))
    )
    return ", ".join(cells) + " off"


def sensitivities() -> str:
    """Last lag at which a derivative by the damping is above a twentieth of the largest."""
    cells = []
    for name, file, at in (("accelerometer", "online", ""), ("gyroscope", "gauss_newton", "below.")):
        result = calibrate(library(f"self_calibration_{file}.toml"), 4).result
        values = np.abs(result[f"{at}cells_by_damping.impulse_response"].values[-1])[:16]
        cells.append(f"{name}: h[{int(np.flatnonzero(values > 0.05 * values.max())[-1])}]")
    return ", ".join(cells) + " is the last of 15 above 5 %"


def static_volts() -> str:
    """7000 V/ms^2 as what moves the reference model."""
    return f"{7000e6 * ACCELEROMETER.mass / ACCELEROMETER.stiffness:.2f} V at rest, of the 10 V of the converter"


def periods(device: str) -> str:
    """Periods to a per cent and to a thousandth."""
    found = ideal(device)
    first, second = (found.periods_to(limit) for limit in (1e-2, 1e-3))
    return "k in {}, c in {} periods to 1 %; {} and {} to 0.1 %".format(*first, *second)


def chip_rate() -> str:
    """The paper's rates, over the 3-dB frequencies of the calibrated devices, by simulation of none."""
    corners = []
    for device in (ACCELEROMETER, GYROSCOPE):
        w2, width = device.stiffness / device.mass, device.damping / device.mass
        middle = w2 - width * width / 2.0
        corners.append(np.sqrt(middle + np.sqrt(middle * middle + w2 * w2)) / (2.0 * np.pi))
    return f"4.8 kHz is {4800 / corners[0]:.2f} of it, 8.5 kHz {8500 / corners[1]:.2f}"


def at_8500() -> str:
    """The gyroscope's loop at the paper's rate."""
    device = GYROSCOPE._replace(rate=8500.0)
    gains = dict(zip(("stiffness.gain", "damping.gain"), pn_runs.natural_gains(device), strict=True))
    graph = at_rate(library("self_calibration_gyroscope.toml"), 8500.0).with_parameters(IDEAL | gains)
    return f"errors of {pn_self_calibration.ended(graph)[0]} after 80 periods"


@functools.cache
def gyroscope(tuning: float | None = None) -> Result:
    """The gyroscope with the capacitances of table 2; tuned, or with so many volts on the sense plates."""
    graph = library("gyroscope_capacitances.toml")
    changed = graph if tuning is None else graph.with_parameters({"tuning": tuning})
    return simulate(changed, engine="compiled")


def measured(name: str, tuning: float | None = None) -> float:
    """A measure of it."""
    return float(gyroscope(tuning).measures[name].value)


def capacitances() -> str:
    """What both capacitances do."""
    aF = 1e18 * measured("capacitance_amplitude")
    return f"{1e6 * measured('drive_amplitude'):.2f} um by combs at 10.7 V; {aF:.1f} aF for 1 deg/s"


def plates_of_the_drive() -> str:
    """Amplitude of the drive of vibratory_gyroscope.toml at its softened resonance, with either capacitance."""
    graph, cells = library("vibratory_gyroscope.toml"), []
    for picofarads in (0.05, 0.36):
        softened = 122.28 - 2e-12 * picofarads * (15.0**2 + 0.5) / 4e-6**2  # N/m, mean over a period of 1 V
        frequency = float(np.sqrt(softened / 48.67e-9) / (2.0 * np.pi))
        changes = {"plates.capacitance": 1e-12 * picofarads, "signal.frequency": frequency}
        values = simulate(graph.with_parameters(changes), engine="compiled")["drive.displacement"].values
        largest = 1e9 * float(np.abs(values[-len(values) // 5 :]).max())
        cells.append(f"{picofarads} pF: {largest:.0f} nm at {frequency:.0f} Hz")
    return ", ".join(cells)


def tuned() -> str:
    """The sense mode with and without the voltage that tunes it."""
    return (
        f"{1e12 * measured('sense_amplitude', 0.0):.1f} pm; tuned by 5.76 V {1e12 * measured('sense_amplitude'):.1f} pm"
    )


def mismatched() -> str:
    """The paper's two amplitudes, and 5 % of stiffness."""
    left = table(pn_self_calibration.rate_response)["+5 % of stiffness"][1].split(", ")[1]
    return f"1.791 / 4.623 = {1.791 / 4.623:.3f}, a fall of 61 %; 5 % of stiffness leave {left}"


def reciprocal() -> str:
    """Coriolis force on the drive over that of its combs."""
    return f"{measured('reciprocal_force') / measured('comb_force'):.1e} of it"


def half_power_of_gyroscope() -> str:
    """Errors by half power without noise, beside the scatter of the loop."""
    exact, _ = half_power.errors(half_power.SWEEP, 1, half_power.QUIET)
    return f"errors of {both(exact)}"


def half_power_scatter() -> str:
    """Scatter of half power in 0.7 s of measurement, and of the loop, a period of 0.12 s each."""
    _, swept = half_power.errors(half_power.SWEEP, 20)
    _, loop = half_power.sequences(200, {})
    return f"half power, 0.70 s: {both(swept)}; the loop, a period of 0.12 s: {both(loop)}"


def half_power_of_accelerometer() -> str:
    """Where its response is largest, and what its corner would give."""
    largest, share = half_power.overdamped()
    return f"largest at {largest:.0f} Hz, the lowest tried; its corner would give {share:.2f} of the damping"


def quality(device: Device, stiffness: float, damping: float) -> float:
    """sqrt(k m) over the damping."""
    return float(np.sqrt(stiffness * device.mass) / damping)


def qualities() -> str:
    """Of both modes of table 2, from its stiffness, mass and damping."""
    return f"{quality(GYROSCOPE, 122.28, 18.9e-6):.1f} and {quality(GYROSCOPE, 132.23, 57e-6):.2f}"


def resonance() -> str:
    """Of table 1."""
    mass, (stiffness, damping) = ACCELEROMETER.mass, ACCELEROMETER.designed
    f0 = np.sqrt(stiffness / mass) / (2.0 * np.pi)
    return f"{f0:.0f} Hz, a quality factor of {quality(ACCELEROMETER, stiffness, damping):.3f}"


def hardware(design: str, *blocks: str) -> str:
    """Slices at least, flip-flops, lookup tables and multipliers of blocks of a graph in registers."""
    return " / ".join(map(str, occupancy.ours(design, blocks)))


def clock(design: str) -> str:
    """An estimate from the longest path."""
    return f"about {occupancy.synthesis(design).clock.megahertz or 0.0:.1f} MHz"


def occupation() -> str:
    """Of the paper's own counts."""
    follow, printed, fit = occupancy.agreements()
    return f"{follow} of {printed} percentages follow from the counts; {fit} of what fits is marked N/A"


def largest_share(cells: occupancy.Cells, device: str) -> str:
    """The scarcest resource of a device."""
    shares = dict(zip(("slices", "FF", "LUT", "MULT"), occupancy.occupied(cells, device), strict=True))
    name = max(shares, key=lambda key: shares[key])
    return f"{float(shares[name]):.1f} % of {name}"


def three_axes_of_the_paper() -> str:
    """By its own counts."""
    return largest_share(occupancy.three_axes(*occupancy.PAPER.values(), generator=occupancy.GENERATOR), "XC2VP30")


def in_operation() -> str:
    """1 g at 33 Hz during the calibration, least squares after 96 periods."""
    found = calibrate(library("self_calibration_in_operation.toml"), 96, 1)
    return f"errors of {both((float(found.stiffness[-1]), float(found.damping[-1])))} under 1 g at 33 Hz"


def three_at_once() -> str:
    """Largest error of stiffness and damping over the axes of imu_3dof.toml."""
    result, worst = simulate(library("imu_3dof.toml"), engine="compiled"), [0.0, 0.0]
    other = ACCELEROMETER._replace(stiffness=48.1, damping=3.9e-3)
    for axis, device in (("x", ACCELEROMETER), ("y", other), ("z", GYROSCOPE)):
        for number, truth in enumerate((device.stiffness, device.damping)):
            value = float(result.measures[f"{axis}_{('stiffness', 'damping')[number]}"].value)
            worst[number] = max(worst[number], abs(value / truth - 1.0))
    return f"largest errors {both((worst[0], worst[1]))}"


def self_tested() -> str:
    """2000 devices, 24 periods."""
    found = pn_runs.tested(24, 2000)
    loss, escape = (percent(float(found[name].mean()), 2) for name in ("yield_loss", "test_escape"))
    return f"{loss} of devices lost, {escape} escape"


def registers_against_floating() -> str:
    """Difference over the peak."""
    rows = table(pn_self_calibration.registers)
    step, sine = (percent(float(rows[name][1]), 2) for name in ("step of 1 g", "1 g at 90 Hz"))
    return f"{step} and {sine} of the peak"


def controllers_in_registers() -> str:
    """Errors of both devices."""
    cells = (f"{device} {table(pn_self_calibration.calibrations)[f'{device}, errors'][3]}" for device in LOOPS)
    return "; ".join(cells)


def carrier(swing: str) -> str:
    """Amplitude of the demodulated carrier above that of one gain."""
    above = float(table(pn_self_calibration.readout)[f"{swing} nm at 1 kHz"][0])
    return f"{percent(above, 3)} above a gain at {swing} nm"


def bias_by_acceleration() -> str:
    """0.1 g constant during the paper's loop."""
    graph = library("self_calibration_accelerometer.toml").with_parameters({"acceleration.offset": 0.1 * G0})
    return f"0.1 g: errors of {both(pn_self_calibration.settled(calibrate(graph, 64)))}"
