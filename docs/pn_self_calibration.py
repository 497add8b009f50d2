"""The PN self-calibration of Sarraf et al. 2012: what the paper reports beside what the graphs of the library do.

    python -m docs.pn_self_calibration [PICTURE]

Labels: [P] the paper prints it; [A] follows under assumed gains, converters and noise, which it does not print;
[C] a conjecture about what it means.
"""

import sys
from importlib.resources import as_file, files
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from proofmass.graphs.graph import Graph
from proofmass.graphs.toml_reader import read_graph
from proofmass.runner.engine.result import Result
from proofmass.runner.engine.simulate import simulate
from proofmass.runner.output.plot import BLUE, ORANGE, save_figure

CHIPS = 1023
IDEAL = {"amplifier.density": 0.0, "adc.bits": 32, "volts.gain": 10.0 / 2**31}  # no noise, no visible rounding
DEVICES = {"accelerometer": ("accelerometer", 51.48, 4.57e-3), "gyroscope": ("sense", 137.7, 7.12e-5)}


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
    with as_file(files("proofmass.graphs") / "library" / name) as path:
        return read_graph(path)


def calibrate(graph: Graph, periods: int, seed: int | None = None) -> Calibration:
    """Run a self-calibration for so many periods and compare its parameters with those of its device."""
    result = simulate(graph, samples=CHIPS * periods + 1, seed=seed, engine="compiled")
    stiffness, damping = (
        next(result[name].values for name in (f"{value}.{value}", f"controller.{value}") if name in result)
        for value in ("stiffness", "damping")
    )
    device: Any = next(graph.blocks[name] for name, _, _ in DEVICES.values() if name in graph.blocks)
    every = (len(stiffness) - 1) // periods
    return Calibration(stiffness[every::every] / device.stiffness - 1.0, damping[1:] / device.damping - 1.0, result)


def sense_amplitude(graph: Graph) -> float:
    """Amplitude of the sense mode in the steady state: least squares of sine and cosine at the drive's frequency."""
    trace = simulate(graph, engine="compiled")["sense.displacement"]
    drive: Any = graph.blocks["drive_velocity"]
    settled = len(trace.values) * 2 // 3
    angle = 2.0 * np.pi * drive.frequency * float(trace.period) * np.arange(settled, len(trace.values))
    waves = np.stack([np.sin(angle), np.cos(angle)], axis=1)
    return float(np.hypot(*np.linalg.lstsq(waves, trace.values[settled:])[0]))


def table() -> list[str]:
    """Every number of the paper that the graphs give, a line each."""
    rows = [("", "paper", "here, ideal", "here, 12 bit and 5 mV")]
    for device, (_, stiffness, damping) in DEVICES.items():
        graph = library(f"self_calibration_{device}.toml")
        ideal, noisy = calibrate(graph.with_parameters(IDEAL), 32), calibrate(graph, 64)
        settled = [1.0 + float(error[32:].mean()) for error in (noisy.stiffness, noisy.damping)]
        exact = [1.0 + float(error[-1]) for error in (ideal.stiffness, ideal.damping)]
        for number, (name, truth, unit) in enumerate((("stiffness", stiffness, "N/m"), ("damping", damping, "kg/s"))):
            values = (f"{truth * factor:.6g} {unit}" for factor in (exact[number], settled[number]))
            rows.append((f"{device}, {name}", f"{truth:g} {unit} [P]", *values))
        for percent in (1.0, 0.1):
            spent = "{} and {}".format(*ideal.periods_to(percent / 100.0))
            rows.append((f"{device}, periods to {percent:g} %", "damping takes more [P]", spent, "[A]"))
    graph = library("gyroscope_rate_response.toml")
    tuned = sense_amplitude(graph)
    fabricated = sense_amplitude(graph.with_parameters({"sense.stiffness": 132.23}))
    mismatched = sense_amplitude(graph.with_parameters({"sense.stiffness": 1.05 * 122.28}))
    rows += [
        ("sense mode at 1 deg/s, tuned", "143.7 nm [P]", f"{1e12 * tuned:.1f} pm", ""),
        ("as in the paper's table 2", "", f"{1e12 * fabricated:.1f} pm", ""),
        ("5 % of stiffness from tuned", "0.387 of it [P]", f"{mismatched / tuned:.3f} of it [C]", ""),
    ]
    return ["{:<36} {:<24} {:<16} {}".format(*row).rstrip() for row in rows]


def picture() -> Figure:
    """Impulse responses, their derivatives and the way to the parameters, of both devices."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    panels = figure.subplots(2, 3)
    for row, (device, fitted) in zip(panels, (("accelerometer", "online"), ("gyroscope", "gauss_newton")), strict=True):
        loop = calibrate(library(f"self_calibration_{device}.toml"), 16)
        measured, modelled = (loop.result[f"{name}.impulse_response"].values for name in ("cells", "reference_cells"))
        lags = np.arange(measured.shape[1])
        row[0].plot(lags, measured[-1], "o", fillstyle="none", color=BLUE, label="device")
        row[0].plot(lags, modelled[1], ".-", color="#bbbbbb", label="model at first")
        row[0].plot(lags, modelled[-1], "x", color=ORANGE, label="model at last")
        row[0].set(
            title=f"{device}: impulse response at {float(loop.result.graph.rate or 1) / 1e3:g} kHz",
            xlabel="lag [chips]",
            ylabel="h [V]",
        )
        derivatives = calibrate(library(f"self_calibration_{fitted}.toml"), 8).result
        for name, color in (("stiffness", BLUE), ("damping", ORANGE)):
            values = derivatives[f"cells_by_{name}.impulse_response"].values[-1]
            row[1].plot(lags, values[: len(lags)], "o-", color=color, label=f"by ln {name}")
        row[1].set(
            title=f"its derivatives, at {float(derivatives.graph.rate or 1) / 1e3:g} kHz",
            xlabel="lag [chips]",
            ylabel="dh [V]",
        )
        for error, name, color in ((loop.stiffness, "stiffness", BLUE), (loop.damping, "damping", ORANGE)):
            row[2].plot(np.arange(1, len(error) + 1), 100.0 * error, "o-", color=color, label=name)
        row[2].set(title="error of the model", xlabel="period of 1023 chips", ylabel="[%]")
        for panel in row:
            panel.axhline(0.0, color="#dddddd", zorder=0)
            panel.set_xticks(range(0, 17, 4))
            panel.legend()
    return figure


def main(arguments: list[str]) -> int:
    """Print the table; draw the picture where a file for it is named."""
    print("\n".join(table()))
    if arguments:
        save_figure(picture(), Path(arguments[0]))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
