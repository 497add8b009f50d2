"""Pictures of a loop: Bode, Nyquist and step response in one; and which parameters move what."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from proofmass.blocks.declaration.shown_units import in_print, prefix
from proofmass.runner.analysis.linearisation.phase import counted_phase
from proofmass.runner.analysis.margins.frequencies import sweep
from proofmass.runner.analysis.margins.margins import Margins
from proofmass.runner.analysis.margins.sensitivity import Sensitivity
from proofmass.runner.analysis.margins.step import shown_step
from proofmass.runner.host.arrays import Array, Complex
from proofmass.runner.output.pictures import BLUE, GRID, INK, ORANGE, name_rows, phase_ticks, sheet
from proofmass.runner.output.plot import envelope

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_STRETCHES, _MOST_BARS = 2000, 15
_SHOWN = 1e-3  # of a margin, to which a picture shows it
_NEAR_END = 0.85  # of an axis, from where on texts stand to the left
_NYQUIST = 2.0  # largest part of L that a Nyquist diagram shows at least
_BEYOND = 1.1
_WIDEST_DISK = 1.99  # beyond it the disk is a half plane


def plot_margins(margins: Margins) -> "Figure":
    """Magnitude and phase of L, L in the complex plane, and the closed loop's answer to a step at the wire."""
    with sheet(11.0, 7.2, _title(margins)) as figure:
        panels = figure.subplot_mosaic([["magnitude", "nyquist"], ["phase", "step"]])
        w = sweep(margins.system)
        response = margins.system.response(w)
        _draw_bode(margins, panels["magnitude"], panels["phase"], w / (2.0 * math.pi), response)
        _draw_nyquist(panels["nyquist"], response, margins.disk_margin, _reach(margins))
        _draw_step(margins, panels["step"])
    return figure


def plot_sensitivities(sensitivities: list[Sensitivity]) -> "Figure":
    """A tornado for each quantity: its change when a parameter grows by one percent, the strongest on top."""
    drawn = [
        (quantity, [e for e in quantity.effects if e.of_one_percent is not None][:_MOST_BARS])
        for quantity in sensitivities
    ]
    heights = [0.8 + 0.24 * max(len(effects), 1) for _, effects in drawn]
    with sheet(9.0, sum(heights) + 0.5) as figure:
        panels = figure.subplots(len(drawn), 1, squeeze=False, height_ratios=heights)[:, 0]
        for panel, (quantity, effects) in zip(panels, drawn, strict=True):
            changes = [effect.of_one_percent or 0.0 for effect in effects]
            factor, unit = prefix(quantity.unit, max(map(abs, changes), default=0.0))
            colours = [BLUE if change > 0.0 else ORANGE for change in changes]
            panel.barh(range(len(effects)), [change * factor for change in changes], color=colours, height=0.7)
            if not effects:
                panel.text(0.5, 0.5, "no parameter moves it", transform=panel.transAxes, ha="center", va="center")
                panel.set_xticks([])
            else:
                panel.axvline(0.0, color=INK, linewidth=0.8)
            name_rows(panel, [effect.parameter for effect in effects])
            panel.set_xlabel(f"change for +1 % [{unit}]" if effects else "")
            size, scaled = prefix(quantity.unit, abs(quantity.value))
            named = f"{quantity.quantity} {quantity.value * size:.6g} {scaled if scaled != '1' else ''}"
            panel.set_title(named, loc="left", size=10)
    return figure


def _title(margins: Margins) -> str:
    if not margins.stable:
        return f"{margins.loop}: unstable"
    parts = {
        "gain margin": margins.nearest_gain and f"{margins.least_gain_margin:.2f} dB",
        "phase margin": margins.phase_margin and f"{math.degrees(margins.phase_margin):.1f}°",
        "delay margin": margins.delay_margin and in_print(margins.delay_margin, "s"),
    }
    return f"{margins.loop}: " + ", ".join(f"{name} {value}" for name, value in parts.items() if value)


def _draw_bode(margins: Margins, magnitude: "Axes", phase: "Axes", hertz: Array, response: Complex) -> None:
    size = 20.0 * np.log10(np.maximum(np.abs(response), 1e-15))
    angle = np.degrees(counted_phase(margins.system.response, 2.0 * math.pi * hertz, response))
    for panel, values in ((magnitude, size), (phase, angle)):
        panel.semilogx(hertz, values, color=BLUE)
        panel.set_xlim(hertz[0], hertz[-1])
        panel.set_xlabel("frequency [Hz]")
    magnitude.set_ylabel("|L| [dB]")
    phase.set_ylabel("phase of L [deg]")
    magnitude.axhline(0.0, color=INK, linewidth=0.8)
    magnitude.set_ylim(max(size.min(), -120.0) - 5.0, min(size.max(), 120.0) + 5.0)
    for turn in range(math.floor(angle.min() / 360.0), math.ceil(angle.max() / 360.0) + 1):
        if angle.min() <= 360.0 * turn - 180.0 <= angle.max():
            phase.axhline(360.0 * turn - 180.0, color=INK, linewidth=0.8)
    low, high = max(angle.min(), -1080.0), min(angle.max(), 720.0)
    phase.set_ylim(min(low, -190.0) - 10.0, max(high, -80.0) + 10.0)
    phase_ticks(phase)
    bottom, top = magnitude.get_ylim()
    step = 20.0 if top - bottom < 150.0 else 40.0
    magnitude.set_yticks(np.arange(math.ceil(bottom / step), math.floor(top / step) + 1) * step)
    point: Any = {"color": ORANGE, "linestyle": "", "clip_on": False, "zorder": 5}
    at = np.array(margins.gain_crossovers)
    if len(at):
        magnitude.plot(at, np.zeros(len(at)), marker="o", markersize=5, label="|L| = 1", **point)
        phase.plot(at, np.interp(at, hertz, angle), marker="o", markersize=5, label="|L| = 1", **point)
    at = np.array(margins.phase_crossovers)
    level = np.interp(at, hertz, size) if len(at) else at
    at, level = at[level > bottom], level[level > bottom]  # not those in a notch below the picture
    if len(at):
        magnitude.plot(at, level, marker="s", markersize=4, label="L < 0", **point)
    factor, lag = margins.nearest_gain, margins.phase_margin
    phases = np.abs(margins.gain_crossover_phases).tolist()
    if factor and (place := _crossover(margins.phase_crossovers, margins.phase_crossover_gains, 1.0 / factor)):
        level = -20.0 * math.log10(factor)
        _distance(magnitude, place, 0.0, level, f"{margins.least_gain_margin:.1f} dB", "left")
    if lag and (place := _crossover(margins.gain_crossovers, phases, lag)):
        value = float(np.interp(place, hertz, angle))
        line = 360.0 * round((value + 180.0) / 360.0) - 180.0
        _distance(phase, place, line, value, f"{math.degrees(lag):.1f}°", "right")
    for panel in (magnitude, phase):
        if panel.get_legend_handles_labels()[0]:
            panel.legend(loc="best")


def _crossover(frequencies: Sequence[float], values: Sequence[float], wanted: float) -> float | None:
    """Return the frequency at which a value is the one wanted, as exactly as a picture shows."""
    off = [abs(value - wanted) for value in values]
    best = min(off, default=math.inf)
    return frequencies[off.index(best)] if best <= _SHOWN * wanted else None


def _distance(panel: "Axes", place: float, first: float, last: float, text: str, side: str) -> None:
    """Draw a margin as the distance from its line to the curve, its text beyond the line, where the curve is not."""
    panel.annotate(
        "", (place, last), (place, first), arrowprops={"arrowstyle": "<->", "color": ORANGE, "shrinkA": 0, "shrinkB": 0}
    )
    low, high = panel.get_xlim()
    if side == "left" and math.log(place / low) > _NEAR_END * math.log(high / low):  # little room
        side = "right"
    up = 1.0 if first > last else -1.0
    panel.annotate(
        text,
        (place, first),
        (0.0, 3.0 * up),
        textcoords="offset points",
        ha=side,
        va="bottom" if first > last else "top",
        color=ORANGE,
    )


def _reach(margins: Margins) -> float:
    """Return how far a Nyquist diagram goes: of a loop that is not stable beyond its first crossing behind -1."""
    behind = [] if margins.stable else [gain for gain in margins.phase_crossover_gains if gain > 1.0]
    return max(_NYQUIST, _BEYOND * min(behind, default=0.0))


def _draw_nyquist(panel: "Axes", response: Complex, disk: float | None, reach: float) -> None:
    if disk is not None and disk < _WIDEST_DISK:  # L stays out of the disk whose ends on the real axis are these
        ends = -(2.0 + disk) / (2.0 - disk), -(2.0 - disk) / (2.0 + disk)
        round_it = np.exp(1j * np.linspace(0.0, 2.0 * math.pi, 200)) * (ends[1] - ends[0]) / 2.0 + sum(ends) / 2.0
        panel.plot(round_it.real, round_it.imag, color=ORANGE, linewidth=1.0, label=f"disk margin {disk:.3g}")
    panel.plot(response.real, response.imag, color=BLUE)
    panel.plot(response.real, -response.imag, "--", color=BLUE, label="negative frequencies")
    turn = np.linspace(0.0, 2.0 * math.pi, 200)
    panel.plot(np.cos(turn), np.sin(turn), color=GRID)
    panel.plot([-1.0], [0.0], "+", color=ORANGE, markersize=10, markeredgewidth=2)
    panel.set_xlim(-1.25 * reach, 0.75 * reach)
    panel.set_ylim(-reach, reach)
    panel.set_aspect("equal", adjustable="box")
    panel.set_xlabel("real part of L")
    panel.set_ylabel("imaginary part of L")
    panel.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, borderpad=0.0)  # curves are everywhere inside


def _draw_step(margins: Margins, panel: "Axes") -> None:
    times, values = shown_step(margins)
    drawn = envelope(values, _STRETCHES)
    factor, unit = prefix("s", float(times[-1]))
    style = "default" if margins.system.continuous else "steps-post"
    panel.plot(times[drawn] * factor, values[drawn], color=BLUE, drawstyle=style)
    panel.axhline(1.0, color=INK, linewidth=0.8)
    panel.set_xlabel(f"time [{unit}]")
    panel.set_ylabel("step response of L / (1 + L)")
