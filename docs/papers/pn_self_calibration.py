"""The PN self-calibration of Sarraf et al. 2012: what the paper reports beside what the graphs of the library do.

    python -m docs.papers.pn_self_calibration

Some minutes. Labels: [P] the paper prints it; [A] follows under assumed gains, converters and noise, which it does not
print; [C] a conjecture about what it means; [V] computed without graphs.
"""

import sys
from collections.abc import Callable, Iterator

import numpy as np

from docs.papers.pn_runs import (
    ACCELEROMETER,
    CHIPS,
    DEVICES,
    G0,
    GYROSCOPE,
    IDEAL,
    RULES,
    WANDER,
    Calibration,
    at_rate,
    calibrate,
    cramer_rao,
    eigenvalues,
    integrator_bias,
    library,
    natural_gains,
    population,
    scatter,
    sense_amplitude,
    tested,
    wandering,
)
from proofmass.graphs.model.build import Graph
from proofmass.runner.run.simulate import RunError, simulate

Rows = Iterator[tuple[str, ...]]
ONLINE, GAUSS_NEWTON = "self_calibration_online.toml", "self_calibration_gauss_newton.toml"
IN_OPERATION = "self_calibration_in_operation.toml"
REGISTERS = {"accelerometer": "self_calibration_fixed.toml", "gyroscope": "self_calibration_gyroscope_fixed.toml"}
STEPS = (64, 256, 1024, 4096)


def both(errors: tuple[float, float]) -> str:
    """Errors of stiffness and damping."""
    return "{:.1e} and {:.1e}".format(*errors)


def settled(found: Calibration) -> tuple[float, float]:
    """Mean errors of stiffness and damping after 32 periods."""
    return float(found.stiffness[32:].mean()), float(found.damping[32:].mean())


def worst(found: Calibration) -> tuple[float, float]:
    """Largest errors of stiffness and damping in a period after 16."""
    return float(np.abs(found.stiffness[16:]).max()), float(np.abs(found.damping[16:]).max())


def calibrations() -> Rows:
    """Both devices by the paper's two controllers."""
    yield "The paper's loop", "paper", "here, ideal [A]", "12 bit, 5 mV [A]", "registers [A]"
    for device, (_, stiffness, damping) in DEVICES.items():
        graph = library(f"self_calibration_{device}.toml")
        ideal, noisy = calibrate(graph.with_parameters(IDEAL), 32), calibrate(graph, 64)
        exact = float(ideal.stiffness[-1]), float(ideal.damping[-1])
        errors = exact, settled(noisy), settled(calibrate(library(REGISTERS[device]), 64))
        for number, (name, truth, unit) in enumerate((("stiffness", stiffness, "N/m"), ("damping", damping, "kg/s"))):
            values = (f"{truth * (1.0 + error[number]):.6g} {unit}" for error in errors)
            yield f"{device}, {name}", f"{truth:g} {unit} [P]", *values
        yield f"{device}, errors", "", *(both(error) for error in errors)
        for percent in (1.0, 0.1):
            spent = "{} and {}".format(*ideal.periods_to(percent / 100.0))
            yield f"{device}, periods to {percent:g} %", "damping takes more [P]", spent


def chip_rates() -> Rows:
    """Where the paper's loop converges, by the eigenvalues of its map over a period and by the graph."""
    yield "The paper's loop, by chip rate", "eigenvalue [V]", "errors after 80 periods [A]", "periods to 0.1 %"
    wide = {"adc.reference": 40.0, "volts.gain": 40.0 / 2**31}  # at twice the resonance the response is beyond 10 V
    for device, name, rate, range_ in (
        (ACCELEROMETER, "accelerometer", 2.4, {}),
        (ACCELEROMETER, "accelerometer", 4.8, {}),
        (ACCELEROMETER, "accelerometer", 9.6, {}),
        (GYROSCOPE, "gyroscope", 8.0, {}),
        (GYROSCOPE, "gyroscope", 8.25, {}),
        (GYROSCOPE, "gyroscope", 8.5, {}),
        (GYROSCOPE, "gyroscope", 8.75, {}),
        (GYROSCOPE, "gyroscope", 9.0, {}),
        (GYROSCOPE, "gyroscope", 16.75, {}),
        (GYROSCOPE, "gyroscope", 16.75, wide),
    ):
        there = device._replace(rate=1e3 * rate)
        gains = dict(zip(("stiffness.gain", "damping.gain"), natural_gains(there), strict=True))
        graph = at_rate(library(f"self_calibration_{name}.toml"), 1e3 * rate).with_parameters(IDEAL | gains | range_)
        largest = f"{np.abs(eigenvalues(there)).max():.3f}"
        yield f"{name}, {rate:g} kHz{', +-40 V' if range_ else ''}", largest, *ended(graph)


def ended(graph: Graph) -> tuple[str, str]:
    """Errors at the end, if it comes to one, and the periods to 0.1 %."""
    try:
        calibration = calibrate(graph, 80)
    except RunError:
        return "the model becomes unstable", "never"
    final = abs(float(calibration.stiffness[-1])), abs(float(calibration.damping[-1]))
    return both(final), "{} and {}".format(*calibration.periods_to(1e-3)) if max(final) < 1e-3 else "never"


def biases() -> Rows:
    """What the paper's loop takes for stiffness and damping."""
    yield "The paper's loop, biased by", "mean errors [A]"
    graph = library("self_calibration_accelerometer.toml")
    for name, changes in (
        ("12 bit without noise", {"amplifier.density": 0.0}),
        ("1 % more force than is known", {"dac.level": 1.01 * 1.694111}),
        ("0.1 g constant", {"acceleration.offset": 0.1 * G0}),
    ):
        yield f"accelerometer, {name}", both(settled(calibrate(graph.with_parameters(changes), 64)))


def both_at_once() -> Rows:
    """Gauss-Newton steps: periods, scatter over the Cramer-Rao bound, and the population."""
    yield "Gauss-Newton steps", "the paper's loop", "Gauss-Newton", "at most"
    paced = GYROSCOPE._replace(rate=8500.0)
    for name, device, paper, file, limit in (
        ("accelerometer", ACCELEROMETER, "5 and 5", ONLINE, 1.3),
        ("gyroscope at 8.5 kHz", paced, "never", GAUSS_NEWTON, 1.7),
    ):
        spent = "{} and {}".format(*calibrate(library(file).with_parameters(IDEAL), 12).periods_to(1e-3))
        yield f"{name}, periods to 0.1 %", paper, spent
        bound = cramer_rao(device)
        ratios = np.array(scatter(file, 200)) / (device.stiffness, device.damping) / bound
        yield f"{name}, Cramer-Rao bound [V]", "", both(tuple(bound))
        yield f"{name}, scatter of 200 over it", "", "{:.2f} and {:.2f}".format(*ratios), f"{limit}"


def populations() -> Rows:
    """200 devices within 10 % of stiffness and 40 % of damping each: who converges, and who says so."""
    yield "200 devices each [A]", "converged", "largest error of these", "reported as not", "of these wrong by 1 %"
    for name, file, axis in (
        ("accelerometer x, the paper's loop", "imu_3dof.toml", "x"),
        ("accelerometer y, the paper's loop", "imu_3dof.toml", "y"),
        ("gyroscope at 8.75 kHz, the paper's loop", "imu_3dof.toml", "z"),
        ("gyroscope at 8.5 kHz, two Gauss-Newton fits", GAUSS_NEWTON, ""),
    ):
        found = population(file, axis)
        yield name, str(found.converged), f"{found.worst:.1e}", str(200 - found.converged), str(found.told)


def in_operation() -> Rows:
    """Least squares over long records under acceleration, the paper's loop beside."""
    yield "In operation, worst of 3 seeds", "the paper's loop, worst period", "least squares", "at most"
    papers = library("self_calibration_accelerometer.toml")
    still = {"vibration.amplitude": 0.0}
    for name, changes, graph, limit in (
        ("at rest", still, papers, "1e-4"),
        ("0.5 g at 20 Hz", {"vibration.amplitude": 0.5 * G0, "vibration.frequency": 20.0},
         papers.with_parameters({"acceleration.amplitude": 0.5 * G0, "acceleration.frequency": 20.0}), "1e-4"),
        ("1 g at 33 Hz", {}, papers.with_parameters({"acceleration.amplitude": G0}), "1e-4"),
        ("0.1 g rms below 10 Hz", still | {"wander.density": WANDER}, wandering(papers), "5e-4"),
    ):  # fmt: skip
        try:
            beside = both(worst(calibrate(graph, 64)))
        except RunError:
            beside = f"{both(worst(calibrate(graph, 24)))}, then it ends"
        shaken = library(IN_OPERATION).with_parameters(changes)
        found = [calibrate(shaken, 96, seed) for seed in (1, 2, 3)]
        errors = max(abs(float(c.stiffness[-1])) for c in found), max(abs(float(c.damping[-1])) for c in found)
        yield f"accelerometer, {name}", beside, both(errors), limit


def rate_response() -> Rows:
    """The sense mode at 1 deg/s; the paper's unit is a thousand times too large."""
    yield "Gyroscope, sense mode at 1 deg/s", "paper", "here", "closed form [V]"
    graph, w = library("gyroscope_rate_response.toml"), 2.0 * np.pi * 7977.51
    force = 2.0 * 48.67e-9 * np.radians(1.0) * w * 5e-6
    tuned = 0.0
    for name, paper, percent, damping in (
        ("tuned", "143.7 nm [P]", 0.0, 57e-6),
        ("tuned, Q of 43.63", "143.7 nm [P]", 0.0, 5.815e-5),
        ("table 2, 132.23 N/m", "", 8.137, 57e-6),
        *((f"{percent:+g} % of stiffness", "0.387 of tuned [P]" if percent == 5.0 else "", percent, 57e-6)
          for percent in (-10.0, -5.0, -2.0, -1.0, 1.0, 2.0, 5.0, 10.0)),
    ):  # fmt: skip
        stiffness = 122.28 * (1.0 + percent / 100.0)
        found = sense_amplitude(graph.with_parameters({"sense.stiffness": stiffness, "sense.damping": damping}))
        exact = force / abs(stiffness - 48.67e-9 * w * w + 1j * w * damping)
        tuned = tuned or found
        yield name, paper, f"{1e12 * found:.1f} pm, {found / tuned:.3f}", f"{1e12 * exact:.1f} pm"


def registers() -> Rows:
    """The reference model of two digital integrators in (24, 6) and (32, 30) beside the exact one."""
    yield "Registers against floating point", "paper", "difference over peak [A]", "at most"
    values = {
        n: m.value for n, m in simulate(library("fixed_against_floating.toml"), engine="compiled").measures.items()
    }
    for name, title in (("step", "step of 1 g"), ("sine", "1 g at 90 Hz")):
        difference = max(values[f"{name}_above"], -values[f"{name}_below"]) / values[f"{name}_peak"]
        yield title, '"match well" [P]', f"{difference:.2e}", "2e-3"


def integrators() -> Rows:
    """What a Gauss-Newton calibration finds with a reference model of digital integrators."""
    yield "Error of damping by integrators", *(f"{steps} steps a chip" for steps in STEPS)
    for name, device in (("accelerometer", ACCELEROMETER), ("gyroscope", GYROSCOPE)):
        for rule in RULES:
            cells = ("unstable" if (name, rule, steps) == ("gyroscope", "forward_euler", 64)
                     else f"{integrator_bias(device, rule, steps):.1e}" for steps in STEPS)  # fmt: skip
            yield f"{name}, {rule.replace('_', ' ')}", *cells


def readout() -> Rows:
    """The carrier of the capacitive readout against one gain and its low-pass."""
    yield "Carrier against gain model", "amplitude [A]", "at most"
    for swing, wanted in ((20e-9, "2e-4"), (200e-9, "")):
        graph = library("capacitive_readout.toml").with_parameters({"displacement.amplitude": swing})
        result = simulate(graph, engine="compiled")
        turned = np.exp(-2j * np.pi * 1e3 * 1e-5 * np.arange(101, 201))
        levels = (abs(np.mean(result[f"{n}.mean"].values[101:201] * turned)) for n in ("demodulated", "modelled"))
        carrier, gain = levels
        yield f"{1e9 * swing:.0f} nm at 1 kHz", f"{carrier / gain - 1.0:.2e}", wanted


def self_test() -> Rows:
    """Verdicts over a population, by the length of the test."""
    yield "Self-test of 2000 accelerometers [A]", "good devices", "yield loss", "test escape"
    for periods in (10, 16, 24, 32):
        found = tested(periods, 2000)
        shares = (f"{100.0 * found[name].mean():.2f} %" for name in ("good", "yield_loss", "test_escape"))
        yield f"{periods} periods, {periods * CHIPS / 8750:.1f} s", *shares


TABLES: tuple[Callable[[], Rows], ...] = (calibrations, both_at_once, populations, chip_rates, biases, in_operation,
                                          self_test, registers, integrators, readout, rate_response)  # fmt: skip

QUICK = (calibrations, biases, registers, readout, rate_response)  # seconds each


def printed(table: Callable[[], Rows]) -> str:
    """A table as text: columns as wide as what they hold."""
    rows = list(table())
    widths = [max(len(row[n]) for row in rows if n < len(row)) + 2 for n in range(max(map(len, rows)))]
    return "\n".join(
        "".join(f"{cell:{width}}" for cell, width in zip(row, widths, strict=False)).rstrip() for row in rows
    )


def main() -> None:
    """Print all of it, each table when it is ready."""
    for number, table in enumerate(TABLES, 1):
        print(f"{number} of {len(TABLES)} ...", end="\r", file=sys.stderr, flush=True)
        print(printed(table), end="\n\n", flush=True)


if __name__ == "__main__":
    main()
