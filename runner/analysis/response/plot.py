"""Picture of a response: gain and phase over frequency, step response, and simulation."""

from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.shown_units import as_written, in_print, prefix
from proofmass.runner.analysis.response.response import Response
from proofmass.runner.analysis.response.simulated import Simulated
from proofmass.runner.output.pictures import BLUE, INK, ORANGE, axis_label, phase_ticks, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DOT: Any = {"marker": "o", "linestyle": "none", "markersize": 4.0, "color": ORANGE}
_STEPS = 400  # values up to which an output is drawn as held


def plot_response(of: Response) -> "Figure":
    """Gain and phase on the left; on the right the step response and the simulation's error."""
    with sheet(11.0, 5.6, f"{of.output} by {of.input}") as figure:
        places = figure.add_gridspec(2, 2, width_ratios=(3, 2))
        _draw_gain(figure.add_subplot(places[0, 0]), of)
        _draw_phase(figure.add_subplot(places[1, 0]), of)
        _draw_step(figure.add_subplot(places[0, 1] if of.simulated else places[:, 1]), of)
        if of.simulated is not None:
            _draw_deviation(figure.add_subplot(places[1, 1]), of, of.simulated)
    return figure


def _draw_gain(panel: Any, of: Response) -> None:
    panel.loglog(of.frequencies, np.abs(of.gain), color=BLUE, label="linear")
    if of.simulated is not None:
        stimulus = of.simulated.stimulus
        peak = as_written(stimulus.written, stimulus.amplitude, of.simulated.input_unit, 3)
        label = f"simulated, {stimulus.kind} of {peak}"
        panel.plot(of.simulated.frequencies, np.abs(of.simulated.gain), label=label, **_DOT)
        panel.legend(loc="best")
    low, high = of.corners
    for corner, beside in ((low, -3), (high, 3)):
        if corner is not None:
            panel.axvline(corner, color=INK, linewidth=0.8, linestyle=":")
            panel.annotate(
                f"−3 dB at {in_print(corner, 'Hz', 4)}",
                (corner, 1.0),  # above the curve, which is lower from here on
                (beside, 0.0),
                xycoords=("data", "axes fraction"),
                textcoords="offset points",
                rotation=90.0,
                size=8,
                ha="left" if beside > 0 else "right",
                va="top",
            )
    panel.set_ylabel(axis_label("gain", of.unit))
    panel.set_xlabel("frequency [Hz]")
    panel.margins(x=0.01)


def _draw_phase(panel: Any, of: Response) -> None:
    phase = np.degrees(of.phase)
    panel.semilogx(of.frequencies, phase, color=BLUE)
    if of.simulated is not None:
        near = np.interp(np.log(of.simulated.frequencies), np.log(of.frequencies), phase)
        own = np.degrees(np.angle(of.simulated.gain))
        panel.plot(of.simulated.frequencies, own + 360.0 * np.round((near - own) / 360.0), **_DOT)
    panel.set_ylabel("phase [deg]")
    panel.set_xlabel("frequency [Hz]")
    panel.margins(x=0.01)
    phase_ticks(panel)


def _draw_step(panel: Any, of: Response) -> None:
    panel.set_title("step response", fontsize=9, pad=3)
    if of.step_response is None:
        panel.text(0.5, 0.5, "does not settle", transform=panel.transAxes, ha="center")
        return
    times, values = of.step_response.shown()
    factor, unit = prefix("s", float(times[-1]))
    panel.plot(factor * times, values, color=BLUE, drawstyle="steps-post" if len(times) <= _STEPS else "default")
    panel.axhline(of.step_response.figures.final, color=INK, linewidth=0.8, linestyle=":")
    panel.set_xlabel(f"time [{unit}]")
    panel.set_ylabel(axis_label("output over step", of.unit))
    panel.margins(x=0.01)


def _draw_deviation(panel: Any, of: Response, run: Simulated) -> None:
    panel.set_title("simulated less linear", fontsize=9, pad=3)
    order = np.argsort(run.frequencies)
    panel.semilogx(run.frequencies[order], run.decibels[order], "o-", markersize=3.0, color=BLUE, label="gain [dB]")
    panel.semilogx(run.frequencies[order], run.degrees[order], "s-", markersize=3.0, color=ORANGE, label="phase [deg]")
    panel.set_xlim(of.frequencies[0], of.frequencies[-1])
    panel.set_xlabel("frequency [Hz]")
    panel.set_ylabel("gain [dB], phase [deg]")
    panel.legend(loc="best")
