"""Pictures of the PN self-calibration of Sarraf et al. 2012, drawn again from the graphs, into docs/pictures.

    python -m docs.papers.pn_pictures

Their Fig. 3 and 10 (impulse responses, sensitivities, convergence), 6 (fixed against floating point), 8 and 9 (response
of the gyroscope, and of mismatched modes).
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from docs.papers.pn_runs import calibrate, library, sense_amplitude
from proofmass.runner.output.pictures import BLUE, ORANGE, save_figure
from proofmass.runner.run.simulate import simulate

PICTURES = Path(__file__).parents[1] / "pictures"
GREY = "#bbbbbb"


def calibration() -> Figure:
    """Impulse responses, their derivatives and the way to the parameters, of both devices."""
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    panels = figure.subplots(2, 3)
    for row, device, fitted, part in zip(
        panels, ("accelerometer", "gyroscope"), ("online", "gauss_newton"), ("", "below."), strict=True
    ):
        loop = calibrate(library(f"self_calibration_{device}.toml"), 16)
        measured, modelled = (loop.result[f"{name}.impulse_response"].values for name in ("cells", "reference_cells"))
        lags = np.arange(measured.shape[1])
        row[0].plot(lags, measured[-1], "o", fillstyle="none", color=BLUE, label="device")
        row[0].plot(lags, modelled[1], ".-", color=GREY, label="model at first")
        row[0].plot(lags, modelled[-1], "x", color=ORANGE, label="model at last")
        rate = float(loop.result.graph.rate or 1) / 1e3
        row[0].set(title=f"{device}: impulse response at {rate:g} kHz", xlabel="lag [chips]", ylabel="h [V]")
        derivatives = calibrate(library(f"self_calibration_{fitted}.toml"), 8).result
        for name, color in (("stiffness", BLUE), ("damping", ORANGE)):
            values = derivatives[f"{part}cells_by_{name}.impulse_response"].values[-1]
            row[1].plot(lags, values[: len(lags)], "o-", color=color, label=f"by ln {name}")
        rate = float(derivatives.graph.rate or 1) / 1e3
        row[1].set(title=f"its derivatives, at {rate:g} kHz", xlabel="lag [chips]", ylabel="dh [V]")
        for error, name, color in ((loop.stiffness, "stiffness", BLUE), (loop.damping, "damping", ORANGE)):
            row[2].plot(np.arange(1, len(error) + 1), 100.0 * error, "o-", color=color, label=name)
        row[2].set(title="error of the model", xlabel="period of 1023 chips", ylabel="[%]")
        for panel in row:
            panel.axhline(0.0, color="#dddddd", zorder=0)
            panel.set_xticks(range(0, 17, 4))
            panel.legend()
    return figure


def registers() -> Figure:
    """Step and sine through the reference model in registers and in floating point, and what is between them."""
    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    result, panels = simulate(library("fixed_against_floating.toml"), engine="compiled"), figure.subplots(1, 3)
    for panel, name, title, last in (
        (panels[0], "on_step", "step of 1 g", 2.0),
        (panels[1], "on_sine", "1 g at 90 Hz", 50.0),
    ):
        trace = result[f"{name}.fixed"]
        times = 1e3 * float(trace.period) * np.arange(len(trace.values))
        floating = result[f"{name}.floating"].values
        panel.plot(times, 1e3 * floating, color=GREY, linewidth=4.0, label="floating point")
        panel.plot(times, 1e3 * trace.values, color=BLUE, linewidth=1.2, label="registers")
        panel.set(title=title, xlabel="time [ms]", ylabel="displacement [nm]", xlim=(0.0, last))
        difference = 100.0 * (trace.values - floating) / np.abs(floating).max()
        panels[2].plot(times, difference, color=BLUE if name == "on_step" else ORANGE, linewidth=0.8, label=title)
    panels[2].set(title="difference, of the peak", xlabel="time [ms]", ylabel="[%]")
    panels[2].legend(loc="center right", bbox_to_anchor=(1.0, 0.75))
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def gyroscope() -> Figure:
    """Sense mode at rest and at rates of rotation, and what mismatch of the modes leaves."""
    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    graph, panels = library("gyroscope_rate_response.toml"), figure.subplots(1, 3)
    trace = simulate(graph, engine="compiled")["sense.displacement"]
    shown = slice(0, round(0.01 / float(trace.period)))
    panels[0].plot(1e3 * trace.times[shown], 1e12 * trace.values[shown], color=BLUE, linewidth=0.4)
    panels[0].set(title="sense mode from rest, at 1 deg/s", xlabel="time [ms]", ylabel="displacement [pm]")
    rates = np.array([0.0, 25.0, 50.0, 75.0, 100.0])
    for stiffness, color, name in ((122.28, BLUE, "tuned"), (1.05 * 122.28, ORANGE, "5 % from tuned")):
        changes: list[dict[str, Any]] = [
            {"rotation.value": np.radians(rate), "sense.stiffness": stiffness} for rate in rates.tolist()
        ]
        moved = [1e9 * sense_amplitude(graph.with_parameters(change)) for change in changes]
        panels[1].plot(rates, moved, "o-", color=color, label=name)
    panels[1].set(title="response to rotation", xlabel="rate [deg/s]", ylabel="amplitude [nm]")
    panels[1].legend()
    percents = np.array([-10.0, -7.5, -5.0, -3.0, -2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.5, 10.0])
    stiffnesses = 122.28 * (1.0 + percents / 100.0)
    amplitudes = [1e12 * sense_amplitude(graph.with_parameters({"sense.stiffness": k})) for k in stiffnesses.tolist()]
    w = 2.0 * np.pi * 7977.51
    fine = 122.28 * np.linspace(0.9, 1.1, 401)
    force = 2.0 * 48.67e-9 * np.radians(1.0) * w * 5e-6
    panels[2].plot(fine / 1.2228 - 100.0, 1e12 * force / np.abs(fine - 48.67e-9 * w * w + 57e-6j * w), color=GREY,
                   label="closed form")  # fmt: skip
    panels[2].plot(percents, amplitudes, "o", color=BLUE, fillstyle="none", label="graph")
    panels[2].set(title="modes out of tune, at 1 deg/s", xlabel="sense stiffness, from tuned [%]",
                  ylabel="amplitude [pm]")  # fmt: skip
    panels[2].legend()
    return figure


def main() -> None:
    """Draw all three."""
    for name, draw in (("self_calibration", calibration), ("registers", registers), ("gyroscope", gyroscope)):
        save_figure(draw(), PICTURES / f"pn_{name}.png")


if __name__ == "__main__":
    main()
