"""Pictures of several loops: perturbations together, and margins over a parameter."""

import math
from typing import TYPE_CHECKING

import numpy as np

from proofmass.runner.analysis.margins.figures import decibels
from proofmass.runner.analysis.several.over import MarginsOver, or_nan
from proofmass.runner.analysis.several.together import Together
from proofmass.runner.output.pictures import COLOURS, INK, axis_label, sheet

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CHANGE = 1e-3  # of a curve, that is seen
YEAR = 31_557_600.0  # s


def plot_together(together: Together) -> "Figure":
    """Draw the disk margin that each frequency leaves, of all loops at once and of each alone."""
    with sheet(9.0, 4.6) as figure:
        panel = figure.subplots()
        if together.margin is None:
            panel.set_title(f"the loops are {together.verdict}", loc="left")
            return figure
        for row, name, colour in zip(together.of_each, together.loops, COLOURS * len(together.loops), strict=False):
            panel.plot(together.frequencies, 1.0 / row, "--", color=colour, label=f"{name} alone")
        panel.plot(together.frequencies, 1.0 / together.bounds, color=INK, linewidth=1.8, label="all at once")
        panel.plot([or_nan(together.frequency)], [together.margin], "o", color=INK)
        panel.set_xscale("log")
        panel.set_xlim(together.frequencies[_first(together)], together.frequencies[-1])
        panel.set_xlabel("frequency [Hz]")
        panel.set_ylabel("disk margin")
        panel.set_title(f"disk margin {together.margin:.4g} at {together.frequency:.4g} Hz", loc="left", weight="bold")
        panel.legend(loc="best")
    return figure


def _first(together: Together) -> int:
    """Return from which frequency on a picture shows something: a decade before the first change of a curve."""
    curves = np.vstack([together.of_each, together.bounds])
    moved = np.flatnonzero(np.any(np.abs(curves - curves[:, :1]) > _CHANGE * curves[:, :1], axis=0))
    before = together.frequencies[moved[0]] / 10.0 if len(moved) else together.frequencies[0]
    return int(np.searchsorted(together.frequencies, before))


def plot_over(over: MarginsOver) -> "Figure":
    """Draw gain margin, phase margin and sensitivity peak of each loop over the values; unstable ones are left out."""
    axis, factor = (axis_label(over.axis, over.unit), 1.0) if over.axis != "age" else ("age [years]", 1.0 / YEAR)
    values = np.array(over.values) * factor
    with sheet(9.0, 7.2) as figure:
        panels = figure.subplots(3, 1, sharex=True)
        for name, colour in zip(over.margins[0], COLOURS * len(over.margins[0]), strict=False):
            rows = [loops[name] for loops in over.margins]
            curves = (
                [or_nan(m.nearest_gain and m.least_gain_margin) for m in rows],
                [math.degrees(or_nan(m.phase_margin)) for m in rows],
                [or_nan(decibels(m.sensitivity_peak)) for m in rows],
            )
            for panel, curve in zip(panels, curves, strict=True):
                panel.plot(values, curve, ".-", color=colour, label=name)
            for at, margins in zip(values, rows, strict=True):
                if not margins.stable:
                    for panel in panels:
                        panel.axvline(at, color=colour, linestyle=":", linewidth=1.0)
        for panel, label in zip(
            panels, ("gain margin [dB]", "phase margin [deg]", "sensitivity peak [dB]"), strict=True
        ):
            panel.set_ylabel(label)
        panels[0].legend(loc="best")
        panels[2].set_xlabel(axis)
        if any(not margins.stable for loops in over.margins for margins in loops.values()):
            panels[0].set_title("dotted: not stable", loc="left", size=10)
    return figure
